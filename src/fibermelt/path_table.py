"""Paths as a table: CSV with a line for each point, from whatever solver or measurement.

The first line names the columns, each with its unit in brackets or parentheses, SI without one:
``path, time [s], x [mm], y [mm], z [mm], u [mm/s], v, w, pressure [MPa], viscosity, temperature``
and the gradient's ``L_xx`` to ``L_zz`` [1/s], ``L_xy = du/dy``. Without ``z`` the paths lie in a
plane; without ``path`` there is one. Lines of a path stand in the order of its time.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, legible, legible_path
from fibermelt.history import FlowHistory
from fibermelt.interpolation import PathInterpolant
from fibermelt.units import parse

__all__ = ["PathTable", "as_many_points", "is_path_table", "read_paths"]

Array = NDArray[np.float64]

AXES = ("x", "y", "z")
SPEEDS = ("u", "v", "w")

UNITS = {
    "path": "",
    "time": "s",
    **dict.fromkeys(AXES, "m"),
    **dict.fromkeys(SPEEDS, "m/s"),
    "pressure": "Pa",
    "viscosity": "Pa s",
    "temperature": "K",
    **{f"L_{i}{j}": "1/s" for i in AXES for j in AXES},
}
"""Columns, and what they are converted to."""

OPTIONAL = ("pressure", "viscosity", "temperature")
"""What need not be known; a pressure that is not is zero: fibers then tell what they add to it."""

LARGEST_TRACE = 0.01
"""Part of a gradient that its trace may be, to be taken out and told: more is no melt."""

COLUMN = re.compile(r"\s*(?P<name>[^\[(]*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*")
"""A column's name and its unit."""


@dataclass(frozen=True, eq=False)
class PathTable:
    """What a table of paths holds.

    Parameters
    ----------
    histories : tuple of FlowHistory
        The paths, in the order in which they begin in the table.
    divergence : tuple of float
        The largest trace that was taken out of each path's gradient, over the gradient there [-].
    notes : tuple of str
        What was done to the data on the way, in words.
    numbers : tuple of int
        What the table calls the paths; 1, 2, ... where it has no whole numbers for them.
    """

    histories: tuple[FlowHistory, ...]
    divergence: tuple[float, ...]
    notes: tuple[str, ...]
    numbers: tuple[int, ...]


def is_path_table(head: bytes) -> bool:
    """Tell whether the first bytes of a file are those of a table of paths: time and a gradient."""
    first = head.decode("utf-8-sig", errors="replace").partition("\n")[0]
    matches = (COLUMN.fullmatch(name) for name in first.split(","))
    names = {match["name"] for match in matches if match is not None}
    return {"time", "L_xx"} <= names <= {*UNITS}


def read_paths(file: str | Path) -> PathTable:
    """Read a table of paths.

    Parameters
    ----------
    file : str or Path
        A CSV file, as the module's docstring says; ``#`` begins a comment.

    Raises
    ------
    ConfigError
        If there is no such file, a column is missing or not known, or a line has no numbers.
    HistoryError
        If a path is none (`FlowHistory`).
    """
    shown = legible_path(Path(file))
    columns, numbers = _numbers(Path(file), shown)
    dimension = 3 if "z" in columns else 2
    axes, speeds = AXES[:dimension], SPEEDS[:dimension]
    tensor = tuple(f"L_{i}{j}" for i in axes for j in axes)
    wanted = ("time", *axes, *speeds, *tensor)
    missing = [name for name in wanted if name not in columns]
    if missing:
        where = "a plane" if dimension == 2 else "space"
        msg = (
            f"{shown}: no column {', '.join(missing)}: a path in {where} needs {', '.join(wanted)}"
        )
        raise ConfigError(msg)
    by_name = dict(zip(columns, numbers.T, strict=True))
    number = by_name.get("path", np.zeros(len(numbers)))
    found, divergence = [], []
    for path in dict.fromkeys(number.tolist()):
        rows = number == path
        gradient = _stacked(by_name, tensor, rows).reshape(-1, dimension, dimension)
        trace = np.trace(gradient, axis1=-2, axis2=-1)
        size = np.linalg.norm(gradient, axis=(-2, -1))
        part = float(np.max(np.abs(trace), initial=0.0) / max(float(np.max(size)), 1e-300))
        if part > LARGEST_TRACE:
            msg = (
                f"{shown}: path {path:g}: the gradient has a trace of {part:.2g} of its size: an "
                f"incompressible melt has none (at most {LARGEST_TRACE:g} is taken out)"
            )
            raise ConfigError(msg)
        even = trace[:, None, None] / dimension * np.eye(dimension)
        known = {name: by_name[name][rows] for name in OPTIONAL if name in by_name}
        found.append(
            FlowHistory(
                time=by_name["time"][rows],
                position=_stacked(by_name, axes, rows),
                velocity=_stacked(by_name, speeds, rows),
                gradient=gradient - even,
                **({"pressure": np.zeros(int(rows.sum()))} | known),
            )
        )
        divergence.append(part)
    notes = []
    if max(divergence) > 0.0:
        notes.append(f"a trace of up to {max(divergence):.2g} of the gradient was taken out")
    if "pressure" not in by_name:
        notes.append("there is no pressure: it is taken for zero, that of the surrounding air")
    names = list(dict.fromkeys(number.tolist()))
    if "path" not in by_name or not all(name.is_integer() for name in names):
        names = list(range(1, len(found) + 1))
    called = tuple(int(name) for name in names)
    return PathTable(tuple(found), tuple(divergence), tuple(notes), called)


def _stacked(columns: dict[str, Array], names: Sequence[str], rows: NDArray[np.bool_]) -> Array:
    return np.stack([columns[name][rows] for name in names], axis=-1)


def _numbers(path: Path, shown: str) -> tuple[list[str], Array]:
    """Return the names of the columns, and the lines in SI, (n, columns)."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        msg = f"{shown}: cannot be read as a table of paths: {reason.lower()}"
        raise ConfigError(msg) from error
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    try:
        rows = list(csv.reader(lines, skipinitialspace=True))
    except csv.Error as error:
        msg = f"{shown}: cannot be read as a table of paths: {error}"
        raise ConfigError(msg) from error
    if len(rows) < 2:
        msg = (
            f"{shown}: holds no path: a line with the names of the columns, then one for each point"
        )
        raise ConfigError(msg)
    names, scales = [], []
    for head in rows[0]:
        match = COLUMN.fullmatch(head)
        name = match["name"] if match else head
        if match is None or name not in UNITS or name in names:
            twice = (
                "stands twice" if name in names else f"is not known; known are {', '.join(UNITS)}"
            )
            msg = f'{shown}: column "{legible(head)}" {twice}'
            raise ConfigError(msg)
        names.append(name)
        scales.append(_scale(match["unit"], UNITS[name], f'{shown}: column "{legible(head)}"'))
    values = np.empty((len(rows) - 1, len(names)))
    for k, row in enumerate(rows[1:]):
        try:
            values[k] = [float(cell) for cell in row]
        except ValueError as error:
            msg = (
                f"{shown}: point {k + 1} ({legible(lines[k + 1])}): must be {len(names)} numbers, "
                f"one for each of {', '.join(names)}"
            )
            raise ConfigError(msg) from error
    factor, offset = np.array(scales).T
    return names, factor * values + offset


def _scale(unit: str | None, si: str, what: str) -> tuple[float, float]:
    """Return factor and offset from a column's unit to SI."""
    if not unit or not si:
        return 1.0, 0.0
    try:
        zero = parse(f"0 {unit}", si)
        return parse(f"1 {unit}", si) - zero, zero
    except ConfigError as error:
        msg = f"{what} {error}"
        raise ConfigError(msg) from error


def as_many_points(histories: Sequence[FlowHistory]) -> tuple[FlowHistory, ...]:
    """Return single paths with as many points each as the longest has.

    Points are put between those of a shorter one where the strain from one to the next is largest,
    on the cubic that fibers are followed by anyway: its own points stay, and nothing is lost.
    """
    most = max(len(history) for history in histories)
    return tuple(_refined(history, most) for history in histories)


def _refined(history: FlowHistory, points: int) -> FlowHistory:
    """Return a single path with points put in until it has so many."""
    missing = points - len(history)
    if missing == 0:
        return history
    rate = history.shear_rate
    strain = 0.5 * np.diff(history.time) * (rate[1:] + rate[:-1]) + 1e-12
    parts = np.ones(len(strain), dtype=np.intp)
    for _ in range(missing):
        parts[np.argmax(strain / parts)] += 1
    interval = np.repeat(np.arange(len(parts)), parts)
    fraction = np.concatenate([np.arange(count) / count for count in parts])

    def between(values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        inner = PathInterpolant(history.time, flat)((interval,), fraction[:, None])
        return np.concatenate([inner, flat[-1:]]).reshape(-1, *values.shape[1:])

    step = np.diff(history.time)
    time = np.append(history.time[interval] + fraction * step[interval], history.time[-1])
    values = {
        name: between(getattr(history, name)) for name in history.quantities if name != "time"
    }
    return replace(history, time=time, **values)
