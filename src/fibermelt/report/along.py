"""Speed and rate of deformation that the melt meets along the streamlines (the paper's Fig. 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fibermelt.report.lines import ZONES, features, rest
from fibermelt.report.scene import MM
from fibermelt.report.style import (
    BAND,
    FULL,
    GREY,
    Array,
    Words,
    add_axes,
    letter,
    new_figure,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["along_words", "figure_along"]

LEAST_RATE = 0.1
"""Rates of deformation are drawn from here on [1/s]: below, nothing happens to a fiber in time."""

MARKS = ("o", "s", "D")
"""Marks of zones 1 to 3 on a line."""


@styled
def figure_along(results: xr.Dataset) -> Figure:
    """Draw speed and scalar rate of deformation against the time since the inlet."""
    speed = MM * np.hypot(results["u"].to_numpy(), results["v"].to_numpy())
    rate = results["shear_rate"].to_numpy()
    figure = new_figure(FULL, 78)
    left = add_axes(figure, 13, 10, 78, 60)
    right = add_axes(figure, 109, 10, 78, 60)
    _lines(left, results, speed)
    _lines(right, results, rate)
    left.set_ylabel("speed |v| [mm/s]")
    left.set_ylim(0.0, 1.08 * float(speed.max()))
    right.set_ylabel(r"rate of deformation $\dot\gamma = \sqrt{2\,D:D}$ [1/s]")
    right.set_yscale("log")
    right.set_ylim(LEAST_RATE, 2.0 * float(rate.max()))
    letter(left, "a")
    letter(right, "b")
    left.legend(loc="lower right", bbox_to_anchor=(1.0, 0.03))
    return figure


def _lines(axes: Axes, results: xr.Dataset, values: Array) -> None:
    """Draw values along all lines, the marked ones on top with their zones."""
    time = results["time"].to_numpy()
    zones = results["zone_time"].to_numpy()
    for row in rest(results):
        axes.plot(time[row], values[row], color=BAND, linewidth=0.6, zorder=1)
    for feature in features(results):
        row = feature.row
        axes.plot(time[row], values[row], color=feature.color, linewidth=1.3, zorder=2)
        for zone, mark in enumerate(MARKS):
            axes.plot(
                zones[row, zone],
                np.interp(zones[row, zone], time[row], values[row]),
                marker=mark,
                markersize=4,
                markerfacecolor="white",
                markeredgecolor=feature.color,
                linestyle="none",
                zorder=3,
            )
    axes.plot([], [], color=BAND, label="other streamlines")
    for feature in features(results):
        axes.plot([], [], color=feature.color, linewidth=1.3, label=f"streamline {feature.number}")
    for zone, mark in enumerate(MARKS):
        name = f"zone {zone + 1}, {ZONES[zone]}"
        axes.plot([], [], mark, markersize=4, mfc="white", mec=GREY, label=name)
    axes.set_xlim(0.0, 1.02 * float(time[:, -1].max()))
    axes.set_xlabel("time since the inlet [s]")
    axes.grid(axis="y", color=BAND, linewidth=0.4)


def along_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_along`."""
    speed = MM * np.hypot(results["u"].to_numpy(), results["v"].to_numpy())
    rate = results["shear_rate"].to_numpy()
    end = results["time"].to_numpy()[:, -1]
    peak = ", ".join(
        f"{rate[feature.row].max():.0f} 1/s on streamline {feature.number}"
        for feature in features(results)
    )
    return Words(
        caption=(
            "What the melt meets on its way: (a) speed and (b) scalar rate of deformation, on a "
            f"logarithmic scale from {LEAST_RATE:g} 1/s, along all streamlines against the time "
            "since the inlet, to the outlet. Marks: zones 1 to 3 on the marked streamlines."
        ),
        alt=(
            "Two panels of curves over time. Speed rises in the taper, is steady in the capillary, "
            f"peaks at {speed.max():.0f} mm/s and settles at the bed's {speed[:, -1].mean():.0f} "
            f"mm/s. The rate of deformation peaks near the nozzle's exit ({peak}) and dies out in "
            f"the bead. The way takes from {end.min():.2f} s to {end.max():.2f} s."
        ),
    )
