"""COMSOL's text exports: spreadsheet (a line for each node) and sectionwise (with elements).

Both begin with lines such as ``% Model:``, ``% Dimension:``, ``% Length unit:``. A spreadsheet has
columns ``x  y  u (m/s)  v (m/s)  p (Pa)`` under a last line of ``%`` and no connectivity; a
sectionwise file has ``% Coordinates``, ``% Elements (triangles)`` counted from 1, and for each
expression ``% Data (u (m/s))``. Columns of several times are headed ``u (m/s) @ t=0.1``. A
spreadsheet with ``r``, ``z`` is turned about ``z``; a sectionwise file does not name its axes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, legible, legible_path
from fibermelt.fields.contents import Contents, Reader
from fibermelt.fields.readers.tables import numbers, refuse_short, split_unit, text_of, unique_names
from fibermelt.fields.readers.times import chosen_time

__all__ = ["SECTIONWISE", "SPREADSHEET"]

Array = NDArray[np.float64]

HEADER = re.compile(r"%\s*([A-Z][A-Za-z ]*):\s*(.*?)\s*")
AT_TIME = re.compile(r"(.*?)\s*@\s*(?:\d+:\s*)?t\s*=\s*([-+.\deE]+).*")
ELEMENTS = re.compile(r"Elements(?:\s*\(.*\))?")
DATA = re.compile(r"%\s*Data\s*\((.*)\)\s*")
COORDINATE_NAMES = ("x", "y", "z", "r", "X", "Y", "Z", "R")


def _knows_sectionwise(path: Path, head: bytes) -> bool:
    return _knows(head) and re.search(rb"(?m)^%\s*Coordinates\s*$", head) is not None


def _knows_spreadsheet(path: Path, head: bytes) -> bool:
    return _knows(head) and not _knows_sectionwise(path, head)


def _knows(head: bytes) -> bool:
    start = head.lstrip(b"\xef\xbb\xbf")
    return re.match(rb"%\s*(Model|Version|Dimension)\s*:", start) is not None


def _header(lines: Sequence[str]) -> dict[str, str]:
    """Return what the lines ``% Key: value`` on top say."""
    found = {}
    for line in lines:
        if not line.startswith("%"):
            break
        match = HEADER.fullmatch(line)
        if match:
            found[match.group(1)] = match.group(2)
    return found


def _count(header: dict[str, str], key: str) -> int | None:
    value = header.get(key, "")
    return int(value) if value.isdigit() else None


def _columns(path: Path, line: str, count: int) -> list[str]:
    """Return the headings of a spreadsheet: two blanks part them, where they are short enough."""
    text = line.lstrip("%").strip()
    for pattern in (r"\s{2,}|[,;]\s*|\t", r"(?<=\))\s+(?!@)|(?<=[^\s)@])\s+(?![(@])|\s{2,}"):
        names = [name for name in re.split(pattern, text) if name]
        if len(names) == count:
            return names
    msg = (
        f"field.file = {legible_path(path)}: {count} columns, but the headings "
        f'"{legible(text)}" are others: export it again, with decimal points and units'
    )
    raise ConfigError(msg)


def _of_time(
    path: Path, headings: Sequence[str], values: Sequence[Array], time_step: float | None
) -> tuple[dict[str, Array], dict[str, str], tuple[float, ...]]:
    """Return arrays and units of one time, and all times there are."""
    parts, times = [], set()
    for heading in headings:
        match = AT_TIME.fullmatch(heading)
        time = float(match.group(2)) if match else None
        parts.append((*split_unit(match.group(1) if match else heading), time))
        times |= set() if time is None else {time}
    chosen = chosen_time(path, tuple(sorted(times)), time_step) if times else None
    kept = [k for k, (_, _, time) in enumerate(parts) if time is None or time == chosen]
    names = unique_names([parts[k][0] for k in kept])
    units = {name: parts[k][1] for name, k in zip(names, kept, strict=True) if parts[k][1]}
    return {n: values[k] for n, k in zip(names, kept, strict=True)}, units, tuple(sorted(times))


def _read_spreadsheet(path: Path, time_step: float | None) -> Contents:
    lines = text_of(path).splitlines()
    header = _header(lines)
    body = next((k for k, line in enumerate(lines) if not line.startswith("%")), len(lines))
    if body == 0 or body >= len(lines):
        msg = f"field.file = {legible_path(path)}: has no values under its header: truncated"
        raise ConfigError(msg)
    count = len(lines[body].replace(",", " ").replace(";", " ").split())
    headings = _columns(path, lines[body - 1], count)
    table = numbers(path, lines[body:], count, body + 1)
    expected = _count(header, "Nodes")
    if expected is not None:
        refuse_short(path, "nodes", len(table), expected)
    axes = [name for name in headings[:3] if name in COORDINATE_NAMES]
    columns = [table[:, k] for k in range(len(axes), count)]
    arrays, units, times = _of_time(path, headings[len(axes) :], columns, time_step)
    return Contents(
        format=SPREADSHEET.format,
        points=table[:, : len(axes)],
        arrays=arrays,
        units=units,
        length_unit=header.get("Length unit", ""),
        names_units=True,
        axis="y" if len(axes) == 2 and axes[0] in "rR" else "",
        times=times,
    )


def _read_sectionwise(path: Path, time_step: float | None) -> Contents:
    lines = text_of(path).splitlines()
    header = _header(lines)
    marks = [k for k, line in enumerate(lines) if line.startswith("%")]
    points = np.empty((0, 2))
    cells: NDArray[np.int64] | None = None
    headings, values = [], []
    for start, end in zip(marks, [*marks[1:], len(lines)], strict=True):
        title = lines[start].lstrip("%").strip()
        body = lines[start + 1 : end]
        if title == "Coordinates":
            width = _count(header, "Dimension") or len(_first(body))
            points = numbers(path, body, width, start + 2)
        elif ELEMENTS.fullmatch(title):
            corners = len(_first(body))
            if corners not in {3, 4} or corners != points.shape[1] + 1:
                msg = (
                    f"field.file = {legible_path(path)}: {title} of {corners} nodes in "
                    f"{points.shape[1]} dimensions: triangles in a plane or tetrahedra are read; "
                    "export the domain, not its boundaries"
                )
                raise ConfigError(msg)
            cells = numbers(path, body, corners, start + 2).astype(np.int64)
        elif (match := DATA.fullmatch(lines[start])) is not None:
            headings.append(match.group(1))
            column = numbers(path, body, 1, start + 2)[:, 0]
            refuse_short(path, f"values of {headings[-1]}", len(column), len(points))
            values.append(column)
    counts = {"Nodes": len(points), "Expressions": len(values)}
    counts["Elements"] = 0 if cells is None else len(cells)
    for what, count in counts.items():
        expected = _count(header, what)
        refuse_short(path, what.lower(), count, count if expected is None else expected)
    if cells is not None and len(cells):
        cells = cells - (1 if cells.min() >= 1 else 0)
        if cells.max() >= len(points):
            refuse_short(path, "points", len(points), int(cells.max()) + 1)
    arrays, units, times = _of_time(path, headings, values, time_step)
    return Contents(
        format=SECTIONWISE.format,
        points=points,
        arrays=arrays,
        cells=cells,
        file_cells=0 if cells is None else len(cells),
        units=units,
        length_unit=header.get("Length unit", ""),
        names_units=True,
        times=times,
    )


def _first(lines: Sequence[str]) -> list[str]:
    """Return the words of the first line that has any."""
    line = next((line for line in lines if line.strip()), "")
    return line.replace(",", " ").replace(";", " ").split()


SPREADSHEET = Reader("COMSOL spreadsheet", _knows_spreadsheet, _read_spreadsheet)
SECTIONWISE = Reader("COMSOL sectionwise", _knows_sectionwise, _read_sectionwise)
