"""Speed and rate of deformation that the melt meets along the streamlines (the paper's Fig. 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fibermelt.parts.flow.figures.lines import ZONES, features, rest
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM
from fibermelt.report.kit.style import (
    BAND,
    FULL,
    INK,
    OTHERS,
    Array,
    Words,
    add_axes,
    key_above,
    key_mark,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import number, ranged

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_along"]

MARKS = ("o", "s", "D")
"""Marks of zones 1 to 3 on a line."""


def along_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    speed = MM * np.hypot(results["u"].to_numpy(), results["v"].to_numpy())
    rate = results["shear_rate"].to_numpy()
    end = results["time"].to_numpy()[:, -1]
    peak = ", ".join(
        f"{number(rate[feature.row].max(), 3)} 1/s on streamline {feature.number}"
        for feature in features(results)
    )
    return Words(
        caption=(
            "Fig. 3 of the paper: (a) speed and (b) scalar rate of deformation that the melt meets "
            "along all streamlines, against the time since the inlet. Marks: zones 1 to 3 on the "
            f"marked streamlines. The slowest line goes on to {number(end.max(), 3)} s, off the "
            "scale."
        ),
        alt=(
            "Two panels of curves over time. Speed rises in the taper, is steady in the capillary, "
            f"peaks at {number(speed.max(), 3)} mm/s and settles at the bed's "
            f"{number(speed[:, -1].mean(), 3)} mm/s. The rate of deformation peaks near the "
            f"nozzle's exit ({peak}) and dies out in the bead. The way takes from "
            f"{ranged(end.min(), end.max())} s."
        ),
    )


@plate(
    "along",
    "Speed and deformation along streamlines",
    section="flow",
    words=along_words,
    needs="extreme node_x",
    paper="Fig. 3",
)
def figure_along(results: xr.Dataset) -> Figure:
    """Draw speed and scalar rate of deformation against the time since the inlet."""
    speed = MM * np.hypot(results["u"].to_numpy(), results["v"].to_numpy())
    rate = results["shear_rate"].to_numpy()
    figure = new_figure(FULL, 112)
    upper = add_axes(figure, 13, 57, 174, 44)
    lower = add_axes(figure, 13, 9, 174, 44)
    _lines(upper, results, speed)
    _lines(lower, results, rate)
    upper.set_ylabel("speed |v| [mm/s]")
    upper.set_xticklabels([])
    lower.set_ylabel(r"$\dot\gamma = \sqrt{2\,D:D}$ [1/s]")
    lower.set_xlabel("time since the inlet [s]")
    letter(upper, "a  speed", inside=True)
    letter(lower, "b  rate of deformation", inside=True)
    key_above(upper, _key(results), 1.02, columns=4, between=2.0)
    return figure


def _lines(axes: Axes, results: xr.Dataset, values: Array) -> None:
    """Draw values along all lines, the marked ones on top with their zones."""
    time = results["time"].to_numpy()
    zones = results["zone_time"].to_numpy()
    for row in rest(results):
        axes.plot(time[row], values[row], color=OTHERS, linewidth=0.5, zorder=1)
    for feature in features(results):
        row = feature.row
        axes.plot(time[row], values[row], color=feature.color, linewidth=1.4, zorder=2)
        at = np.interp(zones[row], time[row], values[row])
        for when, value, mark in zip(zones[row], at, MARKS, strict=True):
            axes.plot(when, value, mark, mfc="white", mec=feature.color, markersize=4.5, zorder=3)
    shown = time <= _end(results)
    axes.set_xlim(0.0, _end(results))
    axes.set_ylim(0.0, 1.1 * float(values[shown].max()))
    axes.grid(axis="y", color=BAND, linewidth=0.4)


def _end(results: xr.Dataset) -> float:
    """Return where the time scale ends [s]: when the last of the marked lines has left."""
    return 1.03 * max(float(results["time"][f.row, -1]) for f in features(results))


def _key(results: xr.Dataset) -> list[Line2D]:
    """Return what colours and marks mean."""
    lines = [
        Line2D([], [], color=feature.color, linewidth=1.4, label=f"streamline {feature.number}")
        for feature in features(results)
    ]
    zones = [
        key_mark(mark, f"zone {zone + 1}, {ZONES[zone]}", INK, 4.5, face="white")
        for zone, mark in enumerate(MARKS)
    ]
    others = Line2D([], [], color=OTHERS, linewidth=0.6, label="other streamlines")
    empty = Line2D([], [], linestyle="none", label=" ")
    filled = [*lines, *[empty] * (len(zones) - len(lines))]
    columns = [handle for pair in zip(filled, zones, strict=False) for handle in pair]
    return [*columns, others, empty, *lines[len(zones) :]]
