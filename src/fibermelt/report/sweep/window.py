"""The process window: critical moisture against print speed, a line for each gap."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fibermelt.report.kit.scene import MM
from fibermelt.report.kit.style import (
    FULL,
    Array,
    Words,
    add_axes,
    letter,
    new_figure,
    plain_numbers,
)
from fibermelt.sweeps.window import GAP, SPEED, critical_moistures, drying_advice
from fibermelt.units import PERCENT

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_window", "window_words"]

INLET, VISCOSITY = "flow.inlet_speed", "melt.viscosity"
"""What may vary together with the speed of the print, by their keys."""

SAME = 1e-9
"""Relative difference to which ratios of two speeds are the same: units bring roundings."""

MARKERS = "osD^vP*X"

HEIGHT, LEFT, WIDE = 68.0, (14.0, 109.0), 78.0
"""Of the figure, and where its two charts stand [mm]."""


def figure_window(collected: xr.Dataset) -> Figure:
    """Draw critical moisture against print speed for each gap: of the worst fiber, of the median.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep, as `fibermelt.sweeps.window.critical_moistures` takes it.
    """
    figure = new_figure(FULL, HEIGHT)
    names = ("a  worst place, worst direction of a fiber", "b  median fiber, mean by flux")
    moistures = critical_moistures(collected)
    for k, (name, moisture) in enumerate(zip(names, moistures, strict=True)):
        axes = add_axes(figure, LEFT[k], 10, WIDE, HEIGHT - 17)
        _lines(axes, collected, PERCENT * moisture)
        letter(axes, name)
        axes.set_xlabel("print speed [mm/s]")
        if k == 0:
            axes.set_ylabel("critical moisture [%]")
        else:
            axes.legend(title="gap [mm]", loc="best")
    return figure


def _lines(axes: Axes, collected: xr.Dataset, moisture: Array) -> None:
    """Draw one line for each gap, nothing where a case failed."""
    speed, gap = (MM * collected[name].to_numpy() for name in (SPEED, GAP))
    colors = mpl.colormaps["cividis"](np.linspace(0.0, 0.85, len(gap)))
    order = np.argsort(speed)
    for k in np.argsort(gap):
        axes.plot(
            speed[order],
            moisture[order, k],
            color=colors[k],
            marker=MARKERS[k % len(MARKERS)],
            markersize=3.5,
            label=f"{gap[k]:.3g}",
        )
    axes.set_ylim(bottom=0.0)
    axes.margins(y=0.08)
    axes.set_xlim(left=0.0)
    plain_numbers(axes)


def window_words(collected: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_window`; the advice is part of both."""
    advice = drying_advice(collected)
    worst, median = (PERCENT * one for one in critical_moistures(collected))
    return Words(
        caption=(
            "Critical moisture, below which no bubble can grow on a fiber, against the speed of "
            f"the print, {_flux(collected)}, for each gap between nozzle and bed. (a) At "
            "the worst place of the bead for the worst direction of a fiber; 0: the melt is under "
            "tension there, and no drying helps. (b) Of the median fiber of an isotropic start, "
            "mean by flux. Without the streamlines that pass close by a singular corner"
            f"{_viscosity(collected)}. {advice}"
        ),
        alt=(
            "Two charts of critical moisture against print speed, a line for each gap. The worst "
            f"fiber's lies between {_range(worst)}, the median fiber's between {_range(median)}. "
            + advice
        ),
    )


def _flux(collected: xr.Dataset) -> str:
    """Return how the flux follows the speed of the print."""
    if INLET not in collected.coords:
        return "at one flux"
    share = (collected[INLET] / collected[SPEED]).to_numpy()
    even = np.ptp(share) <= SAME * np.max(share)
    return "with the flux in proportion" if even else "with a flux of its own for each"


def _viscosity(collected: xr.Dataset) -> str:
    """Return that the viscosity does not follow the speed, unless it does."""
    if VISCOSITY in collected.coords:
        return ""
    return "; the viscosity is that of one rate of deformation at all speeds"


def _range(values: Array) -> str:
    """Return the range of values [%] in words."""
    there = values[~np.isnan(values)]
    return f"{there.min():.2g} and {there.max():.2g} %" if there.size else "no numbers"
