"""A finished run for other programs: every variable in a table, streamlines for ParaView.

Nothing here knows a variable by its name but the coordinates of a point of a streamline: what the
results hold is sorted by its dimensions.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from fibermelt.engine.files import (
    digest,
    read_sealed,
    refuse_no_parent,
    remove_leftovers,
    replace_folder,
    storage_errors,
    write_sealed,
    write_through,
)
from fibermelt.engine.finished import read_finished
from fibermelt.engine.schema import SCHEMA
from fibermelt.errors import StoreError, legible_path
from fibermelt.flow.vtp import polylines

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

__all__ = ["CONTENTS", "LINES", "NUMBERS", "export_run", "streamlines_vtp", "tables"]

CONTENTS = "export.json"
"""The file of an exported folder that says what is in it, by which it is known for ours."""

NUMBERS = "numbers"
"""The table of what there is one of."""

LINES = "streamlines.vtp"

DIRECTIONS = ("component", "row", "column", "axis", "other_axis")
"""Dimensions over x, y and z: columns of a table, not rows."""

LINE, POINT = "streamline", "point"
"""Dimensions of what is known along streamlines."""

PLACE, VELOCITY = ("x", "y", "z"), ("u", "v", "w")
"""Variables that are a point's coordinates and velocity; in the plane without the last."""


@dataclass(frozen=True, eq=False)
class Table:
    """A table of results.

    Parameters
    ----------
    name : str
        The dimensions that its rows are over: ``streamline-zone``.
    columns : dict
        What stands in it, by name, each of the same length.
    about : dict
        Unit and meaning of each column, by the same names.
    """

    name: str
    columns: Mapping[str, NDArray[Any]]
    about: Mapping[str, tuple[str, str]]

    def csv(self) -> bytes:
        """Return it as CSV in UTF-8: a head with units in brackets, empty where there is none."""
        heads = [f"{name} [{unit}]" if unit else name for name, (unit, _) in self.about.items()]
        frame = pd.DataFrame(dict(zip(heads, self.columns.values(), strict=True)))
        written: str = frame.to_csv(index=False, lineterminator="\n")
        return written.encode()


def tables(results: xr.Dataset) -> Iterator[Table]:
    """Yield every variable of a dataset in a table, each over the same dimensions in one.

    A row for each combination of the labels of its dimensions, or numbers from 0 where these have
    none; x, y and z parts of a vector or a tensor stand beside one another. What there is one of
    stands in a table of its own, `NUMBERS`, with a row for each.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.
    """
    alike: dict[frozenset[Hashable], list[str]] = {}
    for name, variable in results.variables.items():
        if variable.dims != (name,):  # labels stand in every table that they label
            dims = frozenset(variable.dims) - frozenset(DIRECTIONS)
            alike.setdefault(dims, []).append(str(name))
    yield _numbers(results, alike.pop(frozenset(), []))
    for names in alike.values():
        yield _table(results, names)


def _table(results: xr.Dataset, names: Sequence[str]) -> Table:
    """Return the table of variables that have the same dimensions, the directions apart."""
    dims = [str(dim) for dim in results[names[0]].dims if dim not in DIRECTIONS]
    shape = tuple(results.sizes[dim] for dim in dims)
    columns: dict[str, NDArray[Any]] = {}
    about: dict[str, tuple[str, str]] = {}
    for axis, dim in enumerate(dims):
        along = tuple(-1 if k == axis else 1 for k in range(len(dims)))
        columns[dim] = np.broadcast_to(_labels(results, dim).reshape(along), shape).ravel()
        about[dim] = _about(results, dim) if dim in results.variables else ("", "number, from 0")
    for name in names:
        inner = [str(dim) for dim in results[name].dims if dim in DIRECTIONS]
        values = results[name].transpose(*dims, *inner).to_numpy()
        for place in np.ndindex(*values.shape[len(dims) :]):
            part = "".join("xyz"[k] for k in place)
            column = f"{name}_{part}" if part else name
            columns[column] = values[(..., *place)].ravel()
            about[column] = _about(results, name)
    return Table("-".join(dims), columns, about)


def _numbers(results: xr.Dataset, names: Sequence[str]) -> Table:
    """Return what there is one of, a row for each, and for each part of a vector."""
    rows = []
    for name in names:
        unit, meaning = _about(results, name)
        values = results[name].to_numpy()
        for place in np.ndindex(*values.shape):
            part = "".join("xyz"[k] for k in place)
            rows.append((f"{name}_{part}" if part else name, values[place], unit, meaning))
    about = {
        "name": ("", "name of the variable"),
        "value": ("", "its value"),
        "unit": ("", "its unit; empty for a pure number"),
        "meaning": ("", "what it is"),
    }
    columns = zip(*rows, strict=True) if rows else ((), (), (), ())
    found = {
        name: np.array(column, dtype=object) for name, column in zip(about, columns, strict=True)
    }
    return Table(NUMBERS, found, about)


def _labels(results: xr.Dataset, dim: str) -> NDArray[Any]:
    return results[dim].to_numpy() if dim in results.variables else np.arange(results.sizes[dim])


def _about(results: xr.Dataset, name: str) -> tuple[str, str]:
    """Return unit, empty for a pure number, and meaning of a variable."""
    attributes = results[name].attrs
    unit = str(attributes.get("units", "1"))
    return "" if unit == "1" else unit, str(attributes.get("long_name", ""))


def streamlines_vtp(results: xr.Dataset) -> bytes | None:
    """Return streamlines with all that is known at their points as polygonal data of VTK.

    Velocity and place are vectors, the velocity gradient has the nine components of space; what
    depends on a fiber's direction at the inlet, or on a share of fibers, has a component for each.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.

    Returns
    -------
    bytes or None
        None where the results have no streamlines.
    """
    if not all(name in results for name in (*PLACE[:2], LINE)):
        return None

    def vectors(names: Sequence[str]) -> NDArray[np.float64]:
        shape = (results.sizes[LINE], results.sizes[POINT])
        parts = [
            results[name].transpose(LINE, POINT).to_numpy() if name in results else np.zeros(shape)
            for name in names
        ]
        return np.stack(parts, axis=-1)

    at_points: dict[str, tuple[NDArray[np.generic], Sequence[str]]] = {}
    of_lines: dict[str, tuple[NDArray[np.generic], Sequence[str]]] = {}
    if VELOCITY[0] in results:
        at_points["velocity"] = vectors(VELOCITY), "xyz"
    for key, variable in results.variables.items():
        name, dims = str(key), variable.dims
        if variable.dtype.kind not in "fi" or name in {*PLACE, *VELOCITY}:
            continue
        if {LINE, POINT} <= set(dims):
            at_points[name] = _components(results, name)
        elif dims == (LINE,):
            of_lines[name] = variable.to_numpy(), ()
    return polylines(vectors(PLACE), at_points, of_lines)


def _components(results: xr.Dataset, name: str) -> tuple[NDArray[np.generic], list[str]]:
    """Return values at the points (line, point[, k]), and what their k components are called."""
    inner = [str(dim) for dim in results[name].dims if dim not in {LINE, POINT}]
    values = results[name].transpose(LINE, POINT, *inner).to_numpy()
    if not inner:
        return values, []
    called: list[list[str]] = []
    for axis, dim in enumerate(inner, start=2):
        if dim in DIRECTIONS:
            missing = 3 - values.shape[axis]  # VTK's vectors and tensors are those of space
            values = np.pad(values, [(0, missing if k == axis else 0) for k in range(values.ndim)])
            called.append(["x", "y", "z"])
        else:
            unit = _about(results, dim)[0] if dim in results.variables else ""
            called.append(
                [
                    f"{label:.6g} {unit}".rstrip()
                    if np.issubdtype(type(label), np.number)
                    else str(label)
                    for label in _labels(results, dim)
                ]
            )
    between = "" if set(inner) <= set(DIRECTIONS) else ", "
    return values.reshape(*values.shape[:2], -1), [between.join(one) for one in product(*called)]


def export_run(directory: Path, to: Path) -> dict[str, Any]:
    """Write a finished run as CSV tables and a VTP file, whole or not at all.

    Parameters
    ----------
    directory : Path
        The results folder.
    to : Path
        The folder to write; one that an earlier export wrote is replaced.

    Returns
    -------
    dict
        ``"folder"``; ``"files"``: their names; ``"bytes"``: what they take.

    Raises
    ------
    StoreError
        If there is no finished run, or ``to`` cannot be written: it holds what no export wrote, or
        what was changed since.
    """
    finished = read_finished(directory)
    refuse_no_parent(to)
    _refuse_foreign(to)
    remove_leftovers(to.parent)
    sizes: dict[str, int] = {}

    def write(folder: Path) -> None:
        files: dict[str, Any] = {}

        def put(name: str, data: bytes, about: Mapping[str, Any]) -> None:
            write_through(folder / name, data)
            sizes[name] = len(data)
            files[name] = {"sha256": digest(data), **about}

        folder.mkdir()
        for table in tables(finished.results):
            columns = [
                {"name": name, "unit": unit, "meaning": meaning}
                for name, (unit, meaning) in table.about.items()
            ]
            rows = len(next(iter(table.columns.values())))
            put(f"{table.name}.csv", table.csv(), {"rows": rows, "columns": columns})
        lines = streamlines_vtp(finished.results)
        if lines is not None:
            put(LINES, lines, {})
        write_sealed(folder / CONTENTS, {"schema": SCHEMA, "run": finished.run, "files": files})

    replace_folder(to, write)
    return {"folder": str(to), "files": list(sizes), "bytes": sum(sizes.values())}


def _refuse_foreign(to: Path) -> None:
    """Refuse to replace what no export wrote, or what somebody has changed."""
    shown = legible_path(to)
    with storage_errors(to):
        if not to.exists():
            return
        if not to.is_dir():
            msg = f"{shown}: is a file, not a folder; name another with --to"
            raise StoreError(msg)
        there = sorted(path.relative_to(to).as_posix() for path in to.rglob("*"))
    if not there:
        return
    try:
        written = read_sealed(to / CONTENTS)["files"] if CONTENTS in there else {}
    except (ValueError, KeyError):
        written = {}
    for name in there:
        if name != CONTENTS and name not in written:
            msg = (
                f"{shown}: holds {name}, which no fibermelt export wrote; it is not overwritten: "
                "name another folder with --to, or move it away"
            )
            raise StoreError(msg)
        with storage_errors(to / name):
            if name in written and digest((to / name).read_bytes()) != written[name]["sha256"]:
                msg = (
                    f"{legible_path(to / name)}: was changed since it was written; it is not "
                    "overwritten: name another folder with --to, or move it away"
                )
                raise StoreError(msg)
