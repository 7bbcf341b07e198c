"""Maps of a sweep's responses over the two parameters of a grid."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fibermelt.report.kit.style import (
    FULL,
    INK,
    OTHERS,
    SEQUENTIAL,
    Words,
    add_axes,
    new_figure,
    plain_numbers,
)
from fibermelt.report.kit.tables import number
from fibermelt.report.sweep.marks import MARKS, SIZE, became, told
from fibermelt.sweeps.table import SweepTable, Varied, sweep_table

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.report.kit.style import Array
    from fibermelt.sweeps.responses import Response

__all__ = ["map_words", "maps_there", "sweep_maps"]

ACROSS = 3
LEFT, WIDE, TALL, STEP, RISE, FOOT = 17.0, 46.0, 36.0, 60.0, 56.0, 12.0
"""Maps side by side, where the first stands, their size and their distances [mm]."""

WRITTEN = 6
"""Values along an axis up to which every number is written into the map."""

DARK = 0.55
"""Share of the scale below which its colour is so dark that letters on it are white."""


def maps_there(table: SweepTable) -> bool:
    """Tell whether a sweep is a grid over two parameters whose responses vary over both."""
    return (
        table.design == "grid"
        and len(table.shape) == 2
        and min(table.shape) > 1
        and bool(table.varying)
    )


def sweep_maps(collected: xr.Dataset) -> Figure:
    """Draw a map for each response: the first parameter upwards, the second to the right.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep, of a grid over two parameters.
    """
    table = sweep_table(collected)
    rows = -(-len(table.varying) // ACROSS)
    figure = new_figure(FULL, FOOT + RISE * rows - 12)
    for place, response in enumerate(table.varying):
        row, column = divmod(place, ACROSS)
        bottom = FOOT + (rows - 1 - row) * RISE
        axes = add_axes(figure, LEFT + column * STEP, bottom, WIDE, TALL)
        _map(axes, table, response)
        upright, along = table.axes
        if column == 0:
            axes.set_ylabel(textwrap.fill(upright.heading, 30))
        # Under the last map of each column, also where the row below is not full.
        if place + ACROSS >= len(table.varying):
            axes.set_xlabel(textwrap.fill(along.heading, 34))
    return figure


def _map(axes: Axes, table: SweepTable, response: Response) -> None:
    upright, along = table.axes
    values = response.values.reshape(table.shape)
    rows, up = _ordered(upright.values.reshape(table.shape)[:, 0])
    columns, right = _ordered(along.values.reshape(table.shape)[0])
    shown = values[np.ix_(rows, columns)]
    cases = np.arange(values.size).reshape(table.shape)[np.ix_(rows, columns)]
    scale = mpl.colors.Normalize(np.nanmin(shown), np.nanmax(shown))
    axes.set_facecolor(OTHERS)
    axes.imshow(
        np.ma.masked_invalid(shown),
        origin="lower",
        aspect="auto",
        cmap=SEQUENTIAL,
        norm=scale,
    )
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    _ticks(axes, upright, up, is_upright=True)
    _ticks(axes, along, right, is_upright=False)
    axes.set_title(textwrap.fill(response.heading, 36), loc="left", pad=3)
    if max(table.shape) <= WRITTEN:
        for (row, column), value in np.ndenumerate(shown):
            if not np.isfinite(value):
                continue
            text, light = told(response, int(cases[row, column])), scale(value) < DARK
            color = "white" if light else INK
            axes.text(column, row, text, ha="center", va="center", color=color, fontsize=6.5)
    else:
        plain_numbers(axes.figure.colorbar(axes.images[0], ax=axes, pad=0.02, fraction=0.06).ax)
    for row, column in np.argwhere(~np.isfinite(shown)):
        marker, face, _ = MARKS[became(table, response, int(cases[row, column]))]
        axes.plot(column, row, marker, ms=SIZE, mec=INK, mew=0.8, mfc=face)


def _ordered(values: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the order of the values of an axis, and the values in it."""
    order = np.argsort(values, kind="stable")
    return order, values[order]


def _ticks(axes: Axes, varied: Varied, values: Array, *, is_upright: bool) -> None:
    """Write the values of an axis at the middle of their rows or columns; some, if many."""
    step = -(-len(values) // WRITTEN)
    places = list(range(0, len(values), step))
    texts = [
        varied.labels[int(values[k])][:10] if varied.labels else f"{values[k]:.4g}" for k in places
    ]
    (axes.set_yticks if is_upright else axes.set_xticks)(places, texts)


def map_words(collected: xr.Dataset) -> Words:
    """Return caption and alternative text of `sweep_maps`."""
    table = sweep_table(collected)
    upright, along = table.axes
    without = {
        became(table, one, int(case))
        for one in table.varying
        for case in np.flatnonzero(~np.isfinite(one.values))
    }
    words = {"failed": "cross", "pending": "circle", "none": "square"}
    listed = ", ".join(f"{words[name]}: {MARKS[name][2]}" for name in MARKS if name in without)
    counted = f" ({table.missing})" if table.missing else ""
    grey = f" Grey: no answer, {listed}{counted}." if without else ""
    if any(one.undetected.any() for one in table.varying):
        grey += " What stands as less than a number is not told from zero, by its error."
    return Words(
        caption=(
            f"Responses over {upright.title} and {along.title}, a field for each case; each map "
            f"has a scale of its own, from blue (lowest) to yellow (highest).{grey} Steps between "
            "the values are drawn alike, whatever they are."
        ),
        alt=" ".join(_ends(table, one) for one in table.varying),
    )


def _ends(table: SweepTable, response: Response) -> str:
    """Return where a response is lowest and highest."""
    unit = f" {response.unit}" if response.unit else ""
    low, high = int(np.nanargmin(response.values)), int(np.nanargmax(response.values))
    return (
        f"{response.title}: lowest {number(float(response.values[low]), 3)}{unit} at "
        f"{table.point(low)}; highest {number(float(response.values[high]), 3)}{unit} at "
        f"{table.point(high)}."
    )
