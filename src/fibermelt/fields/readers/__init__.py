"""Files of other solvers, one module for each format of our own, one for all that VTK reads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fibermelt.errors import ConfigError, legible_path
from fibermelt.fields.contents import Contents, Reader
from fibermelt.fields.readers import cfdpost, comsol, fluent, starccm, vtk
from fibermelt.path_table import is_path_table

__all__ = ["READERS", "read_contents"]

READERS: tuple[Reader, ...] = (
    comsol.SECTIONWISE,
    comsol.SPREADSHEET,
    cfdpost.READER,
    starccm.READER,
    fluent.READER,
    *vtk.READERS,
)
"""All formats, asked in this order whether a file is theirs."""

HEAD = 8192
"""Bytes that a format is known by."""


def read_contents(path: Path, time_step: float | None = None) -> Contents:
    """Return what is in a file, by the first reader that knows its first bytes.

    Raises
    ------
    ConfigError
        If there is no such file, no reader knows it, or it is damaged.
    """
    try:
        head = b""
        if not path.is_dir():
            with path.open("rb") as file:
                head = file.read(HEAD)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = f"field.file = {legible_path(path)}: cannot be read: {reason}"
        raise ConfigError(msg) from error
    for reader in READERS:
        if reader.knows(path, head):
            try:
                contents = reader.read(path, time_step)
            except MemoryError as error:
                msg = f"field.file = {legible_path(path)}: is too large for this machine's memory"
                raise ConfigError(msg) from error
            if time_step is None or contents.times:
                return contents
            told = f"field.time_step = {time_step:g} is not looked at: the file has one time"
            return replace(contents, notes=(*contents.notes, told))
    what = "is empty" if not head and path.is_file() else "is in no format that is known"
    if is_path_table(head):
        msg = (
            f"field.file = {legible_path(path)}: is a table of paths, not of a field: say "
            f'flow.source = "histories" and paths.file = {legible_path(path)}'
        )
        raise ConfigError(msg)
    known = ", ".join(reader.format for reader in READERS)
    msg = f"field.file = {legible_path(path)}: {what}; known are {known}"
    raise ConfigError(msg)
