"""Tables of numbers in text files: the columns, and the names of their coordinates."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, legible, legible_path
from fibermelt.fields.contents import Contents

__all__ = ["headed", "numbers", "refuse_short", "split_unit", "text_of", "unique_names"]

Array = NDArray[np.float64]

UNIT = re.compile(r"\s*(.*?)\s*(?:\[([^\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)*)\))\s*")
"""A name and a unit in brackets or parentheses, which may have parentheses inside."""

MISSING = re.compile(r"(?i)\b(?:null|n/a|undefined)\b")
"""What solvers write where they know no value; NaN once read."""


def text_of(path: Path) -> str:
    """Return the text of a file.

    Raises
    ------
    ConfigError
        If it cannot be read, or is no text.
    """
    try:
        return path.read_text(encoding="utf-8-sig", errors="strict")
    except UnicodeDecodeError:
        return path.read_text(encoding="latin-1")
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = f"field.file = {legible_path(path)}: cannot be read: {reason}"
        raise ConfigError(msg) from error


def numbers(path: Path, lines: Sequence[str], columns: int, first: int) -> Array:
    """Return lines of numbers as an array (rows, columns); commas, semicolons or blanks between.

    Parameters
    ----------
    path : Path
        The file, for messages.
    lines : sequence of str
        Lines; empty ones are left out.
    columns : int
        Numbers that each line must have.
    first : int
        Number of the first line in the file.

    Raises
    ------
    ConfigError
        If a line has another count or something else: its number, and what it is.
    """
    text = "\n".join(lines)
    if any(letter in text for letter in "nNuU") and MISSING.search(text):
        text = MISSING.sub("nan", text)
    try:
        table = np.fromstring(text.replace(",", " ").replace(";", " "), sep=" ")
    except ValueError:
        table = np.empty(0)
    rows = sum(1 for line in lines if line.strip())
    if table.size == rows * columns and rows:
        return table.reshape(rows, columns)
    for number, line in enumerate(lines, start=first):
        words = MISSING.sub("nan", line).replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        if len(words) != columns:
            # counts, as of nodes, have none
            comma = len(words) > columns and re.search(r"\d,\d+[eE ]", line) is not None
            why = "decimal commas are not read" if comma else "the file is truncated or damaged"
            msg = (
                f"field.file = {legible_path(path)}: line {number} has {len(words)} values, "
                f"expected {columns}: {why}; export it again"
            )
            raise ConfigError(msg)
        for word in words:
            try:
                float(word)
            except ValueError as error:
                msg = (
                    f'field.file = {legible_path(path)}: line {number} has "{legible(word)}", '
                    "which is no number; export it again with a decimal point"
                )
                raise ConfigError(msg) from error
    return np.empty((0, columns))


def refuse_short(path: Path, what: str, found: int, expected: int) -> None:
    """Refuse a file that has fewer, or more, of something than it says."""
    if found != expected:
        msg = (
            f"field.file = {legible_path(path)}: has {found} {what}, but says that it has "
            f"{expected}: it is truncated or damaged; export it again"
        )
        raise ConfigError(msg)


def split_unit(heading: str) -> tuple[str, str]:
    """Return name and unit of a heading: ``u (m/s)``, ``Velocity u [ m s^-1 ]``, ``p``."""
    match = UNIT.fullmatch(heading)
    if match is None or not match.group(1):
        return heading.strip(), ""
    return match.group(1), (match.group(2) or match.group(3) or "").strip()


def headed(
    table: Array, names: Sequence[str], units: Mapping[str, str], whose: str, missing: str
) -> Contents:
    """Return a table whose columns X, Y and, in space, Z hold the places.

    Parameters
    ----------
    table : (n, columns) array
        Its lines.
    names : sequence of str
        Of the columns.
    units : mapping
        Of those that have one.
    whose : str
        Whose file it is.
    missing : str
        What to say where there are no places.

    Raises
    ------
    ConfigError
        If there are no columns X and Y.
    """
    axes = [name for name in ("X", "Y", "Z") if name in names]
    if len(axes) < 2:
        raise ConfigError(missing)
    return Contents(
        format=whose,
        points=table[:, [names.index(axis) for axis in axes]],
        arrays={name: table[:, k] for k, name in enumerate(names) if name not in axes},
        units={name: unit for name, unit in units.items() if name not in axes},
        length_unit=units.get("X", ""),
        names_units=True,
    )


def unique_names(names: Sequence[str]) -> list[str]:
    """Return names without doubles: a second one of a kind is numbered."""
    seen: dict[str, int] = {}
    unique = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        unique.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return unique
