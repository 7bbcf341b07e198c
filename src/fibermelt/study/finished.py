"""A finished run as it is stored: checked against its digests, not touched.

Who answers from a finished run without computing it again reads it here.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.errors import StoreError, legible
from fibermelt.study.files import digest, read_sealed
from fibermelt.study.netcdf import from_bytes
from fibermelt.study.schema import SCHEMA, is_ours, no_folder
from fibermelt.study.store import LONGEST_PATH, not_as_written

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Finished", "finished_results", "read_finished"]


@dataclass(frozen=True, eq=False)
class Finished:
    """What a finished run left.

    Parameters
    ----------
    results : xarray.Dataset
        Content of results.nc.
    summary : mapping
        Content of summary.json.
    drawn : mapping
        The figures that are as the run drew them, by their file names.
    """

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
    return from_bytes(_whole(directory, "results.nc", _listed(directory)))


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
    listed = _listed(directory)
    return Finished(
        results=from_bytes(_whole(directory, "results.nc", listed)),
        summary=json.loads(_whole(directory, "summary.json", listed)),
        drawn=_drawn(directory, listed),
    )


def _listed(directory: Path) -> Mapping[str, str]:
    """Return the digests of the files on show."""
    _refuse(directory)
    manifest = directory / "stages" / "outputs.json"
    if not manifest.exists():
        shown = _shown(directory)
        msg = (
            f"{shown}: holds no finished run; `fibermelt run STUDY --out {shown}` goes on from the "
            "stages that are there"
        )
        if (directory / "sweep.json").exists():
            msg = f"{shown}: holds a sweep, and no finished run of a single study: {_NAME_ANOTHER}"
        raise StoreError(msg)
    try:
        files: Mapping[str, str] = read_sealed(manifest)["files"]
    except (ValueError, KeyError):
        raise not_as_written(manifest) from None
    return files


_NAME_ANOTHER = "name a folder that `fibermelt run` wrote, such as results/paper"


def _refuse(directory: Path) -> None:
    """Refuse what is no results folder of this schema."""
    marker = directory / "stages" / "store.json"
    if not marker.is_file():
        what = no_folder(directory) or "is no results folder of fibermelt"
        msg = f"{_shown(directory)}: {what}; {_NAME_ANOTHER}"
        if is_ours(directory):
            msg = (
                f"{_shown(marker)}: is missing; `fibermelt run STUDY --out {_shown(directory)}` "
                "writes it anew, from the stages that are there"
            )
        raise StoreError(msg)
    try:
        schema = json.loads(_read(marker))["schema"]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise not_as_written(marker) from None
    if schema != SCHEMA:
        msg = (
            f"{_shown(marker)}: this results folder has schema {schema}, this fibermelt reads "
            f"{SCHEMA}; run the study again into another folder, or use the fibermelt that wrote "
            "this one"
        )
        raise StoreError(msg)


def _drawn(directory: Path, listed: Mapping[str, str]) -> Mapping[str, bytes]:
    """Return the figures that are there and unchanged; what is not is drawn again."""
    found = {}
    for name, expected in listed.items():
        path = directory / name
        if path.parent.name == "figures" and path.is_file():
            data = _read(path)
            if digest(data) == expected:
                found[path.name] = data
    return found


def _whole(directory: Path, name: str, listed: Mapping[str, str]) -> bytes:
    """Return a file on show that is as it was written."""
    data = _read(directory / name)
    if digest(data) != listed.get(name):
        raise not_as_written(directory / name)
    return data


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        msg = f"{_shown(path)}: is missing; run the study again: it is written anew from the stages"
        raise StoreError(msg) from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = f"{_shown(path)}: cannot be read: {reason}; make it readable, or run the study again"
        raise StoreError(msg) from error


def _shown(path: Path) -> str:
    return legible(str(path), LONGEST_PATH)
