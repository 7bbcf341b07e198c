"""The figures of a sweep: main effects, maps over two axes, and what a design besides has to show.

Each is a pure function of the collected sweep, as the figures of a run are of its results.
"""

from __future__ import annotations

import textwrap
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fibermelt.report.kit.plates import Plate
from fibermelt.report.kit.style import (
    BAND,
    BLUE,
    FULL,
    INK,
    VERMILION,
    Words,
    add_axes,
    new_figure,
    plain_numbers,
)
from fibermelt.report.kit.tables import number
from fibermelt.report.sweep.maps import map_words, maps_there, sweep_maps
from fibermelt.report.sweep.marks import MARKS, SIZE, UNDETECTED
from fibermelt.report.sweep.population import (
    figure_population,
    has_population,
    population_words,
)
from fibermelt.report.sweep.sampled import (
    all_indices,
    index_words,
    quantile_words,
    sweep_indices,
    sweep_quantiles,
)
from fibermelt.report.sweep.window import figure_window, window_words
from fibermelt.sweeps.analysis import effect, why_no_effect
from fibermelt.sweeps.table import SweepTable, Varied, sweep_table
from fibermelt.sweeps.window import window_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.sweeps.responses import Response

__all__ = ["effects_words", "sweep_effects", "sweep_plates"]

ACROSS = 5
"""Parameters side by side: with more, a page has no room for their numbers."""

LEFT, RIGHT, FOOT, TOP = 22.0, 2.0, 11.0, 3.0
TALL, BETWEEN = 27.0, 4.0
"""Margins of the figure, height of a chart, and room between charts [mm]."""

SIDE_BY_SIDE, LEFT_ALONE, ALONE = 3, 17.0, 42.0
"""Charts in a row where one parameter varies, room for their numbers, and their height [mm]."""

MANY_POINTS = 400
"""Points of a chart that are drawn as lines; more as dots, whose bytes do not grow with them."""

LABEL_WIDTH = 20
"""Letters of an axis label on a line."""


def sweep_effects(collected: xr.Dataset, first: int = 0) -> Figure:
    """Draw responses against parameters: a row for each response, a column for each parameter.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep.
    first : int
        The parameter to begin with: `ACROSS` of them are drawn.
    """
    table = sweep_table(collected)
    axes, rows = table.axes[first : first + ACROSS], table.varying
    if len(axes) == 1:
        return _effects_of_one(table, axes[0])
    figure = new_figure(FULL, TOP + FOOT + len(rows) * TALL + (len(rows) - 1) * BETWEEN)
    wide = min(60.0, (FULL - LEFT - RIGHT - (len(axes) - 1) * BETWEEN) / len(axes))
    for row, response in enumerate(rows):
        bottom = FOOT + (len(rows) - 1 - row) * (TALL + BETWEEN)
        for column, axis in enumerate(axes):
            chart = add_axes(figure, LEFT + column * (wide + BETWEEN), bottom, wide, TALL)
            _chart(chart, table, response, axis)
            chart.locator_params(axis="y", nbins=4)
            if column == 0:
                chart.set_ylabel(textwrap.fill(response.heading, LABEL_WIDTH), fontsize=6.5)
            else:
                chart.tick_params(labelleft=False)
            if row == len(rows) - 1:
                chart.set_xlabel(textwrap.fill(axis.heading, max(12, int(0.65 * wide))))
            else:
                chart.tick_params(labelbottom=False)
    return figure


def _effects_of_one(table: SweepTable, axis: Varied) -> Figure:
    """Draw the responses against one parameter side by side: the width is there."""
    rows = -(-len(table.varying) // SIDE_BY_SIDE)
    across = -(-len(table.varying) // rows)
    figure = new_figure(FULL, rows * (TOP + ALONE + FOOT))
    step = FULL / across
    for place, response in enumerate(table.varying):
        row, column = divmod(place, across)
        bottom = FOOT + (rows - 1 - row) * (TOP + ALONE + FOOT)
        wide = step - LEFT_ALONE - RIGHT
        chart = add_axes(figure, LEFT_ALONE + column * step, bottom, wide, ALONE)
        _chart(chart, table, response, axis)
        chart.locator_params(axis="y", nbins=5)
        chart.set_ylabel(textwrap.fill(response.heading, 2 * LABEL_WIDTH), fontsize=6.5)
        chart.set_xlabel(axis.heading)
    return figure


def _chart(chart: Axes, table: SweepTable, response: Response, axis: Varied) -> None:
    """Draw one response against one parameter."""
    if table.is_sampled:
        many = len(axis.values) > MANY_POINTS
        chart.plot(
            axis.values,
            response.values,
            linestyle="none",
            marker="o",
            markersize=1.2 if many else 2.2,
            markeredgewidth=0,
            color=BLUE,
            alpha=0.5,
            rasterized=many,
        )
    else:
        levels, (mean, least, most) = effect(table, response, axis)
        if not np.isfinite(mean).any():
            chart.text(0.5, 0.5, "cannot be told", transform=chart.transAxes, **UNTOLD)
            chart.set_xlim(levels[0], levels[-1])
        if not table.groups and len(table.axes) > 1:
            chart.fill_between(levels, least, most, color=BAND, linewidth=0)
        chart.plot(levels, mean, color=BLUE, marker="o", markersize=3)
        if table.groups:
            chart.plot(*_own(response, axis), linestyle="none", marker="D", **OWN)
    _y_range(chart, response)
    if response.undetected.any():
        limit = float(response.limit[response.undetected].max())
        chart.axhspan(-limit, limit, zorder=0.2, **UNDETECTED)
    without = [case for case, status in enumerate(table.status) if status == "failed"]
    if without:
        marker, face, _ = MARKS["failed"]
        places = np.unique(axis.values[without])
        chart.plot(
            places,
            np.zeros(len(places)),
            marker,
            transform=chart.get_xaxis_transform(),
            ms=SIZE,
            mec=INK,
            mew=0.8,
            mfc=face,
            clip_on=False,
            zorder=4,
        )
    plain_numbers(chart)
    if axis.labels:
        chart.set_xticks(range(len(axis.labels)), [label[:12] for label in axis.labels])
        chart.set_xlim(-0.3, len(axis.labels) - 0.7)
    else:
        chart.locator_params(axis="x", nbins=4)
        chart.margins(x=0.08)


UNTOLD: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 6.5, "color": INK}
"""How a chart says that no two of its cases can be compared."""

OWN: dict[str, Any] = {"markersize": 4, "color": VERMILION, "markeredgecolor": INK}
"""How the study itself is marked."""


def _own(response: Response, axis: Varied) -> tuple[list[float], list[float]]:
    """Return the point of the study itself, one at a time."""
    return [float(axis.values[0])], [float(response.values[0])]


def _y_range(chart: Axes, response: Response) -> None:
    """Give the charts of a response one scale, so that effects can be compared."""
    there = response.values[np.isfinite(response.values)]
    room = 0.07 * float(np.ptp(there))
    chart.set_ylim(float(there.min()) - room, float(there.max()) + room)


def effects_words(collected: xr.Dataset, first: int = 0) -> Words:
    """Return caption and alternative text of `sweep_effects`."""
    table = sweep_table(collected)
    axes = table.axes[first : first + ACROSS]
    names = ", ".join(axis.title for axis in axes)
    if table.is_sampled:
        how = "A point for each case" + ("; all vary at once." if len(table.axes) > 1 else ".")
    elif table.groups:
        how = (
            "One parameter varies at a time, all else is as in the study itself, the diamond. "
            "Lines only guide the eye."
        )
    elif len(table.axes) > 1:
        how = (
            "Lines: the mean over all other parameters; grey: from the least to the largest "
            "response over them. Where cases have no answer, the mean is over those combinations "
            "of the others that the most values share, and of these alone."
        )
        untold = [
            axis.title
            for axis in axes
            if not any(np.isfinite(effect(table, one, axis)[1][0]).any() for one in table.varying)
        ]
        if untold:
            how += f" What {' or '.join(untold)} does cannot be told: {why_no_effect(table)}."
    else:
        how = "A point for each case."
    if count := table.status.count("failed"):
        how += f" Crosses: values with failed cases, {count} of {len(table.status)} in all."
    if any(one.undetected.any() for one in table.varying):
        how += " Dotted: below the numerical error, not told from zero."
    if any(len(axis.keys) > 1 for axis in axes):
        how += (
            " Keys that vary together are one parameter: which of them moves a response cannot be "
            "told from it."
        )
    same = [one.title.lower() for one in table.responses if not one.varies]
    rest = f" The same in all cases, or not there: {', '.join(same)}." if same else ""
    return Words(
        caption=(
            f"{_heading(table)}: responses against {names}, to one scale for each response. "
            f"{how}{rest}"
        ),
        alt=(
            f"Small charts of {len(table.varying)} responses against {names}. "
            + " ".join(_strongest(table, one, axes) for one in table.varying)
        ),
    )


def _heading(table: SweepTable) -> str:
    """Return what the charts are: samples vary all at once, and show no effect by themselves."""
    return "Samples" if table.is_sampled else "Main effects"


def _strongest(table: SweepTable, response: Response, axes: tuple[Varied, ...]) -> str:
    """Return the range of a response in words, and what it follows most where that can be said."""
    there = response.values[np.isfinite(response.values)]
    unit = f" {response.unit}" if response.unit else ""
    told = f"{response.title}: {number(float(there.min()), 3)} to {number(float(there.max()), 3)}"
    if table.is_sampled or len(axes) < 2:
        return f"{told}{unit}."
    spans = {}
    for axis in axes:
        means = effect(table, response, axis)[1][0]
        means = means[np.isfinite(means)]
        if means.size > 1:
            spans[axis.title] = float(np.ptp(means))
    if not spans:
        return f"{told}{unit}; by what cannot be told."
    return f"{told}{unit}, most by {max(spans, key=lambda title: spans[title])}."


def sweep_plates(collected: xr.Dataset) -> tuple[Plate, ...]:
    """Return the figures that a collected sweep is enough for, in the order of its report.

    Parameters
    ----------
    collected : xarray.Dataset
        As `fibermelt.sweeps.collect.collect_sweep` returns it.
    """
    table = sweep_table(collected)
    found: list[Plate] = []
    if window_of(table) is not None:
        found.append(Plate("window", "The process window", figure_window, window_words))
    if has_population(collected, table):
        found.append(
            Plate("population", "Pressures over the bead", figure_population, population_words)
        )
    if table.varying:
        for first in range(0, len(table.axes), ACROSS):
            more = f", from {table.axes[first].title} on" if first else ""
            found.append(
                Plate(
                    f"effects-{first // ACROSS + 1}" if first else "effects",
                    f"{_heading(table)}{more}",
                    partial(sweep_effects, first=first),
                    partial(effects_words, first=first),
                )
            )
    if maps_there(table):
        found.append(Plate("maps", "Responses over both parameters", sweep_maps, map_words))
    if table.is_sampled and table.varying:
        found.append(Plate("quantiles", "Spread of the responses", sweep_quantiles, quantile_words))
    if indices := all_indices(table):
        found.append(
            Plate(
                "indices",
                "What the spread is due to",
                partial(sweep_indices, found=indices),
                partial(index_words, found=indices),
            )
        )
    return tuple(found)
