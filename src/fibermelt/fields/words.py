"""What is in a file of another solver, in words, with the table that a study would say."""

from __future__ import annotations

import math

from fibermelt.fields.mapping import ROLES
from fibermelt.fields.reading import FieldContents

__all__ = ["field_in_words"]

KEYS = {"length": "length_unit", "velocity": "velocity_unit", "pressure": "pressure_unit"}
"""Keys of a study by what they give the unit of."""


SPACE = 3
"""Dimensions of a field in which fibers turn out of the plane."""

IN_SPACE = [
    "",
    "# fibers in a flow in space (one layer of cells is read as planar):",
    "# [fiber]",
    '# model = "spheroid"',
    '# directions = "equal-area"',
]
"""What a study says beside, as its defaults are of a fiber in a plane."""


def field_in_words(path: str, found: FieldContents) -> list[str]:
    """Return lines on a file's contents, the last ones the tables of a study to be pasted."""
    length = found.units["length"] or ""
    sides = " x ".join(f"{low:.6g} to {high:.6g}" for low, high in found.bounds)
    cells = f"{found.cells} cells" if found.cells else "no cells"
    lines = [
        f"{found.format}: {found.points} points, {cells}, in {found.dimension} dimensions, "
        f"{sides} {length}".rstrip()
    ]
    if found.times:
        lines.append(f"times  {', '.join(f'{time:g}' for time in found.times[-8:])}")
    lines.append("")
    width = max((len(array["name"]) for array in found.arrays), default=0)
    for array in found.arrays:
        role = array["taken_for"]
        low, high = array["range"] or (math.nan, math.nan)
        unit = found.units.get(role or "") or ""
        values = f"{low:.4g} to {high:.4g} {unit}".rstrip()
        taken = f"  taken for the {role}" if role else ""
        lines.append(f"{array['name']:{width}}  {array['components']}  {values}{taken}")
    if found.notes:
        lines += ["", *found.notes]
    lines += ["", "In a study:", "", "[flow]", 'source = "field"', "", *table(path, found)]
    return lines + (IN_SPACE if found.dimension == SPACE else [])


def table(path: str, found: FieldContents) -> list[str]:
    """Return the table ``[field]``: what is found, and what a person has to fill in."""
    taken = found.taken()
    lines = ["[field]", f"file = {_quoted(path)}"]
    for role in ROLES:
        if role in taken:
            lines.append(f"{role} = {_quoted(taken[role])}")
        elif role == "velocity":
            lines.append('# velocity = "NAME"')
    unknown = [
        f'# {key} = "{ROLES.get(of, "m")}"'
        for of, key in KEYS.items()
        if (of == "length" or of in taken) and found.units.get(of) is None
    ]
    if unknown:
        lines += ["# of these the file names no unit:", *unknown]
    return lines


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
