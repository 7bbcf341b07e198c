"""Pressure around fibers of several aspect ratios at the angle where it is lowest (Fig. 11)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from fibermelt.paper.orbits.figures.turns import KPA, cell_name
from fibermelt.parts.bead.figures.surroundings import FIBER
from fibermelt.report.kit.drawing import frame, scene_axes
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import Window
from fibermelt.report.kit.style import (
    COLUMN,
    DIVERGING,
    INK,
    Array,
    Words,
    add_axes,
    color_bar,
    letter,
    new_figure,
    round_up,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_around"]

LEVELS = np.array([0.0, 0.03, 0.06, 0.1, 0.2, 0.3, 0.45, 0.65, 1.0])
"""Isobars over the pressure scale's end: closer where it is low, as it is in most of the melt."""

SIDE, STEP = 41.0, 46.5
"""Side of a panel, and from one row of panels to the next [mm]."""

FOOT = 13.0
"""Room of the colour bar [mm]."""


def around_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    lows = KPA * results["near_pressure"].min(dim=("ring", "ray")).to_numpy()
    ratios = results["ratio"].to_numpy()
    told = ", ".join(f"{low:.2f} kPa at {ratio:g}" for low, ratio in zip(lows, ratios, strict=True))
    return Words(
        caption=(
            "Pressure around fibers of several aspect ratios in simple shear (to the right above "
            "the fiber), less the far field's, each at the angle from the flow at which the "
            f"pressure on it is lowest. In {cell_name(results)}; one scale for all. Circles: where "
            "on the surface it is lowest. A circular fiber sees the same at every angle."
        ),
        alt=(
            f"{len(ratios)} panels, each with an ellipse and the pressure around it. Low pressure "
            "sits at the two ends that point along the stretching direction, high pressure on the "
            f"flanks. The lowest by aspect ratio: {told}."
        ),
    )


@plate(
    "orbit-around",
    "Pressure around the fiber",
    section="shear",
    words=around_words,
    needs="orbit_period",
    paper="Fig. 11",
)
def figure_around(results: xr.Dataset) -> Figure:
    """Draw the pressure near each fiber, in the axes of the flow, all on one scale."""
    count = results.sizes["ratio"]
    rows = math.ceil(count / 2)
    figure = new_figure(COLUMN, FOOT + STEP * rows + 1)
    end = round_up(-KPA * float(results["near_pressure"].min()))
    levels = end * np.r_[-LEVELS[:0:-1], LEVELS]
    # the net's outermost ring is a circle, the window the square in it
    outer = results["near_point"].isel(ring=-1).to_numpy()
    half = float(np.hypot(outer[..., 0], outer[..., 1]).min()) / math.sqrt(2.0)
    for k in range(count):
        left = 2.5 + (SIDE + 3.0) * (k % 2)
        bottom = FOOT + STEP * (rows - 1 - k // 2)
        axes = scene_axes(figure, left, bottom, SIDE, Window(-half, half, -half, half))
        field = _panel(axes, results, k, levels)
        frame(axes)
        ratio, angle = float(results["ratio"][k]), math.degrees(float(results["near_angle"][k]))
        low = KPA * float(results["near_pressure"][k].min())
        turned = f"θ = {angle:.0f}°" if ratio > 1.0 else "any θ"
        letter(axes, f"$r_e$ = {ratio:g},  {turned},  {low:.2f} kPa".replace("-", "−"))
    if count % 2:
        _shear(scene_axes(figure, 5.5 + SIDE, FOOT, SIDE, Window(-half, half, -half, half)))
    bar = color_bar(field, add_axes(figure, 6, 8.5, COLUMN - 12, 2.2), r"$p - p_\infty$ [kPa]")
    bar.set_ticks([*levels][::2])
    bar.ax.set_xticklabels([f"{value:.3g}".replace("-", "−") for value in levels[::2]])
    return figure


def _lab(results: xr.Dataset, k: int) -> Array:
    """Return a net in the axes of the flow, closed around."""
    angle = float(results["near_angle"][k])
    cos, sin = math.cos(angle), math.sin(angle)
    points = results["near_point"][k].to_numpy() @ np.array([[cos, sin], [-sin, cos]])
    closed: Array = np.concatenate([points, points[:, :1]], axis=1)
    return closed


def _panel(axes: Axes, results: xr.Dataset, k: int, levels: Array) -> QuadContourSet:
    """Draw one fiber, the pressure around it, and where on it that is lowest."""
    net = _lab(results, k)
    pressure = KPA * results["near_pressure"][k].to_numpy()
    field = axes.contourf(
        net[..., 0],
        net[..., 1],
        np.concatenate([pressure, pressure[:, :1]], axis=1),
        levels=levels,
        norm=BoundaryNorm(levels, 256, extend="both"),
        cmap=DIVERGING,
        extend="both",
        zorder=1,
    )
    axes.add_patch(Polygon(net[0], facecolor=FIBER, edgecolor=INK, linewidth=0.6, zorder=4))
    lowest = net[0, int(np.argmin(pressure[0]))]
    for side in (1.0, -1.0):
        axes.plot(
            *(side * lowest), "o", mfc="none", mec=INK, markersize=5, markeredgewidth=0.8, zorder=5
        )
    return field


def _shear(axes: Axes) -> None:
    """Show the far field and the mark in the place that an odd number of panels leaves."""
    axes.set_axis_off()
    for y in (-0.9, -0.45, 0.45, 0.9):
        axes.annotate(
            "",
            (y, y),
            xytext=(0.0, y),
            arrowprops={"arrowstyle": "-|>", "linewidth": 0.9, "color": INK},
        )
    axes.plot([0.0, 0.0], [-1.0, 1.0], color=INK, linewidth=0.6)
    axes.text(0.0, 1.25, r"$u_x = \dot\gamma\,y$", ha="center", va="center")
    axes.text(0.0, -1.3, "circles: lowest pressure", ha="center", va="center")
