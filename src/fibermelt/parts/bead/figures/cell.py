"""The fiber's cell: its mesh, and the pressure around the fiber at its deepest (Fig. 5, 6, 16d)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.tri import TriContourSet

from fibermelt.engine.results import study_of
from fibermelt.parts.bead.figures.surroundings import (
    LEVELS,
    draw_contours,
    draw_fiber,
    net,
    rotation,
    stored_surroundings,
)
from fibermelt.report.kit.drawing import curves, frame, scene_axes
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import Window
from fibermelt.report.kit.style import (
    DIVERGING,
    FULL,
    INK,
    VERMILION,
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

__all__ = ["figure_cell"]

TIP, TIP_BOUNDS = 4.0, (0.04, 0.6)
"""Half the width of the tip's close-up over its radius of curvature, and over the half-length."""

MESH = "#5f86ad"
SHEAR = np.array([[0.0, 1.0], [0.0, 0.0]])
"""Gradient of simple shear ``u_x = y``."""

ORIENTATIONS = 3601
"""Orientations among which the lowest pressure is sought, every twentieth of a degree."""

STRAIGHT = 1e-5
"""Edges that bend less than this, over the half-length, are drawn straight."""


@dataclass(frozen=True)
class Deepest:
    """The orientation in simple shear ``u_x = gamma_dot y`` with the lowest surface pressure.

    Parameters
    ----------
    angle : float
        Of the fiber from the flow's direction [rad], counter-clockwise.
    pressure : float
        Lowest surface pressure less the melt's, over ``mu gamma_dot`` [-].
    where : float
        Eccentric angle of it on the surface [rad].
    """

    angle: float
    pressure: float
    where: float


def _deepest(results: xr.Dataset) -> Deepest:
    """Find it: ``D_11 = sin(2 theta)/2, D_12 = cos(2 theta)/2`` over ``gamma_dot``."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, ORIENTATIONS)
    strain = 0.5 * np.stack([np.sin(2 * angle), np.cos(2 * angle)])
    pressure = results["surface_basis"].to_numpy() @ strain
    place, turn = np.unravel_index(np.argmin(pressure), pressure.shape)
    return Deepest(
        angle=float(angle[turn]),
        pressure=float(pressure[place, turn]),
        where=float(results["surface_angle"].to_numpy()[place]),
    )


def cell_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    found = _deepest(results)
    size, aspect = float(results["domain_size"]), float(results["aspect_ratio"])
    angle, where = np.degrees(found.angle), np.degrees(found.where)
    if np.isnan(size):
        cell = (
            f"a fiber of aspect ratio {aspect:g} in an unbounded melt, in closed form. (a, c) The "
            "net it is drawn on, in the fiber's axes."
        )
    else:
        cell = (
            f"the cell of a fiber of aspect ratio {aspect:g}: a circle of {0.5 * size:g} "
            f"half-lengths around an ellipse, {int(results['cell_unknowns'])} unknowns. (a, c) "
            f"{_meshed(results)}, in the fiber's axes."
        )
    # A circle has no direction: where its pressure is lowest, rounding says.
    lowest = (
        f"the orientation with the lowest pressure, {found.pressure:.2f} μγ̇ at the eccentric "
        f"angle {where:.1f}° of the surface"
        if aspect > 1
        else f"as at any other; the lowest pressure is {found.pressure:.2f} μγ̇"
    )
    newtonian = (
        " All of a Newtonian melt; the pressures of the bead are of the melt as it thins."
        if "thinning_rate" in results
        else ""
    )
    return Words(
        caption=(
            f"Fig. 5a and 6a of the paper: {cell} (b, d) Pressure less the melt's in simple "
            f"shear with the fiber at {angle:.1f}° to the flow, {lowest}. Orange: lower than the "
            f"melt's own pressure.{newtonian}"
        ),
        alt=(
            f"An ellipse {aspect:g} times as long as wide in a circle, and the net between them, "
            "finest at the ellipse. In simple shear the pressure "
            f"around it is lowest, {found.pressure:.1f} times viscosity times shear rate, at the "
            f"eccentric angle {where:.0f}° and at the opposite point of the surface."
        ),
    )


@plate(
    "cell",
    "The fiber's cell",
    section="shear",
    words=cell_words,
    needs="extreme",
    paper="Fig. 5a and 6a",
)
def figure_cell(results: xr.Dataset) -> Figure:
    """Draw the cell's mesh, the pressure around the fiber, and its tip in both."""
    found = _deepest(results)
    radius = float(np.hypot(*results["cell_point"].to_numpy().T).max())
    whole = _square(np.zeros(2), 1.04 * radius)
    depth = float(results["aspect_ratio"]) ** -2.0
    half = float(np.clip(TIP * depth, *TIP_BOUNDS))
    figure = new_figure(FULL, 71)

    mesh = scene_axes(figure, 2, 4, 61, whole)
    near = _square(np.array([1.0 - 0.25 * half, 0.0]), half)
    tip = scene_axes(figure, 134, 37, 28, near)
    for axes, linewidth in ((mesh, 0.3), (tip, 0.5)):
        _mesh(axes, results, linewidth)
    kind = "net" if np.isnan(float(results["domain_size"])) else "mesh"
    letter(mesh, f"a  {kind} around the fiber")
    letter(tip, f"c  {kind} at the tip")

    field = scene_axes(figure, 67, 4, 61, whole)
    place = np.array([np.cos(found.where), np.sin(found.where) * depth**0.5])
    turned = _square(place @ rotation(found.angle).T, half)
    deep = scene_axes(figure, 134, 4, 28, turned)
    for axes in (field, deep):
        mappable = _pressure(axes, results, found)
    _shear(field, radius, found.angle)
    letter(field, "b  pressure in simple shear")
    letter(deep, "d  where it is lowest")
    for axes, window, inset in ((mesh, near, tip), (field, turned, deep)):
        frame(inset, VERMILION)
        axes.set_axis_off()
        corner = (window.left, window.bottom)
        axes.add_patch(
            Rectangle(
                corner, *window.size, facecolor="none", edgecolor=VERMILION, linewidth=0.8, zorder=6
            )
        )
    bar = color_bar(
        mappable,
        add_axes(figure, 168, 4, 2.2, 61),
        r"$(p - p_\psi)\,/\,(\mu\,\dot\gamma)$",
        upright=True,
    )
    bar.set_ticks([*mappable.levels][::2])
    return figure


def _square(center: Array, half: float) -> Window:
    """Return a square window around a point."""
    x, y = (float(value) for value in center)
    return Window(x - half, x + half, y - half, y + half)


def _mesh(axes: Axes, results: xr.Dataset, linewidth: float) -> None:
    """Draw the curved elements by their edges, in the fiber's axes."""
    edges = curves(results["cell_point"].to_numpy(), results["cell_edge"].to_numpy(), STRAIGHT)
    axes.add_artist(
        PathPatch(edges, facecolor="none", edgecolor=MESH, linewidth=linewidth, zorder=2)
    )
    draw_fiber(axes, results)


def _pressure(axes: Axes, results: xr.Dataset, found: Deepest) -> TriContourSet:
    """Draw the pressure in the flow's axes, the fiber at the orientation found."""
    levels = round_up(-found.pressure) * LEVELS
    values = stored_surroundings(results).around(SHEAR, found.angle, viscosity=1.0).pressure
    field = draw_contours(axes, net(results, found.angle), values, levels, DIVERGING)
    draw_fiber(axes, results, found.angle)
    return field


def _shear(axes: Axes, radius: float, angle: float) -> None:
    """Show the far field: arrows of the shear, and the fiber's angle to it."""
    for side in (-1, 1):
        axes.annotate(
            "",
            (side * 1.02 * radius, side * 0.9 * radius),
            xytext=(side * 0.62 * radius, side * 0.9 * radius),
            arrowprops={"arrowstyle": "-|>", "linewidth": 0.9, "color": INK},
        )
    axes.text(1.03 * radius, 0.98 * radius, r"$u_x = \dot\gamma\,y$", ha="right", va="center")
    degrees = f"{np.degrees(angle):.1f}".replace("-", "−")
    axes.text(-1.03 * radius, 0.98 * radius, rf"$\theta$ = {degrees}°", ha="left", va="center")


def _meshed(results: xr.Dataset) -> str:
    """Return what the cell is meshed with."""
    if study_of(results).get("numerics", {}).get("cell_mesh") == "paper":
        return "The paper's 1800 quadratic triangles, finest at the fiber"
    return "Curved elements, graded to the tip"
