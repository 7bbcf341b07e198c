"""STAR-CCM+ tables as CSV: ``"Pressure (Pa)","Velocity[i] (m/s)",...,"X (m)","Y (m)","Z (m)"``.

Of an XYZ internal table the values stand at the centres of cells. There is no connectivity; units
stand in the headings.
"""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from pathlib import Path

from fibermelt.errors import legible_path
from fibermelt.fields.contents import Contents, Reader
from fibermelt.fields.readers.tables import headed, numbers, split_unit, text_of, unique_names

__all__ = ["READER"]

FORMAT = "STAR-CCM+ table"

SPELLED = {"Pa-s": "Pa s", "kg/m-s": "kg/(m s)", "C": "degC", "F": "degF"}
"""Units as the solver spells them that are something else elsewhere."""

COORDINATE = re.compile(rb"(?:^|,)\s*\"?X \([^\")]+\)\"?\s*(?:,|\r?$)")


def _knows(path: Path, head: bytes) -> bool:
    first = head.lstrip(b"\xef\xbb\xbf").split(b"\n", 1)[0].strip()
    return COORDINATE.search(first) is not None


def _read(path: Path, time_step: float | None) -> Contents:
    """Return what is in the file; it is of one time."""
    lines = text_of(path).splitlines()
    headings = next(csv.reader(lines[:1]))
    parts = [split_unit(heading) for heading in headings]
    names = unique_names([name for name, _ in parts])
    units = {
        name: SPELLED.get(unit, unit) for name, (_, unit) in zip(names, parts, strict=True) if unit
    }
    table = numbers(path, lines[1:], len(names), 2)
    missing = f'field.file = {legible_path(path)}: has no column "Y (m)": add the coordinates'
    return replace(
        headed(table, names, units, FORMAT, missing),
        notes=("values stand at the centres of cells: what lies beyond the outermost is left out",),
    )


READER = Reader(FORMAT, _knows, _read)
