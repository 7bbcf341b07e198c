"""A chart by streamline: what fibers of all initial angles meet, with mean, median and bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from fibermelt.parts.flow.figures.lines import initial_angles, named, regular
from fibermelt.parts.flow.given import is_given
from fibermelt.report.kit.drawing import on_paper, spread_out
from fibermelt.report.kit.scene import MPA
from fibermelt.report.kit.style import BAND, INK, Array, key_mark
from fibermelt.report.kit.tables import short

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "by_streamline",
    "draw_fibers",
    "draw_mean",
    "draw_spread",
    "extreme_of",
    "spread_key",
    "spread_limits",
]

MEAN, MEDIAN, FIBERS, ISOTROPIC = "#24459c", INK, "#404040", "#9aa8b5"
"""The paper's blue line is the mean; its red one, the median, is black, as red is a verdict."""

DASHES = (0, (3, 1.5))

DIGITS = 6.0
"""Width of a bold digit, with its share of what stays free between two numbers [points]."""

ROOM = 0.06
"""Free part of the scale beyond the largest value."""


def extreme_of(results: xr.Dataset, name: str, location: int, kind: str, last: str) -> Array:
    """Return a variable of the extremes at one location, (streamline, ``last``).

    Parameters
    ----------
    results : xarray.Dataset
        The results.
    name : str
        The variable.
    location : int
        Its number: 0 the whole way, 1 the paper's Loc. 1, 2 its Loc. 2.
    kind : str
        ``min`` or ``max``.
    last : str
        Its remaining dimension: ``initial_angle``, ``side`` or ``quantile``.
    """
    chosen = results[name].sel(location=location, kind=kind)
    values: Array = chosen.transpose("streamline", last).to_numpy()
    return values


def by_streamline(axes: Axes, results: xr.Dataset) -> None:
    """Make the lower scale one of streamlines: the first, the last and the marked ones named."""
    number = results["streamline"].to_numpy()
    axes.set_xlim(number[0] - 0.7, number[-1] + 0.7)
    axes.grid(axis="y", color=BAND, linewidth=0.4)
    axes.set_axisbelow(True)
    axes.set_xlabel("path" if is_given(results) else "streamline, from the upstream edge")
    shown = named(results)
    axes.set_xticks(number[[*shown]], [str(number[row]) for row in shown])
    labels = axes.get_xticklabels()
    wide = DIGITS * max(len(label.get_text()) for label in labels)
    places = number[[*shown]].astype(np.float64)
    aside = (spread_out(places, on_paper(axes, wide)) - places) / on_paper(axes, 72.0)
    for label, shift in zip(labels, aside, strict=True):
        if shift:
            across = ScaledTranslation(shift, 0.0, axes.figure.dpi_scale_trans)
            label.set_transform(label.get_transform() + across)
    for color, tick in zip(shown.values(), labels, strict=True):
        if color is not None:
            tick.set_color(color)
            tick.set_fontweight("bold")


def spread_limits(results: xr.Dataset, kind: str) -> tuple[float, float]:
    """Return a scale from zero to beyond the bounds at all locations [MPa].

    Streamlines near a sharp corner do not set it: their values have no limit as the mesh is
    refined.
    """
    bounds = MPA * results["extreme_bounds"].sel(kind=kind).transpose("streamline", ...).to_numpy()
    most = (1.0 + ROOM) * float(np.abs(bounds[regular(results)]).max())
    return (-most, 0.0) if kind == "min" else (0.0, most)


def draw_fibers(axes: Axes, results: xr.Dataset, values: Array) -> None:
    """Draw a point for every fiber; values are (streamline, initial_angle)."""
    number = results["streamline"].to_numpy()
    axes.plot(
        np.repeat(number, values.shape[1]),
        values.ravel(),
        "o",
        color=FIBERS,
        alpha=0.45,
        markersize=1.8,
        markeredgewidth=0,
        zorder=2,
    )


def draw_mean(axes: Axes, results: xr.Dataset, mean: Array, median: Array | None = None) -> None:
    """Draw mean and median; on streamlines near a sharp corner diamonds in place of lines.

    What lies beyond the scale is shown by an arrow at its end, with the number.
    """
    number, steady = results["streamline"].to_numpy(), regular(results)
    axes.plot(number, np.where(steady, mean, np.nan), color=MEAN, linewidth=1.3, zorder=3)
    if median is not None:
        line = np.where(steady, median, np.nan)
        axes.plot(number, line, color=MEDIAN, linewidth=1.1, linestyle=DASHES, zorder=3.1)
    near = results["near_singularity"].to_numpy() > 0
    axes.plot(number[near], mean[near], "D", color=MEAN, mfc="white", markersize=3.5, zorder=4)
    low, high = axes.get_ylim()
    middle = 0.5 * (number[0] + number[-1])
    for end, beyond in ((low, mean < low), (high, mean > high)):
        for left in (True, False):
            rows = np.flatnonzero(beyond & ((number <= middle) == left))
            if len(rows):
                _off_scale(axes, number[rows], mean[rows], end, left=left)


def _off_scale(axes: Axes, number: Array, mean: Array, end: float, *, left: bool) -> None:
    """Show by an arrow at the end of the scale that means lie beyond, and write the farthest."""
    up = end == max(axes.get_ylim())
    axes.plot(
        number,
        np.full(len(number), end),
        "^" if up else "v",
        color=MEAN,
        mfc="white",
        markersize=5,
        clip_on=False,
        zorder=5,
    )
    farthest = short(float(mean[np.argmax(np.abs(mean))]), 3)
    at = number[-1] if left else number[0]
    axes.annotate(
        farthest if len(number) == 1 else f"to {farthest}",
        (at, end),
        xytext=(5 if left else -5, -1 if up else 1),
        textcoords="offset points",
        ha="left" if left else "right",
        va="top" if up else "bottom",
        fontsize=6.5,
        zorder=5,
    )


def draw_spread(axes: Axes, results: xr.Dataset, location: int, kind: str) -> None:
    """Draw the extremes of one location: fibers, mean, median, bounds and isotropic quantiles."""
    number = results["streamline"].to_numpy()
    value = MPA * extreme_of(results, "extreme", location, kind, "initial_angle")
    bound = MPA * extreme_of(results, "extreme_bounds", location, kind, "side")
    spread = MPA * extreme_of(results, "extreme_quantiles", location, kind, "quantile")
    axes.set_ylim(*spread_limits(results, kind))
    axes.fill_between(number, *bound.T, color=BAND, alpha=0.6, linewidth=0, zorder=1)
    edges = (spread[:, 0], spread[:, -1])
    axes.fill_between(number, *edges, color=ISOTROPIC, alpha=0.55, linewidth=0, zorder=1.2)
    draw_fibers(axes, results, value)
    draw_mean(axes, results, value.mean(axis=1), np.median(value, axis=1))
    by_streamline(axes, results)


def spread_key(results: xr.Dataset) -> list[Line2D | Patch]:
    """Return what the charts' lines, points and bands mean."""
    level = results["quantile"].to_numpy()
    share = f"{100 * level[0]:.0f} to {100 * level[-1]:.0f} %"
    return [
        Line2D([], [], color=MEAN, linewidth=1.3, label="mean"),
        Line2D([], [], color=MEDIAN, linewidth=1.1, linestyle=DASHES, label="median"),
        key_mark("o", initial_angles(results), FIBERS, 2.5),
        Patch(facecolor=ISOTROPIC, alpha=0.55, label=f"random entry, {share}"),
        Patch(facecolor=BAND, alpha=0.6, label="bounds, every direction"),
        key_mark("D", "near a sharp corner", MEAN, 3.5, face="white"),
    ]
