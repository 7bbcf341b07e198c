"""Whose results folder it is: ours, of another schema, or somebody else's."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

from fibermelt.engine.files import read_sealed
from fibermelt.errors import StoreError

__all__ = ["OUTPUTS", "REPORT", "SCHEMA", "has_lost_mark", "is_ours", "no_folder", "refuse_foreign"]

SCHEMA = 1
"""Version of the results folder and of summary.json; another one is never read or overwritten."""

REPORT = "report.html"
"""Name of the report in a results folder."""

OUTPUTS = ("config.toml", "summary.json", "results.nc", "flow.vtu", "figures", REPORT)
"""What lies on show in a results folder."""


SEALED = (
    *("stages/*-*/record.json", "stages/outputs.json"),
    *("cases/failed-*.json", "cases/progress.json"),
)
"""Files of a results folder that carry their own digest, as nobody else's do; so does sweep.json,
which tells the schema besides."""


def no_folder(directory: Path) -> str:
    """Return in words why a path cannot be a results folder; empty if it is a folder."""
    if directory.is_dir():
        return ""
    return "is a file, not a results folder" if directory.exists() else "no such folder"


def is_ours(directory: Path) -> bool:
    """Tell whether a folder holds a file that fibermelt sealed, and none of another schema."""
    swept = directory / "sweep.json"
    with suppress(ValueError, StoreError):
        return bool(read_sealed(swept).get("schema") == SCHEMA)
    return any(_is_whole(path) for pattern in SEALED for path in directory.glob(pattern))


def has_lost_mark(directory: Path) -> bool:
    """Tell whether a folder is ours, but does not say which schema it has: it is marked anew."""
    marker = directory / "stages" / "store.json"
    with suppress(OSError):
        return _schema_in(marker) is None and is_ours(directory)
    return False


def _is_whole(path: Path) -> bool:
    with suppress(ValueError, StoreError):
        read_sealed(path)
        return True
    return False


def _schema_in(path: Path) -> object:
    """Return the schema that a file tells, None if it is not there or tells none."""
    try:
        return json.loads(path.read_bytes())["schema"]
    except (FileNotFoundError, ValueError, KeyError, TypeError, RecursionError):
        return None


def refuse_foreign(directory: Path, marker: Path, *, fresh: bool = False) -> None:
    """Refuse a folder of another schema, and one whose files are not ours to overwrite.

    One that has lost its marker, or has a damaged one, is ours as long as anything sealed is
    whole in it (`is_ours`).

    Parameters
    ----------
    directory : Path
        The results folder; it need not be there.
    marker : Path
        The file in it that says which schema it has.
    fresh : bool
        Whether a marker that cannot be read may be written anew, whatever else is there.

    Raises
    ------
    StoreError
        If it is not a folder of this schema, and not free to become one.
    """
    for path in (marker, directory / "summary.json"):
        if not path.exists():
            continue
        schema = _schema_in(path)
        if schema is None:
            if path != marker or fresh or is_ours(directory):
                continue
            msg = (
                f"{path}: is damaged, it does not say which schema this results folder has, nor "
                "is there any whole result: fibermelt run --fresh computes and writes it anew; or "
                "move this folder away, or choose another one with --out"
            )
            raise StoreError(msg)
        if schema != SCHEMA:
            msg = (
                f"{path}: this results folder has schema {schema}, this fibermelt writes "
                f"{SCHEMA}; choose another folder with --out, or move this one away"
            )
            raise StoreError(msg)
    if not marker.exists() and not is_ours(directory):
        foreign = [name for name in OUTPUTS if (directory / name).exists()]
        if foreign:
            msg = (
                f"{directory}: holds {foreign[0]}, which no run of fibermelt keeps track of; it is "
                "not overwritten: choose another folder with --out, or move it away"
            )
            raise StoreError(msg)
