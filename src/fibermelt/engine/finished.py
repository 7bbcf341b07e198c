"""A finished run as it is stored: checked against its digests, not touched.

Who answers from a finished run without computing it again reads it here.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.files import digest
from fibermelt.engine.netcdf import from_bytes
from fibermelt.engine.outputs import Outputs, has_run, not_as_written, read_outputs
from fibermelt.engine.schema import SCHEMA, is_ours, no_folder
from fibermelt.errors import StoreError, legible_path

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Finished", "finished_results", "read_finished"]


@dataclass(frozen=True, eq=False)
class Finished:
    """What a finished run left.

    Parameters
    ----------
    run : str
        Its key.
    results : xarray.Dataset
        Content of results.nc.
    summary : mapping
        Content of summary.json.
    drawn : mapping
        The figures that are as the run drew them, by their file names.
    """

    run: str
    results: xr.Dataset
    summary: Mapping[str, Any]
    drawn: Mapping[str, bytes]


def finished_results(directory: Path) -> xr.Dataset:
    """Return the results of a finished run, the content of its results.nc.

    Parameters
    ----------
    directory : Path
        The results folder.

    Raises
    ------
    StoreError
        As `read_finished`; a summary that was changed does not matter here.
    """
    return from_bytes(_whole(directory, "results.nc", _on_show(directory)))


def read_finished(directory: Path) -> Finished:
    """Return the finished run of a results folder.

    Parameters
    ----------
    directory : Path
        The results folder.

    Raises
    ------
    StoreError
        If it is no results folder, is of another schema, holds no finished run, or what is read
        is missing or was changed since it was written.
    """
    outputs = _on_show(directory)
    return Finished(
        run=outputs.run,
        results=from_bytes(_whole(directory, "results.nc", outputs)),
        summary=json.loads(_whole(directory, "summary.json", outputs)),
        drawn=_drawn(directory, outputs),
    )


def _on_show(directory: Path) -> Outputs:
    """Return what is on show."""
    _refuse(directory)
    if has_run(directory):
        return read_outputs(directory)
    shown = legible_path(directory)
    msg = (
        f"{shown}: holds no finished run; `fibermelt run STUDY --out {shown}` goes on from the "
        "stages that are there"
    )
    if (directory / "sweep.json").exists():
        msg = f"{shown}: holds a sweep, and no finished run of a single study: {_NAME_ANOTHER}"
    raise StoreError(msg)


_NAME_ANOTHER = "name a folder that `fibermelt run` wrote, such as results/paper"


def _refuse(directory: Path) -> None:
    """Refuse what is no results folder of this schema."""
    shown, marker = legible_path(directory), directory / "stages" / "store.json"
    if not marker.is_file():
        what = no_folder(directory) or "is no results folder of fibermelt"
        msg = f"{shown}: {what}; {_NAME_ANOTHER}"
        if is_ours(directory):
            msg = (
                f"{legible_path(marker)}: is missing; `fibermelt run STUDY --out {shown}` writes "
                "it anew, from the stages that are there"
            )
        raise StoreError(msg)
    try:
        schema = json.loads(_read(marker))["schema"]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise not_as_written(marker) from None
    if schema != SCHEMA:
        msg = (
            f"{legible_path(marker)}: this results folder has schema {schema}, this fibermelt "
            f"reads {SCHEMA}; run the study again into another folder, or use the fibermelt that "
            "wrote this one"
        )
        raise StoreError(msg)


def _drawn(directory: Path, outputs: Outputs) -> Mapping[str, bytes]:
    """Return the figures that are there and unchanged; what is not is drawn again."""
    found = {}
    for name, expected in outputs.files.items():
        path = directory / name
        if path.parent.name == "figures" and path.is_file():
            data = _read(path)
            if digest(data) == expected:
                found[path.name] = data
    return found


def _whole(directory: Path, name: str, outputs: Outputs) -> bytes:
    """Return a file on show that is as it was written."""
    data = _read(directory / name)
    if digest(data) != outputs.files.get(name):
        raise not_as_written(directory / name)
    return data


def _read(path: Path) -> bytes:
    shown = legible_path(path)
    try:
        return path.read_bytes()
    except FileNotFoundError:
        msg = f"{shown}: is missing; run the study again: it is written anew from the stages"
        raise StoreError(msg) from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = f"{shown}: cannot be read: {reason}; make it readable, or run the study again"
        raise StoreError(msg) from error
