"""The numbers of all cases of a sweep as one labelled dataset over the sweep's axes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from fibermelt.engine.files import (
    refuse_no_parent,
    replace_file,
    replace_folder,
    storage_errors,
)
from fibermelt.engine.netcdf import to_bytes
from fibermelt.engine.parameters import Declaration, declarations
from fibermelt.engine.schema import SCHEMA
from fibermelt.engine.toml import resolved_toml
from fibermelt.errors import ConfigError, StoreError, legible
from fibermelt.study.config import Config
from fibermelt.sweeps.collection import Reduced
from fibermelt.sweeps.store import Asked, CaseStore, damaged_batch, read_asked

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["SUFFIXES", "collect_sweep", "write_csv", "write_netcdf", "write_zarr"]

SUFFIXES = (".nc", ".nc4", ".h5", ".hdf5", ".csv")
"""What `fibermelt collect --to` can end in: netCDF-4, which is HDF5, and a table."""

Found = dict[str, tuple[tuple[str, ...], "NDArray[Any]", dict[str, Any]]]
"""Variables: dimensions, values, attributes."""


def collect_sweep(directory: Path) -> xr.Dataset:
    """Return the numbers of a sweep.

    Of a grid the dimensions are its axes, by their keys (``fiber.aspect_ratio``); of any other
    design there is one, ``case``. What varies is a coordinate along them. A case that failed, or is
    not finished, is NaN, an empty text where there is text; ``status`` and ``reason`` tell why.

    Parameters
    ----------
    directory : Path
        The results folder.

    Raises
    ------
    StoreError
        If it holds no sweep, or a file in it is damaged.
    """
    cases = CaseStore(directory)
    asked = read_asked(cases)
    dimensions, shape = asked.sweep.dimensions, asked.sweep.shape
    found = _numbers(cases, [case.result for case in asked.cases])
    if cases.damaged:
        raise damaged_batch(cases.damaged[0])
    found |= _status(cases, asked)
    variables: dict[str, Any] = {}
    for name, (dims, values, about) in sorted(found.items()):
        if dims[:1] == ("case",):
            over = values.reshape(*shape, *values.shape[1:])
            variables[name] = ((*dimensions, *dims[1:]), over, about)
        else:
            variables[name] = (dims, values, about)
    dataset = xr.Dataset(variables, coords=_coordinates(asked))
    dataset.attrs = {
        "title": f"fibermelt sweep {legible(asked.study.name)}",
        "schema": SCHEMA,
        "config": resolved_toml(asked.study.config, "The study that was swept, in SI."),
        "sweep": json.dumps(asked.study.sweep),
    }
    return dataset


HDF5 = b"\x89HDF\r\n\x1a\n"
"""How a netCDF-4 file begins."""

ZARR = (".zgroup", "zarr.json")
"""What a Zarr folder holds, of format 2 or 3."""


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset as netCDF-4, whole or not at all.

    Raises
    ------
    StoreError
        If it cannot be written, its folder is not there, or a file is that holds something else.
    """
    refuse_no_parent(path)
    with storage_errors(path):
        if path.exists() and _start_of(path, len(HDF5)) != HDF5:
            msg = f"{path}: is there and no dataset; it is not overwritten: name another with --to"
            raise StoreError(msg)
    replace_file(path, to_bytes(dataset))


def write_csv(dataset: xr.Dataset, path: Path) -> None:
    """Write what a dataset has one value of in each case as a table, whole or not at all.

    A line for each case: what varies, then the variables by name, in SI. Variables over anything
    else, such as streamlines, are left out; netCDF has them.

    Raises
    ------
    StoreError
        If it cannot be written, its folder is not there, or a file is that holds something else.
    """
    refuse_no_parent(path)
    with storage_errors(path):
        if path.exists() and not _is_table(path):
            msg = (
                f"{path}: is there and no such table; it is not overwritten: name another with --to"
            )
            raise StoreError(msg)
    over = set(dataset["status"].dims)
    single = [name for name, values in dataset.data_vars.items() if set(values.dims) == over]
    coordinates = [name for name, values in dataset.coords.items() if set(values.dims) <= over]
    frame = dataset[single].to_dataframe().reset_index()
    table = frame[[*coordinates, *sorted(single, key=str)]]
    replace_file(path, table.to_csv(index=False, lineterminator="\n").encode())


def write_zarr(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset as a Zarr folder of format 2, whole or not at all.

    Raises
    ------
    ConfigError
        If zarr is not installed.
    StoreError
        If it cannot be written, its folder is not there, or something is there that is no Zarr.
    """
    if find_spec("zarr") is None:
        msg = (
            '--zarr needs the package zarr: pip install "fibermelt[zarr]", or leave it away for '
            "netCDF"
        )
        raise ConfigError(msg)
    refuse_no_parent(path)
    with storage_errors(path):
        if path.exists() and not any((path / name).is_file() for name in ZARR):
            msg = f"{path}: is there and no Zarr; it is not overwritten: name another with --to"
            raise StoreError(msg)

    def write(folder: Path) -> None:
        # Format 3 has no settled way to store texts, as zarr warns.
        dataset.to_zarr(folder, mode="w", consolidated=True, zarr_format=2)

    replace_folder(path, write)


def _is_table(path: Path) -> bool:
    """Return whether a file begins as `write_csv` begins one: with what every table names."""
    with path.open("rb") as stream:
        return {b"status", b"reason"} <= set(stream.readline().strip().split(b","))


def _start_of(path: Path, count: int) -> bytes:
    with path.open("rb") as stream:
        return stream.read(count)


def _numbers(cases: CaseStore, results: Sequence[str]) -> Found:
    """Return the variables of all batches over ``case``, with what is missing as NaN."""
    rows: dict[str, list[int]] = {}
    for row, result in enumerate(results):
        rows.setdefault(result, []).append(row)
    batches = []
    for batch in cases.batches():
        # A case may be in two files: then its numbers are the same, and the first are taken.
        own = [(k, rows.pop(key)) for k, key in enumerate(batch.keys) if key in rows]
        if own:
            at = np.array([place for place, targets in own for _ in targets])
            to = np.array([target for _, targets in own for target in targets])
            batches.append((batch.variables, at, to))
    sizes, labels = _extents([variables for variables, _, _ in batches])
    found: Found = {
        name: ((name,), np.array(list(values)), about) for name, (values, about) in labels.items()
    }
    for variables, at, to in batches:
        for name, kept in variables.items():
            if name in labels:
                continue
            own_dims = kept.dimensions[1:]
            if name not in found:
                shape = (len(results), *(sizes[dim] for dim in own_dims))
                about = {"units": kept.units, "long_name": kept.long_name}
                found[name] = (kept.dimensions, _nothing(kept.values.dtype, shape), about)
            places = [
                np.array([labels[dim][0][value] for value in variables[dim].values.tolist()])
                if dim in labels
                else np.arange(size)
                for dim, size in zip(own_dims, kept.values.shape[1:], strict=True)
            ]
            found[name][1][np.ix_(to, *places)] = kept.values[at]
    return found


def _extents(
    batches: Sequence[Reduced],
) -> tuple[dict[str, int], dict[str, tuple[dict[Any, int], dict[str, str]]]]:
    """Return the size of every dimension, and the places of its labels, over all batches."""
    labels: dict[str, tuple[dict[Any, int], dict[str, str]]] = {}
    orders: dict[str, set[tuple[Any, ...]]] = {}
    sizes: dict[str, int] = {}
    for variables in batches:
        for name, kept in variables.items():
            for dim, size in zip(kept.dimensions, kept.values.shape, strict=True):
                sizes[dim] = max(sizes.get(dim, 0), size)
            if kept.is_label(name):
                about = {"units": kept.units, "long_name": kept.long_name}
                values, _ = labels.setdefault(name, ({}, about))
                orders.setdefault(name, set()).add(tuple(kept.values.tolist()))
                values.update(dict.fromkeys(kept.values.tolist(), 0))
    for name, (values, about) in labels.items():
        # In the order that all cases have; where they differ, in one that no case decides.
        ordered = list(values) if len(orders[name]) == 1 else sorted(values)
        labels[name] = ({value: place for place, value in enumerate(ordered)}, about)
        sizes[name] = len(ordered)
    return sizes, labels


def _nothing(dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Return an array of what stands for a missing case."""
    if dtype.kind in "OUST":
        return np.full(shape, "", dtype=object)
    return np.full(shape, np.nan)


def _status(cases: CaseStore, asked: Asked) -> Found:
    """Return what became of every case, and why."""
    failures = cases.failures()
    done = {key for keys in cases.batch_results().values() for key in keys}
    status, reason = [], []
    for case in asked.cases:
        failure = None if case.result in done else asked.failure(case, failures)
        status.append("done" if case.result in done else "failed" if failure else "pending")
        reason.append(failure.reason if failure else "")
    told = {"units": "1", "long_name": "what became of the case: done, failed or pending"}
    why = {"units": "1", "long_name": "why the case failed"}
    return {
        "status": (("case",), np.array(status, dtype=object), told),
        "reason": (("case",), np.array(reason, dtype=object), why),
    }


def _coordinates(asked: Asked) -> dict[str, Any]:
    """Return the parameters that vary, along the axes of a grid or along ``case``."""
    known = {declaration.key: declaration for declaration in declarations(Config)}
    coordinates = {}
    if asked.sweep.design != "grid":
        points = [case.point for case in asked.cases]
        for key in (key for axis in asked.sweep.axes for key in axis.keys):
            coordinates[key] = ("case", *_coordinate([p[key] for p in points], known[key]))
        return coordinates
    places = np.arange(len(asked.cases)).reshape(asked.sweep.shape)
    for place, axis in enumerate(asked.sweep.axes):
        first = np.moveaxis(places, place, 0).reshape(len(axis.values), -1)[:, 0]
        for key in axis.keys:
            values = [asked.cases[case].point[key] for case in first]
            coordinates[key] = (axis.name, *_coordinate(values, known[key]))
    return coordinates


def _coordinate(values: list[Any], about: Declaration) -> tuple[NDArray[Any], dict[str, str]]:
    """Return the values of a parameter as an array: numbers in SI, or else text."""
    attributes = {"units": about.unit or "1", "long_name": about.doc}
    if all(value is None or isinstance(value, (int, float)) for value in values):
        numbers = [np.nan if value is None else value for value in values]
        return np.array(numbers, dtype=float), attributes
    if about.unit:
        attributes = {"units": "1", "long_name": f"{about.doc} In {about.unit}."}
    texts = [
        ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
        for value in values
    ]
    return np.array(texts, dtype=object), attributes
