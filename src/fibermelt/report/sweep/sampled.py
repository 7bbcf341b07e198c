"""Figures of sampled sweeps: how far responses spread, and what that is due to."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fibermelt.report.kit.style import (
    BLUE,
    FULL,
    GREY,
    INK,
    VERMILION,
    Array,
    Words,
    add_axes,
    key_mark,
    new_figure,
    plain_numbers,
)
from fibermelt.report.kit.tables import number
from fibermelt.sweeps.analysis import (
    FEWEST_CASES,
    LEVELS,
    Indices,
    quantiles,
    shares_below,
    sobol_indices,
    why_no_indices,
)
from fibermelt.sweeps.table import SweepTable, Varied, sweep_table

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.sweeps.responses import Response

__all__ = [
    "QUANTILE_RULE",
    "all_indices",
    "index_words",
    "quantile_words",
    "sweep_indices",
    "sweep_quantiles",
    "weighing_told",
]

ACROSS = 3
LEFT, WIDE, STEP = 14.0, 50.0, 61.0
TALL, RISE, FOOT = 34.0, 50.0, 12.0
"""Charts side by side, where the first stands, their size and their distances [mm]."""

NAMES, NARROW, APART = 40.0, 44.0, 49.0
"""Of the indices: room for the names, width of a chart, distance of charts [mm]."""

LINE = 6.0
"""Height of a parameter's line among the indices [mm]."""

CLEAR: dict[str, Any] = {"facecolor": "white", "alpha": 0.8, "pad": 0.4, "linewidth": 0}
"""Ground of a number that a curve may run under; the lowest one stands on the axis."""

STEPS = 512
"""Points of a distribution that are drawn: of more cases, every so many."""

QUANTILE_RULE = (
    "Each case stands in the middle of its share, and quantiles are linear between cases "
    "(Hazen's rule)."
)

MEANINGS = {
    "fiber.aspect_ratio": "of fibers of one width, shares of the fiber length and volume",
    "fiber.half_length": "shares of the fiber length",
}
"""What weighing by a key gives shares of, where the cases are counted by number."""


def weighing_told(weighing: Varied) -> str:
    """Return how cases are weighed, and what shares that gives.

    Parameters
    ----------
    weighing : Varied
        What a case is weighed by.
    """
    meaning = MEANINGS.get(weighing.keys[0])
    return f"each weighed by its {weighing.title}" + (f" ({meaning})" if meaning else "")


def sweep_quantiles(collected: xr.Dataset) -> Figure:
    """Draw the distribution of each response over the samples, with its quantiles.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep of a sampled design.
    """
    table = sweep_table(collected)
    rows = -(-len(table.varying) // ACROSS)
    figure = new_figure(FULL, RISE * rows)
    for place, response in enumerate(table.varying):
        row, column = divmod(place, ACROSS)
        bottom = FOOT + (rows - 1 - row) * RISE
        axes = add_axes(figure, LEFT + column * STEP, bottom, WIDE, TALL)
        _distribution(axes, response)
        if table.weighing is not None:
            axes.plot(*_curve(response, table.weighing.values), color=INK, linestyle="--")
        if column == 0:
            axes.set_ylabel("share of the cases below [%]")
    return figure


def _curve(response: Response, weights: Array | None = None) -> tuple[Array, Array]:
    """Return values of a response, and the share that lies below each [%], as far as drawn."""
    values, share = shares_below(response.values, weights)
    chosen = slice(None, None, max(1, len(values) // STEPS))
    return values[chosen], 100 * share[chosen]


def _distribution(axes: Axes, response: Response) -> None:
    """Draw the distribution by number, with its quantiles."""
    axes.plot(*_curve(response), color=BLUE)
    for level, value in zip(LEVELS, quantiles(response.values), strict=True):
        axes.plot([value, value], [0, 100 * level], color=GREY, linewidth=0.6)
        axes.plot([value], [100 * level], color=VERMILION, marker="o", markersize=3.5)
        axes.annotate(
            number(float(value), 3),
            (value, 100 * level),
            xytext=(5, -1),
            textcoords="offset points",
            fontsize=6.5,
            va="center" if level == LEVELS[0] else "top",
            bbox=None if level == LEVELS[0] else CLEAR,
        )
    axes.set_ylim(0, 100)
    axes.set_yticks([5, 50, 95])
    axes.margins(x=0.12)
    axes.locator_params(axis="x", nbins=4)
    plain_numbers(axes)
    axes.set_xlabel(textwrap.fill(response.heading, 36))


def quantile_words(collected: xr.Dataset) -> Words:
    """Return caption and alternative text of `sweep_quantiles`."""
    table = sweep_table(collected)
    told = []
    for one in table.varying:
        low, middle, high = (number(float(value), 3) for value in quantiles(one.values))
        unit = f" {one.unit}" if one.unit else ""
        told.append(f"{one.title}: median {middle}{unit}, 5 to 95 % from {low} to {high}{unit}.")
    if table.weighing is not None:
        told.append(_weighed(table, table.weighing))
    cases = int(np.count_nonzero(np.isfinite(table.varying[0].values)))
    return Words(
        caption=(
            f"Share of the cases in which a response is lower, over {cases} cases, with the "
            "quantiles at 5, 50 and 95 %: how far the response spreads when the parameters are as "
            f"uncertain as the study says. {QUANTILE_RULE}{_dashed(table)}{_without_indices(table)}"
        ),
        alt=" ".join(told),
    )


def _dashed(table: SweepTable) -> str:
    """Return what the dashed lines are, where there are any."""
    return f" Dashed: {weighing_told(table.weighing)}." if table.weighing is not None else ""


def _weighed(table: SweepTable, weighing: Varied) -> str:
    """Return the medians of the responses with every case weighed."""
    medians = []
    for one in table.varying:
        middle = number(float(quantiles(one.values, (0.5,), weighing.values)[0]), 3)
        medians.append(f"{one.title} {middle} {one.unit}".rstrip())
    return f"Medians with each case weighed by its {weighing.title}: {', '.join(medians)}."


Found = Sequence[tuple["Response", Indices]]
"""Responses with their indices."""


def all_indices(table: SweepTable) -> Found:
    """Return the responses whose indices the sweep can give, with these; none of one parameter."""
    if not table.is_sampled or len(table.axes) == 1:
        return []
    found = [(one, sobol_indices(table, one)) for one in table.varying]
    return [(one, indices) for one, indices in found if indices is not None]


def _without_indices(table: SweepTable) -> str:
    """Return why responses have no indices, for each reason those that it keeps from them."""
    if len(table.axes) == 1:
        return ""
    reasons: dict[str, list[str]] = {}
    for one in table.varying:
        if reason := why_no_indices(table, one):
            reasons.setdefault(reason, []).append(one.title)
    if [len(names) for names in reasons.values()] == [len(table.varying)]:
        reason = next(iter(reasons))
        return f" {reason[0].upper()}{reason[1:]}."
    return "".join(f" {'; '.join(names)}: {reason}." for reason, names in reasons.items())


def sweep_indices(collected: xr.Dataset, found: Found | None = None) -> Figure:
    """Draw the Sobol indices of each response, with half 95 % intervals.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep whose design gives them.
    found : sequence of (Response, Indices), optional
        What `all_indices` found in it; it saves the time to find it.
    """
    table = sweep_table(collected)
    found = found or all_indices(table)
    rows, tall = -(-len(found) // ACROSS), LINE * len(table.axes) + 4
    rise = tall + 18
    figure = new_figure(FULL, rise * rows + 8)
    for place, (response, indices) in enumerate(found):
        row, column = divmod(place, ACROSS)
        axes = add_axes(figure, NAMES + column * APART, 10 + (rows - 1 - row) * rise, NARROW, tall)
        _index_lines(axes, indices)
        axes.set_title(textwrap.fill(response.title, 32), loc="left", pad=3)
        if column == 0:
            names = [textwrap.fill(axis.title, 28) for axis in table.axes]
            axes.set_yticks(range(len(names)), names)
        else:
            axes.set_yticks(range(len(table.axes)), [""] * len(table.axes))
        axes.set_xlabel("share of the variance")
    figure.legend(handles=_key(found[0][1]), loc="upper left", ncols=2, fontsize=7)
    return figure


def _index_lines(axes: Axes, indices: Indices) -> None:
    places = np.arange(len(indices.first))
    shift = 0.0 if indices.total is None else 0.14
    look: dict[str, Any] = {"linestyle": "none", "markersize": 4, "elinewidth": 0.8}
    axes.errorbar(
        indices.first, places - shift, xerr=indices.first_margin, marker="o", color=BLUE, **look
    )
    if indices.total is not None:
        axes.errorbar(
            indices.total,
            places + shift,
            xerr=indices.total_margin,
            marker="D",
            markerfacecolor="white",
            color=VERMILION,
            **look,
        )
    axes.axvline(0.0, color=INK, linewidth=0.5)
    axes.set_xlim(min(-0.1, axes.get_xlim()[0]), max(1.1, axes.get_xlim()[1]))
    axes.set_ylim(len(places) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)


def _key(indices: Indices) -> list[Line2D]:
    handles = [key_mark("o", "first order: when it alone is known", BLUE, 4)]
    if indices.total is not None:
        label = "total: when all others are known"
        handles.append(key_mark("D", label, VERMILION, 4, face="white"))
    return handles


def index_words(collected: xr.Dataset, found: Found | None = None) -> Words:
    """Return caption and alternative text of `sweep_indices`; the method is part of the caption."""
    table = sweep_table(collected)
    found = found or all_indices(table)
    methods = {
        "saltelli": (
            "first-order index, the share of a response's variance that goes when a parameter is "
            "known, and total index, the share that stays when all others are; both by the "
            "estimators of Saltelli et al. (2010) from a Saltelli design, as SALib has them. "
            "Blocks with a case that has no answer are left out"
        ),
        "rbd-fast": (
            "first-order index, the share of a response's variance that goes when a parameter is "
            "known, by RBD-FAST for given samples (Plischke 2010; bias correction of Tissot and "
            "Prieur 2012), as SALib has it. This design gives no total index: design = "
            '"saltelli" does. A margin that is wide against the index says that there are too few '
            f"cases; below {FEWEST_CASES} none is told"
        ),
    }
    _, one = found[0]
    return Words(
        caption=(
            f"Sobol indices: {methods[one.method]}. From {one.cases} cases; lines are 95 % "
            "intervals of a bootstrap. An estimate may fall below 0 or above 1 within its interval."
        ),
        alt=" ".join(_told(table, response, indices) for response, indices in found),
    )


def _told(table: SweepTable, response: Response, indices: Indices) -> str:
    shares = ", ".join(
        f"{axis.title} {number(float(share), 2)} ± {number(float(margin), 2)}"
        for axis, share, margin in zip(table.axes, indices.first, indices.first_margin, strict=True)
    )
    return f"{response.title}, first order: {shares}."
