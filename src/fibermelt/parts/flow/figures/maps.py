"""The flow as maps: speed, rate of deformation and pressure, and the velocity gradient (Fig. 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import TriMesh
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure

from fibermelt.parts.flow.figures.judged import vapor_above_air
from fibermelt.report.kit.drawing import draw_bead, draw_field, frame, scale_bar, scene_axes
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, MPA, Scene, Window, by_area, read_scene
from fibermelt.report.kit.style import (
    DIVERGING,
    FULL,
    JUDGED,
    SEQUENTIAL,
    Array,
    Words,
    add_axes,
    color_bar,
    letter,
    new_figure,
    round_up,
    share_within,
)
from fibermelt.report.kit.tables import number, short

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_gradients", "figure_maps"]

SHARE = 0.98
"""Share of the drawn area whose values lie within a colour scale: the rest is near a corner, where
the flow is singular and no scale would hold it."""

BELOW = 0.25
"""The map of the melt's pressure goes at least this far below what it is held against, in parts of
the inlet's: what is below may be little and matters most."""

DECADES = 3.0
"""Orders of magnitude that the map of the rate of deformation spans."""

FOOT, BETWEEN = 13.0, 3.0
"""Height of the colour scales below the maps, and the room between maps [mm]."""

GRADIENTS = (
    (r"a  $\partial v_x / \partial x$", 0, 0),
    (r"b  $\partial v_y / \partial x$", 1, 0),
    (r"c  $\partial v_x / \partial y$", 0, 1),
    (r"d  $\partial v_y / \partial y$", 1, 1),
)
"""The paper's order, with row and column of ``L_ij = d u_i / d x_j``."""


def _map(
    axes: Axes, scene: Scene, window: Window, values: Array, norm: Normalize, cmap: str
) -> TriMesh:
    draw_bead(axes, scene, window, fill=None)
    frame(axes)
    return draw_field(axes, scene, window, values, norm, cmap)


def maps_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    speed = _scalars(results)[0]
    inlet = MPA * float(results["inlet_pressure"])
    return Words(
        caption=(
            "The flow in the whole domain and, larger, near the nozzle's exit: (a) speed, (b) "
            f"scalar rate of deformation on a logarithmic scale, (c) {_held(results)}. "
            "Arrow-shaped ends of a scale: there is more beyond it, at the corners without bound."
        ),
        alt=(
            f"Three maps. The speed is highest in the capillary, {number(speed.max(), 3)} mm/s, "
            "low at the wall and uniform in the bead. The rate of deformation is high along the "
            "capillary's walls and around the lips and vanishes in the bead. The pressure falls "
            f"from {number(inlet, 3)} MPa at the inlet along the capillary to nothing in the bead."
        ),
    )


@plate(
    "maps",
    "Speed, rate of deformation and pressure",
    section="flow",
    words=maps_words,
    needs="extreme node_x",
    place=3.5,
)
def figure_maps(results: xr.Dataset) -> Figure:
    """Draw speed, rate of deformation and pressure over the whole domain and near the exit."""
    scene = read_scene(results)
    speed, rate, pressure = _scalars(results)
    top = MM * round_up(1e-3 * float(speed.max()))
    most = round_up(share_within(*by_area(scene, rate, scene.exit), 1.0 - 0.1 * (1.0 - SHARE)))
    vapor = vapor_above_air(results)
    panels = (
        ("a  speed", "|v| [mm/s]", speed, Normalize(0, top), SEQUENTIAL, "neither"),
        (
            "b  rate of deformation",
            r"$\dot\gamma$ [1/s]",
            rate,
            LogNorm(most * 10**-DECADES, most),
            SEQUENTIAL,
            "both",
        ),
        (
            "c  pressure of the melt",
            "p [MPa], atmosphere = 0" if vapor is None else "p less the vapor pressure [MPa]",
            pressure - (vapor or 0.0),
            _pressure_scale(results),
            SEQUENTIAL if vapor is None else JUDGED,
            "both",
        ),
    )
    wide = (FULL - 4.0 - 2 * BETWEEN) / 3
    lower, upper = (wide * w.size[1] / w.size[0] for w in (scene.exit, scene.whole))
    figure = new_figure(FULL, FOOT + lower + upper + 2 * BETWEEN + 4.0)
    for k, (name, unit, values, norm, cmap, extend) in enumerate(panels):
        left = 2.0 + k * (wide + BETWEEN)
        whole = scene_axes(figure, left, FOOT + lower + BETWEEN, wide, scene.whole)
        _map(whole, scene, scene.whole, values, norm, cmap)
        letter(whole, name)
        near = scene_axes(figure, left, FOOT, wide, scene.exit)
        field = _map(near, scene, scene.exit, values, norm, cmap)
        scale_bar(near, scene.exit, height=0.8, share=0.2)
        bar = add_axes(figure, left + 3, FOOT - 4, wide - 6, 2)
        scale = color_bar(field, bar, unit, extend=extend)
        if isinstance(norm, TwoSlopeNorm):
            scale.set_ticks([*(float(end) for end in scale.mappable.get_clim()), 0.0])
    return figure


def _scalars(results: xr.Dataset) -> tuple[Array, Array, Array]:
    """Return speed [mm/s], rate of deformation [1/s] and pressure [MPa] at the nodes."""
    velocity, L = results["node_velocity"].to_numpy(), results["node_gradient"].to_numpy()
    D = 0.5 * (L + L.swapaxes(-1, -2))
    rate = np.sqrt(2.0 * np.einsum("nij,nij->n", D, D))
    return MM * np.hypot(*velocity.T), rate, MPA * results["node_pressure"].to_numpy()


def _held(results: xr.Dataset) -> str:
    """Return what the map of the pressure shows, in words."""
    if vapor_above_air(results) is None:
        return "pressure of the melt above the atmosphere's"
    return (
        "pressure of the melt less the vapor pressure of its moisture, red where the melt itself "
        "is below it (mind the two halves of the scale)"
    )


def _pressure_scale(results: xr.Dataset) -> Normalize:
    """Return the scale of the pressure [MPa], about the vapor's where the study has moisture."""
    inlet, vapor = MPA * float(results["inlet_pressure"]), vapor_above_air(results)
    least = BELOW * inlet
    if vapor is None:
        return Normalize(-round_up(least), round_up(inlet))
    return TwoSlopeNorm(0.0, -round_up(max(least, vapor)), round_up(max(least, inlet - vapor)))


def gradients_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    normal, shear = _gradient_limits(results, read_scene(results))
    return Words(
        caption=(
            "Fig. 4 of the paper: velocity gradient near the nozzle's exit. Scales are symmetric "
            f"and shared: ±{short(normal)} 1/s for (a) and (d), which sum to zero, "
            f"±{short(shear)} 1/s "
            f"for (b) and (c). At least {100 * SHARE:.0f} % of the area in each panel lies within; "
            "the rest is painted in the scale's last colours: at the lips and at the contact point "
            "the gradient is singular, and what is computed there depends on the mesh."
        ),
        alt=(
            "Four maps of the capillary's end and the gap. In the capillary only the change of the "
            "vertical speed across it (b) counts, with opposite signs at the two walls. In the gap "
            "the melt is stretched along the bed (a) and pressed against it (d). All components "
            "are largest at the two lips and at the contact point and fade in the bead downstream."
        ),
    )


@plate(
    "gradients",
    "Velocity gradient near the exit",
    section="flow",
    words=gradients_words,
    needs="extreme node_x",
    paper="Fig. 4",
)
def figure_gradients(results: xr.Dataset) -> Figure:
    """Draw the four components of the velocity gradient near the nozzle's exit."""
    scene = read_scene(results)
    gradient = results["node_gradient"].to_numpy()
    limits = _gradient_limits(results, scene)
    wide = (FULL - 4.0 - BETWEEN) / 2
    tall = wide * scene.exit.size[1] / scene.exit.size[0]
    row_height = tall + 6.0
    figure = new_figure(FULL, FOOT + 2 * row_height)
    for k, (name, row, column) in enumerate(GRADIENTS):
        left, bottom = 2.0 + (k % 2) * (wide + BETWEEN), FOOT + (1 - k // 2) * row_height
        axes = scene_axes(figure, left, bottom, wide, scene.exit)
        shear = row != column
        values, limit = gradient[:, row, column], limits[shear]
        field = _map(axes, scene, scene.exit, values, Normalize(-limit, limit), DIVERGING)
        letter(axes, name)
        scale_bar(axes, scene.exit, height=0.8, share=0.2)
        if k < 2:
            bar = add_axes(figure, left + 6, FOOT - 4.5, wide - 12, 2)
            color_bar(field, bar, "b and c [1/s]" if shear else "a and d [1/s]", extend="both")
    return figure


def _gradient_limits(results: xr.Dataset, scene: Scene) -> tuple[float, float]:
    """Return the ends of the scales of the diagonal components and of the shears [1/s]."""
    L = results["node_gradient"].to_numpy()
    limits = []
    for pair in (((0, 0), (1, 1)), ((0, 1), (1, 0))):
        ends = [share_within(*by_area(scene, L[:, i, j], scene.exit), SHARE) for i, j in pair]
        limits.append(round_up(max(ends)))
    return limits[0], limits[1]
