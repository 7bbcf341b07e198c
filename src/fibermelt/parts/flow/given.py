"""Files that a study names and that its results depend on: known again by what is in them.

And whether results are of such a file: it stands here so that a page loads none that reads fields.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import model_validator

from fibermelt.engine.parameters import Section, setting
from fibermelt.errors import ConfigError, legible_path

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["GivenFile", "fingerprint", "is_given", "refuse_changed"]

BLOCK = 1 << 20
"""Bytes that are read at a time."""

KEPT = 16
"""States of files whose digests are kept at hand."""

HEAD = 8192
"""Bytes by which a format is known."""

OF_SEVERAL = re.compile(
    rb"\A\x89HDF|(?i:type:\s*ensight)|<Xdmf|filetemplate\s*:|"
    rb"\btype\s*=\s*[\"'](?:P\w*Grid|PPolyData|vtkMultiBlockDataSet|Collection)"
)
"""What begins a file whose data may lie in others: HDF5, EnSight, XDMF, nek5000, VTK's lists."""

OPENFOAM = re.compile(r"system|constant|processors?\d.*|\d[\d.eE+-]*")
"""Parts of an OpenFOAM case: the mesh, and the times."""

NO_DATA = frozenset({".toml", ".log"})
"""Suffixes of what a person keeps beside a field of the same name."""


def fingerprint(file: str) -> str:
    """Return a digest of a file and of those that belong to it, or of an OpenFOAM case.

    Of a format of several files, whatever lies beside the file and begins with its name up to the
    first dot belongs to it, and the folder of that name: ``nozzle.cas.h5`` and ``nozzle.dat.h5``,
    ``flow.case`` and ``flow.geo``, ``flow.vtm`` and ``flow/flow_0.vtu``. Of others it is the file
    alone, so that a study ``nozzle.toml`` and its log may lie beside ``nozzle.csv``.

    Raises
    ------
    ConfigError
        If there is no such file, or it cannot be read.
    """
    path = Path(file)
    try:
        found = ((entry.resolve(), entry.stat()) for entry in _belonging(path))
        return _digest(tuple((entry, has.st_size, has.st_mtime_ns) for entry, has in found))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = f"{legible_path(path)}: cannot be read: {reason}"
        raise ConfigError(msg) from error


@lru_cache(maxsize=KEPT)
def _digest(files: tuple[tuple[Path, int, int], ...]) -> str:
    """Return the digest of files, each with its size and when it was written [ns].

    Every case of a sweep asks for it anew.
    """
    whole = hashlib.sha256()
    for entry, _, _ in files:
        whole.update(entry.name.encode() + b"\0")
        with entry.open("rb") as stream:
            while block := stream.read(BLOCK):
                whole.update(block)
    return whole.hexdigest()


def _belonging(path: Path) -> list[Path]:
    """Return the files that hold what a file, or a case's folder, is read for."""
    if path.suffix == ".foam" or path.name == "controlDict":
        path = path.parent
    if path.name == "system":
        path = path.parent
    if path.is_dir():
        # results may be written into it while it is read
        parts = [entry for entry in path.iterdir() if OPENFOAM.fullmatch(entry.name)]
        return _files(parts)
    with path.open("rb") as stream:
        head = stream.read(HEAD)
    if not OF_SEVERAL.search(head):
        return [path]
    stem = path.name.partition(".")[0]
    beside = [
        entry
        for entry in path.parent.iterdir()
        if entry.name == stem
        or (entry.is_file() and entry.name.startswith(stem) and entry.suffix not in NO_DATA)
    ]
    return _files(beside)


def _files(entries: list[Path]) -> list[Path]:
    """Return files and those in folders, in an order that stays."""
    inside = (one for entry in entries if entry.is_dir() for one in entry.rglob("*"))
    return sorted(one for one in (*entries, *inside) if one.is_file())


def refuse_changed(table: str, file: str, content: str) -> None:
    """Refuse a file that is no longer what it was when the study was read (`ConfigError`)."""
    if fingerprint(file) != content:
        msg = (
            f'{table}.file = "{file}": is not what it was when the study was read: bring that file '
            f"back, or leave {table}.content away, and run the study with this one"
        )
        raise ConfigError(msg)


class GivenFile(Section):
    """A table that names a file."""

    TABLE: ClassVar[str]
    """What the table is called."""

    content: str = setting(
        "", "Fingerprint of the file, filled in as a study is read: what has changed is computed."
    )

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any) -> Any:
        """Fill in the fingerprint; results that know it do without the file."""
        if not isinstance(data, Mapping):
            return data
        file = data.get("file")
        if not isinstance(file, str) or not file or data.get("content"):
            return data
        try:
            return {**data, "content": fingerprint(file)}
        except ConfigError as error:
            msg = f"{cls.TABLE}.file = {error}; names are from the working directory"
            raise ValueError(msg) from error


def is_given(lines: xr.Dataset) -> bool:
    """Tell whether streamlines, or results with them, are paths of a flow from elsewhere."""
    return "path_divergence" in lines
