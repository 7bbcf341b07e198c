"""The process window: severity over two parameters, as contours between the cases."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.ticker import MaxNLocator

from fibermelt.errors import ConfigError
from fibermelt.report.kit.style import (
    FULL,
    INK,
    SEQUENTIAL,
    UNJUDGED,
    Array,
    Words,
    add_axes,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import number
from fibermelt.report.sweep.marks import MARKS, SIZE, UNDETECTED, became, case_mark, told
from fibermelt.sweeps.table import SweepTable, sweep_table
from fibermelt.sweeps.window import Window, window_advice, window_of

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.sweeps.responses import Response

__all__ = ["contour_levels", "figure_window", "window_words"]

HEIGHT, LEFT, WIDE, FOOT, TOP = 84.0, (16.0, 108.0), 78.0, 19.0, 7.0
"""Of the figure, where its charts stand, and the room below and above them [mm]."""

WRITTEN = 5
"""Values along an axis up to which the number of every case is written beside it."""

STEPS = 7
"""Steps between contours at most."""

ROOM = 0.09
"""What stays free around the cases, of the range of an axis."""


def figure_window(collected: xr.Dataset) -> Figure:
    """Draw the leading responses of a sweep over two numbers.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep with a process window (`fibermelt.sweeps.window.window_of`).
    """
    table, window = _window(collected)
    figure = new_figure(FULL, HEIGHT)
    for k, response in enumerate(window.measures):
        axes = add_axes(figure, LEFT[k], FOOT, WIDE, HEIGHT - FOOT - TOP)
        _panel(axes, table, window, response)
        letter(axes, f"{'ab'[k]}  {response.heading}")
        axes.set_xlabel(window.across.heading)
        if k == 0:
            axes.set_ylabel(window.up.heading)
    figure.legend(
        handles=_key(table, window),
        loc="lower left",
        bbox_to_anchor=(LEFT[0] / FULL, 0.01),
        ncols=4,
        columnspacing=1.4,
        handletextpad=0.5,
    )
    return figure


def _window(collected: xr.Dataset) -> tuple[SweepTable, Window]:
    """Return a sweep and its process window.

    Raises
    ------
    ConfigError
        If it has none.
    """
    table = sweep_table(collected)
    window = window_of(table)
    if window is None:
        msg = "the sweep has no process window: it takes a grid over two numbers, and an answer"
        raise ConfigError(msg)
    return table, window


def contour_levels(values: Array, limit: Array) -> Array:
    """Return round levels for contours, no closer than errors tell two values apart.

    Parameters
    ----------
    values, limit : array
        A response, and its limits of detection; NaN where there is none.

    Returns
    -------
    (n,) array
        In rising order, the ends around all values; two ends only where nothing is told apart.
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    least = 2.0 * float(np.nanmax(np.where(np.isfinite(values), limit, 0.0)))
    for steps in range(STEPS, 1, -1):
        found = MaxNLocator(steps, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
        if float(found[1] - found[0]) >= least:
            return np.asarray(found, dtype=float)
    beyond = max(least, abs(high), abs(low), np.finfo(float).tiny)
    return np.array([low - beyond, high + beyond])


def _panel(axes: Axes, table: SweepTable, window: Window, response: Response) -> None:
    """Draw one response: contours as far as its errors carry them, and every case."""
    x, y = (np.array(axis.levels) for axis in (window.across, window.up))
    values, limit = window.over(response.values), window.over(response.limit)
    for low, high, place in ((x[0], x[-1], axes.set_xlim), (y[0], y[-1], axes.set_ylim)):
        room = ROOM * (high - low)
        place(low - room, high + room)
    axes.add_patch(Rectangle((x[0], y[0]), np.ptp(x), np.ptp(y), zorder=0.5, **UNJUDGED))
    if _has_area(np.isfinite(values)):
        field, levels = np.ma.masked_invalid(values), contour_levels(values, limit)
        axes.contourf(x, y, field, levels=levels, cmap=SEQUENTIAL, zorder=1)
        between = [level for level in levels[1:-1] if field.min() < level < field.max()]
        if between:
            lines = axes.contour(
                x, y, field, levels=between, colors="white", linewidths=0.8, zorder=1.2
            )
            axes.clabel(lines, fontsize=6.5, fmt=lambda level: number(level, 3))
        above = np.ma.masked_invalid(np.abs(values) - limit)
        if above.min() <= 0.0:
            area = axes.contourf(x, y, above, levels=[above.min() - 1.0, 0.0])
            for path in area.get_paths():
                axes.add_patch(PathPatch(path, zorder=1.5, **UNDETECTED))
            area.remove()
    for (row, column), case in np.ndenumerate(window.cases):
        at, (marker, face, _) = (
            (float(x[column]), float(y[row])),
            MARKS[became(table, response, int(case))],
        )
        axes.plot(*at, marker, ms=SIZE, mec=INK, mew=0.8, mfc=face, clip_on=False, zorder=4)
        if max(window.cases.shape) <= WRITTEN and np.isfinite(values[row, column]):
            _write(axes, at, told(response, int(case)))


def _write(axes: Axes, at: tuple[float, float], text: str) -> None:
    """Write the number of a case over its mark."""
    axes.annotate(
        text,
        at,
        xytext=(0, 5),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=6.5,
        zorder=4,
        bbox={"facecolor": "white", "alpha": 0.85, "pad": 0.8, "linewidth": 0},
    )


def _has_area(known: NDArray[np.bool_]) -> bool:
    """Tell whether three cases that are neighbors have a number: contours need that."""
    corners = known[:-1, :-1].astype(int) + known[1:, :-1] + known[:-1, 1:] + known[1:, 1:]
    return bool((corners >= 3).any())


def _key(table: SweepTable, window: Window) -> list[Line2D | Patch]:
    """Return the entries of the key, of what is there."""
    there = {
        became(table, one, case) for one in window.measures for case in range(len(table.status))
    }
    key: list[Line2D | Patch] = [case_mark(name) for name in MARKS if name in there]
    if any(_none(one).any() for one in window.measures):
        key.append(Patch(label="not detected: below its error", **UNDETECTED))
    if there != {"done"}:
        key.append(Patch(label="no answer", **UNJUDGED))
    return key


def _none(response: Response) -> NDArray[np.bool_]:
    """Return which cases have none of a response, as far as its error tells."""
    return np.asarray(response.undetected | (response.values == 0.0))


def window_words(collected: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_window`; what it comes to is part of both."""
    table, window = _window(collected)
    advice = window_advice(table)
    names = " and ".join(one.title[0].lower() + one.title[1:] for one in window.measures)
    meanings = "; ".join(
        f"({letter_}) {one.meaning}"
        for letter_, one in zip("ab", window.measures, strict=False)
        if one.meaning
    )
    dotted = (
        " Dotted: below its error, so not told from zero."
        if any(_none(one).any() for one in window.measures)
        else ""
    )
    missing = f" No answer: {table.missing}." if table.missing else ""
    return Words(
        caption=(
            f"Process window: {names} over {window.across.title} and {window.up.title}; "
            f"{meanings}. Contours between the cases are linear, and no closer than twice the "
            f"largest numerical error.{dotted}{missing} {advice}"
        ).rstrip(),
        alt=" ".join(
            [
                f"Maps of {names} over {window.across.title} and {window.up.title}.",
                *(_ends(table, one) for one in window.measures),
                advice,
            ]
        ).rstrip(),
    )


def _ends(table: SweepTable, response: Response) -> str:
    """Return where a response is lowest and highest."""
    low, high = int(np.nanargmin(response.values)), int(np.nanargmax(response.values))
    return (
        f"{response.title}: {told(response, low)} at {table.point(low)}, "
        f"{told(response, high)} at {table.point(high)}."
    )
