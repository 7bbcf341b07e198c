"""What a population of fibers meets over the bead: lowest pressures by streamline, with bands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from fibermelt.report.kit.scene import MPA
from fibermelt.report.kit.style import (
    BAND,
    BLUE,
    FULL,
    INK,
    Array,
    Words,
    add_axes,
    key_above,
    key_mark,
    letter,
    new_figure,
    plain_numbers,
)
from fibermelt.report.kit.tables import number
from fibermelt.report.sweep.sampled import QUANTILE_RULE, weighing_told
from fibermelt.sweeps.analysis import LEVELS, quantiles
from fibermelt.sweeps.table import SweepTable, sweep_table

if TYPE_CHECKING:
    import xarray as xr

Which = NDArray[np.bool_]
"""Which streamlines."""

__all__ = ["figure_population", "has_population", "population_words"]

HEIGHT, LEFT, WIDE, TALL = 74.0, (14.0, 109.0), 78.0, 50.0
"""Of the figure, and where its two charts stand and how large they are [mm]."""

NEEDED = ("streamline", "location", "kind")
"""Dimensions of the extreme, besides that of the cases."""

ROOM = 0.06
"""Free part of the scale beyond the largest value."""

DASHES = (0, (3, 1.5))


def has_population(collected: xr.Dataset, table: SweepTable) -> bool:
    """Tell whether a sweep samples what changes the pressures on fibers along the streamlines.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep.
    table : SweepTable
        Its table.
    """
    if not table.is_sampled or not {"extreme_mean", "near_singularity"} <= {*collected}:
        return False
    if not {*NEEDED} <= {*collected["extreme_mean"].dims}:
        return False
    if not {1, 2} <= {*collected["location"].to_numpy().tolist()}:
        return False
    with_answer = np.isfinite(_lowest(collected, 1)).any(axis=1)
    return bool(np.count_nonzero(with_answer) > 1)


def _lowest(collected: xr.Dataset, location: int) -> Array:
    """Return the lowest pressure at a location, mean over the initial angles [MPa].

    Returns
    -------
    (cases, streamlines) ndarray
        Less the melt's own pressure; NaN where a case has no answer.
    """
    chosen = collected["extreme_mean"].sel(location=location, kind="min")
    return MPA * np.asarray(chosen.transpose("case", "streamline").to_numpy(), dtype=float)


def _regular(collected: xr.Dataset) -> Which:
    """Return which streamlines pass no sharp corner in any case; all if every one does."""
    flagged = collected["near_singularity"].transpose("case", "streamline").to_numpy()
    found = ~(np.nan_to_num(flagged) > 0).any(axis=0)
    return np.asarray(found if found.any() else ~found)


def _bands(values: Array, weights: Array | None = None) -> Array:
    """Return the quantiles on each streamline, (levels, streamlines)."""
    return np.stack([quantiles(line, LEVELS, weights) for line in values.T], axis=1)


def figure_population(collected: xr.Dataset) -> Figure:
    """Draw median and band of the lowest pressure by streamline, at both locations.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep of a sampled design over fibers in a bead.
    """
    table = sweep_table(collected)
    figure = new_figure(FULL, HEIGHT)
    both = [_bands(_lowest(collected, location)) for location in (1, 2)]
    steady = _regular(collected)
    bottom = _bottom(both, steady)
    for k, bands in enumerate(both):
        axes = add_axes(figure, LEFT[k], 10, WIDE, TALL)
        _chart(axes, collected, bands, steady)
        if table.weighing is not None:
            weighed = _bands(_lowest(collected, k + 1), table.weighing.values)[1]
            line = np.where(steady, weighed, np.nan)
            axes.plot(collected["streamline"], line, color=INK, linestyle=DASHES, linewidth=1.0)
        axes.set_ylim(bottom, 0.0)
        letter(axes, f"{'ab'[k]}  lowest at Loc. {k + 1}")
        if k == 0:
            axes.set_ylabel("less the melt's own [MPa]")
            key_above(axes, _key(table), 1.13, columns=4, between=1.3)
        else:
            axes.tick_params(labelleft=False)
    return figure


def _bottom(both: list[Array], steady: Which) -> float:
    """Return the foot of the scale [MPa], which streamlines near a sharp corner do not set."""
    return (1 + ROOM) * min(float(np.nanmin(bands[:, steady])) for bands in both)


def _chart(axes: Axes, collected: xr.Dataset, bands: Array, steady: Which) -> None:
    """Draw one location; diamonds stand for the medians near a sharp corner."""
    place = collected["streamline"].to_numpy()
    low, middle, high = np.where(steady, bands, np.nan)
    axes.fill_between(place, low, high, color=BLUE, alpha=0.25, linewidth=0)
    # The dots are seen where no neighbour is left to draw a line to.
    axes.plot(place, middle, color=BLUE, linewidth=1.4, marker="o", markersize=2.0)
    axes.plot(place[~steady], bands[1][~steady], "D", color=BLUE, mfc="white", markersize=3.5)
    axes.set_xlim(place[0] - 0.7, place[-1] + 0.7)
    axes.locator_params(axis="x", integer=True)
    plain_numbers(axes)
    axes.set_xlabel("streamline, from the upstream edge")
    axes.grid(axis="y", color=BAND, linewidth=0.4)
    axes.set_axisbelow(True)


def _key(table: SweepTable) -> list[Line2D | Patch]:
    """Return what lines, band and marks mean."""
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=BLUE, linewidth=1.4, label="median"),
        Patch(facecolor=BLUE, alpha=0.25, label="5 to 95 % of the cases"),
        key_mark("D", "median near a sharp corner", BLUE, 3.5, face="white"),
    ]
    if table.weighing is not None:
        label = f"median weighed by {table.weighing.title}"
        handles.insert(2, Line2D([], [], color=INK, linestyle=DASHES, linewidth=1, label=label))
    return handles


def population_words(collected: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_population`."""
    table = sweep_table(collected)
    values = [_lowest(collected, location) for location in (1, 2)]
    steady = _regular(collected)
    cases = int(np.count_nonzero(np.isfinite(values[0]).any(axis=1)))
    names = ", ".join(axis.title for axis in table.axes)
    fibers = any(key.startswith("fiber.") for axis in table.axes for key in axis.keys)
    over = "a population of " if fibers else ""
    weighed = (
        f" Dashed: the median with the cases {weighing_told(table.weighing)}."
        if table.weighing is not None
        else ""
    )
    places = collected["streamline"].to_numpy()
    beside = ", ".join(map(str, places[~steady]))
    flagged = f" Left out of lines, bands and scales: streamlines {beside}" if beside else ""
    both = [_bands(one) for one in values]
    bottom = _bottom(both, steady)
    beyond = [
        f"{number(float(bands[1, row]), 3)} MPa at Loc. {location} of {places[row]}"
        for location, bands in enumerate(both, start=1)
        for row in np.flatnonzero(~steady & (bands[1] < bottom))
    ]
    flagged += f" (medians off the scale: {', '.join(beyond)})" if beyond else ""
    return Words(
        caption=(
            "Lowest surface pressure less the melt's own by streamline, the mean over the initial "
            f"angles of a fiber, over {over}{cases} cases that differ in {names}: median "
            "and the band in which nine of ten cases lie, on each streamline for itself, before "
            "the capillary (Loc. 1) and from the exit to the end of the swell (Loc. 2). Every case "
            f"counts once. {QUANTILE_RULE}{weighed}{flagged}{'.' if flagged else ''}"
        ),
        alt="Two charts by streamline. "
        + " ".join(
            _told(collected, steady, value, location)
            for location, value in enumerate(values, start=1)
        ),
    )


def _told(collected: xr.Dataset, steady: Which, values: Array, location: int) -> str:
    """Return where the median over the cases is lowest, and how far it spreads there."""
    bands = np.where(steady, _bands(values), np.nan)
    if not np.isfinite(bands[1]).any():
        return f"Loc. {location}: no numbers."
    at = int(np.nanargmin(bands[1]))
    low, middle, high = (number(float(value), 3) for value in bands[:, at])
    return (
        f"Loc. {location}: the median is lowest on streamline {collected['streamline'].item(at)}, "
        f"{middle} MPa, with 5 to 95 % from {low} to {high} MPa."
    )
