"""Whose results folder it is: ours, of another schema, or somebody else's."""

from __future__ import annotations

import json
from pathlib import Path

from fibermelt.errors import StoreError

__all__ = ["OUTPUTS", "SCHEMA", "refuse_foreign"]

SCHEMA = 1
"""Version of the results folder and of summary.json; another one is never read or overwritten."""

OUTPUTS = ("config.toml", "summary.json", "results.nc", "flow.vtu", "figures")
"""What lies on show in a results folder."""


def refuse_foreign(directory: Path, marker: Path) -> None:
    """Refuse a folder of another schema, and one whose files are not ours to overwrite.

    Parameters
    ----------
    directory : Path
        The results folder; it need not be there.
    marker : Path
        The file in it that says which schema it has.

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
        except (ValueError, KeyError, TypeError):
            schema = None
        if schema != SCHEMA and (schema is not None or path == marker):
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
