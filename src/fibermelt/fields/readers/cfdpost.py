"""CFD-Post's CSV, the way out of Polyflow and CFX: sections ``[Name]``, ``[Data]``, ``[Faces]``.

Columns are headed ``X [ m ], Y [ m ], Z [ m ], Velocity u [ m s^-1 ], ...``. Several sections are
put together. ``[Faces]`` are polygons on the nodes above them, counted from 0, which a plane or a
planar flow has; without them the points are joined anew.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, legible, legible_path
from fibermelt.fields.contents import Contents, Reader
from fibermelt.fields.readers.tables import headed, numbers, refuse_short, split_unit, text_of
from fibermelt.fields.splitting import split_polygons

__all__ = ["READER"]

FORMAT = "CFD-Post CSV"

SECTION = re.compile(r"\s*\[([A-Za-z ]+)\]\s*")


def _knows(path: Path, head: bytes) -> bool:
    start = head.lstrip(b"\xef\xbb\xbf \r\n")
    return start.startswith((b"[Name]", b"[Data]"))


def _read(path: Path, time_step: float | None) -> Contents:
    """Return what is in the file; it is of one time."""
    lines = text_of(path).splitlines()
    starts = [number for number, line in enumerate(lines) if SECTION.fullmatch(line)]
    tables, polygons, headings, count, faces = [], [], None, 0, 0
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        match = SECTION.fullmatch(lines[start])
        title = match.group(1) if match else ""
        body = [k for k in range(start + 1, end) if lines[k].strip()]
        if not body:
            continue
        if title == "Data":
            found = [split_unit(heading) for heading in lines[body[0]].split(",")]
            if headings is not None and found != headings:
                msg = (
                    f"field.file = {legible_path(path)}: line {body[0] + 1} has other columns than "
                    "the section before: export all with the same variables"
                )
                raise ConfigError(msg)
            headings = found
            tables.append(numbers(path, lines[body[0] + 1 : end], len(found), body[0] + 2))
            count += len(tables[-1])
        elif title == "Faces":
            offset = count - (len(tables[-1]) if tables else 0)
            new = _faces(path, [lines[k] for k in body], body[0] + 1, count - offset)
            polygons += [face + offset for face in new]
            faces += len(new)
    if headings is None:
        msg = f"field.file = {legible_path(path)}: has no section [Data] with values"
        raise ConfigError(msg)
    table = np.concatenate(tables)
    names = [name for name, _ in headings]
    units = {name: unit for name, unit in headings if unit}
    missing = f"field.file = {legible_path(path)}: has no columns X, Y: export the geometry as well"
    return replace(
        headed(table, names, units, FORMAT, missing),
        cells=split_polygons(polygons) if polygons else None,
        file_cells=faces,
    )


def _faces(path: Path, lines: list[str], first: int, count: int) -> list[NDArray[np.int64]]:
    """Return the polygons of a section, each the numbers of its nodes."""
    faces = []
    for number, line in enumerate(lines, start=first):
        try:
            face = np.array(line.replace(",", " ").split(), dtype=np.int64)
        except ValueError as error:
            msg = f"field.file = {legible_path(path)}: line {number} is no face: {legible(line)}"
            raise ConfigError(msg) from error
        if face.size < 3 or face.min() < 0 or face.max() >= count:
            refuse_short(path, "points", count, int(face.max(initial=0)) + 1)
            msg = f"field.file = {legible_path(path)}: line {number} is no face of three points"
            raise ConfigError(msg)
        faces.append(face)
    return faces


READER = Reader(FORMAT, _knows, _read)
