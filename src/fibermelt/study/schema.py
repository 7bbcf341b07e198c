"""Whose results folder it is: ours, of another schema, or somebody else's."""

from __future__ import annotations

import json
from pathlib import Path

from fibermelt.errors import StoreError

__all__ = ["OUTPUTS", "REPORT", "SCHEMA", "no_folder", "refuse_foreign"]

SCHEMA = 1
"""Version of the results folder and of summary.json; another one is never read or overwritten."""

REPORT = "report.html"
"""Name of the report in a results folder."""

OUTPUTS = ("config.toml", "summary.json", "results.nc", "flow.vtu", "figures", REPORT)
"""What lies on show in a results folder."""


def no_folder(directory: Path) -> str:
    """Return in words why a path cannot be a results folder; empty if it is a folder."""
    if directory.is_dir():
        return ""
    return "is a file, not a results folder" if directory.exists() else "no such folder"


def refuse_foreign(directory: Path, marker: Path, *, fresh: bool = False) -> None:
    """Refuse a folder of another schema, and one whose files are not ours to overwrite.

    Parameters
    ----------
    directory : Path
        The results folder; it need not be there.
    marker : Path
        The file in it that says which schema it has.
    fresh : bool
        Whether a marker that cannot be read may be written anew.

    Raises
    ------
    StoreError
        If it is not a folder of this schema, and not free to become one.
    """
    for path in (marker, directory / "summary.json"):
        if not path.exists():
            continue
        try:
            schema = json.loads(path.read_bytes())["schema"]
        except (ValueError, KeyError, TypeError, RecursionError):
            schema = None
        if schema is None:
            if path != marker or fresh:
                continue
            msg = (
                f"{path}: is damaged, it does not say which schema this results folder has; run "
                "again with --fresh to compute and write it anew, or move this folder away"
            )
            raise StoreError(msg)
        if schema != SCHEMA:
            msg = (
                f"{path}: this results folder has schema {schema}, this fibermelt writes "
                f"{SCHEMA}; choose another folder with --out, or move this one away"
            )
            raise StoreError(msg)
    if not marker.exists():
        foreign = [name for name in OUTPUTS if (directory / name).exists()]
        if foreign:
            msg = (
                f"{directory}: holds {foreign[0]}, which no run of fibermelt keeps track of; it is "
                "not overwritten: choose another folder with --out, or move it away"
            )
            raise StoreError(msg)
