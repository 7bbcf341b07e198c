"""Fluent's ASCII export: ``nodenumber, x-coordinate, y-coordinate, ..., x-velocity, ...``.

Read are its variants with commas or blanks, with values at nodes (``nodenumber``) or cell centres
(``cellnumber``), in two or three dimensions. It has no connectivity, and no units: Fluent writes SI
whatever its panels show. A mesh that is axisymmetric has ``axial-velocity``, ``radial-velocity``.
"""

from __future__ import annotations

import re
from pathlib import Path

from fibermelt.errors import ConfigError, legible_path
from fibermelt.fields.contents import Contents, Reader
from fibermelt.fields.readers.tables import numbers, text_of, unique_names

__all__ = ["READER"]

FORMAT = "Fluent ASCII"

HEADING = re.compile(rb"\s*(?:\xef\xbb\xbf)?\s*(node|cell)number\s*[,\s]\s*x-coordinate")


def _knows(path: Path, head: bytes) -> bool:
    return HEADING.match(head) is not None


def _read(path: Path, time_step: float | None) -> Contents:
    """Return what is in the file; it is of one time."""
    lines = text_of(path).splitlines()
    start = next(number for number, line in enumerate(lines) if line.strip())
    names = unique_names([name for name in re.split(r"[,\s]+", lines[start].strip()) if name])
    table = numbers(path, lines[start + 1 :], len(names), start + 2)
    columns = dict(zip(names, table.T, strict=True))
    at_centres = names[0] == "cellnumber"
    axes = [name for name in ("x-coordinate", "y-coordinate", "z-coordinate") if name in columns]
    if len(axes) < 2:
        msg = (
            f"field.file = {legible_path(path)}: has no y-coordinate: export the coordinates "
            "of all nodes from Fluent (File, Export, Solution Data, ASCII)"
        )
        raise ConfigError(msg)
    # coordinates that were asked for as variables, too, come a second time
    again = tuple(f"{axis} (" for axis in axes)
    arrays = {
        name: values
        for name, values in columns.items()
        if name not in {names[0], *axes} and not name.startswith(again)
    }
    notes = (
        ("values stand at the centres of cells: what lies beyond the outermost is left out",)
        if at_centres
        else ()
    )
    return Contents(
        format=FORMAT,
        points=table[:, [names.index(axis) for axis in axes]],
        arrays=arrays,
        axis="x" if "radial-velocity" in arrays and len(axes) == 2 else "",
        notes=notes,
    )


READER = Reader(FORMAT, _knows, _read)
