"""A finished run as it is stored: read for a report, checked against its digests, not touched."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.errors import StoreError
from fibermelt.study.files import digest, read_sealed
from fibermelt.study.netcdf import from_bytes
from fibermelt.study.schema import SCHEMA, no_folder

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Finished", "read_finished"]

NEEDED = ("results.nc", "summary.json")
"""Files on show that a report is made of."""


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


def read_finished(directory: Path) -> Finished:
    """Return the finished run of a results folder.

    Parameters
    ----------
    directory : Path
        The results folder.

    Raises
    ------
    StoreError
        If it is no results folder, is of another schema, holds no finished run, or what a report
        is made of was changed since it was written.
    """
    _refuse(directory)
    listed = _listed(directory)
    content = {name: _read(directory / name) for name in NEEDED}
    for name, data in content.items():
        if digest(data) != listed.get(name):
            raise _damaged(directory / name)
    return Finished(
        results=from_bytes(content["results.nc"]),
        summary=json.loads(content["summary.json"]),
        drawn=_drawn(directory, listed),
    )


def _refuse(directory: Path) -> None:
    """Refuse what is no results folder of this schema."""
    marker = directory / "stages" / "store.json"
    if not marker.is_file():
        what = no_folder(directory) or "is no results folder of fibermelt"
        msg = f"{directory}: {what}; name one that `fibermelt run` wrote, such as results/paper"
        raise StoreError(msg)
    try:
        schema = json.loads(_read(marker))["schema"]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise _damaged(marker) from None
    if schema != SCHEMA:
        msg = (
            f"{marker}: this results folder has schema {schema}, this fibermelt reads {SCHEMA}; "
            "run the study again into another folder, or use the fibermelt that wrote this one"
        )
        raise StoreError(msg)


def _listed(directory: Path) -> Mapping[str, str]:
    """Return the digests of the files on show."""
    manifest = directory / "stages" / "outputs.json"
    if not manifest.exists():
        msg = (
            f"{directory}: holds no finished run; `fibermelt run <study> --out {directory}` goes "
            "on from the stages that are there"
        )
        raise StoreError(msg)
    try:
        files: Mapping[str, str] = read_sealed(manifest)["files"]
    except (ValueError, KeyError):
        raise _damaged(manifest) from None
    return files


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


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise _damaged(path) from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = f"{path}: cannot be read: {reason}; make it readable, or run the study again"
        raise StoreError(msg) from error


def _damaged(path: Path) -> StoreError:
    return StoreError(
        f"{path}: is damaged, missing, or was changed since it was written; run the study again "
        "with --fresh to compute and write it anew"
    )
