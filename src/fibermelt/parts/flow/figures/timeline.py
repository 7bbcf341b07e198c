"""Pressure on fibers over time along a streamline: what the charts of Fig. 16 and 17 share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes

from fibermelt.report.kit.drawing import zone_badge
from fibermelt.report.kit.scene import MPA, Index
from fibermelt.report.kit.style import GREY, HIGH, INK, LOW, Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SIDES", "Side", "draw_bound", "draw_own", "mark_zones", "on_fibers", "own", "span"]

Side = Literal["lowest", "highest"]

SIDES: dict[Side, tuple[str, str]] = {"lowest": ("min", LOW), "highest": ("max", HIGH)}
"""The kind of extreme and the colour of the lowest and the highest surface pressure."""

QUIET = 0.02
"""The time scale begins where the bounds first reach this part of their largest value."""

SPARSE = 400
"""Points of a band's edge at most: about four to a millimetre of a page."""


def own(results: xr.Dataset, row: int) -> Array:
    """Return the melt's own pressure along a streamline [MPa]."""
    values: Array = MPA * results["pressure"].to_numpy()[row]
    return values


def on_fibers(results: xr.Dataset, side: str, row: int) -> Array:
    """Return the lowest or highest pressure on fibers, the melt's own included [MPa].

    Parameters
    ----------
    results : xarray.Dataset
        The results.
    side : str
        ``lowest``, ``highest``: (initial angle, point); ``bound_lowest``, ``bound_highest``:
        (point,).
    row : int
        The streamline's place.
    """
    values: Array = own(results, row) + MPA * results[side].to_numpy()[row]
    return values


def span(results: xr.Dataset, row: int) -> tuple[float, float]:
    """Return first and last time to show: from where something happens to where nothing does.

    Zones 1 and 3 lie within.
    """
    time = results["time"].to_numpy()[row]
    range_ = on_fibers(results, "bound_highest", row) - on_fibers(results, "bound_lowest", row)
    zones = results["zone_time"].to_numpy()[row]
    loud = time[np.flatnonzero(range_ > QUIET * float(range_.max()))]
    first, last = float(min(loud[0], zones[0])), float(max(loud[-1], zones[-1]))
    margin = 0.03 * (last - first)
    return max(0.0, first - margin), min(float(time[-1]), last + margin)


def _band_points(time: Array, edge: Array, shown: tuple[float, float]) -> Index:
    """Return points for a band: the stored ones shown, of many those evenly along its edge.

    The edge's lowest and highest point are among them.
    """
    first, last = np.searchsorted(time, shown)
    here = np.arange(max(0, first - 1), min(len(time), last + 1))
    if len(here) > SPARSE:
        x, y = (values[here] / np.ptp(values[here]) for values in (time, edge))
        way = np.r_[0.0, np.cumsum(np.hypot(np.diff(x), np.diff(y)))]
        even = np.searchsorted(way, np.linspace(0.0, way[-1], SPARSE))
        ends = [int(np.argmin(y)), int(np.argmax(y))]
        here = here[np.unique(np.r_[np.minimum(even, len(here) - 1), ends])]
    return here


def draw_bound(axes: Axes, results: xr.Dataset, row: int, side: Side) -> None:
    """Draw the band between the melt's own pressure and the bound over every orientation."""
    time, melt = results["time"].to_numpy()[row], own(results, row)
    bound, color = on_fibers(results, f"bound_{side}", row), SIDES[side][1]
    at = _band_points(time, bound, span(results, row))
    axes.fill_between(time[at], melt[at], bound[at], color=color, alpha=0.12, linewidth=0, zorder=1)
    axes.plot(time, bound, color=color, linewidth=0.5, linestyle=(0, (4, 2)), zorder=1.2)


def draw_own(axes: Axes, results: xr.Dataset, row: int) -> None:
    """Draw the melt's own pressure, and a line at the atmosphere's."""
    axes.plot(results["time"].to_numpy()[row], own(results, row), color=INK, lw=1.3, zorder=3)
    axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.5)


def mark_zones(axes: Axes, results: xr.Dataset, row: int, *, numbers: bool = True) -> None:
    """Draw an upright dashed line at each zone, with its number on top where wanted."""
    for zone, when in enumerate(results["zone_time"].to_numpy()[row]):
        axes.axvline(when, color=GREY, linewidth=0.6, linestyle=(0, (2.5, 1.5)), zorder=0.9)
        if numbers:
            zone_badge(axes, zone + 1, (when, 1.0), (0, 6), ("data", "axes fraction"))
