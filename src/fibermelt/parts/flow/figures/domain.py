"""The fluid domain: its boundaries by name, and the mesh down to the singular corners (Fig. 2a)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fibermelt.report.kit.drawing import (
    draw_bead,
    draw_mesh,
    frame,
    main_scene,
    mark_window,
    scale_bar,
    scene_axes,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, Scene, Window, bed_speed, read_scene
from fibermelt.report.kit.style import VERMILION, Words, letter
from fibermelt.report.kit.tables import number, short, sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_domain"]

MESH = "#5f86ad"

CLOSE_UP = 0.1
"""Width of the close-ups over the capillary's."""

BETWEEN, CLOSE_UPS = 3.0, 35.0
"""Room between the close-ups, and their height with their names [mm]."""


def domain_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    scene = read_scene(results)
    elements, unknowns = int(results["elements"]), int(results["unknowns"])
    contact, heel = (
        sized(MM * float(results[name]), scene.width, 4) for name in ("contact_point", "heel")
    )
    return Words(
        caption=(
            "Fig. 2a of the paper: fluid domain, its boundaries and its mesh. Parabolic inlet flow "
            "on Γ₁, no slip on the nozzle's wall Γ₂, free surfaces Γ₃ whose shape is part of the "
            "answer, the speed of the bed on Γ₄ and on the outlet Γ₅. "
            f"{elements} curved triangles, {unknowns} unknowns. The upstream surface meets the "
            f"bed at x = {contact} mm, also part of the answer; the melt's foremost "
            f"point lies at x = {heel} mm. Orange squares: sharp "
            "corners, where the flow is singular, drawn large."
        ),
        alt=(
            "Cross-section of a nozzle that narrows to a capillary over a moving bed. Melt fills "
            f"the nozzle and the gap and leaves to the right as a bead "
            f"{number(scene.bead_height, 3)} mm high; upstream it reaches x = {heel} mm. The "
            "triangles of the mesh are "
            "finest at the two lips and where the upstream surface touches the bed."
        ),
    )


@plate(
    "domain",
    "Fluid domain and mesh",
    section="flow",
    words=domain_words,
    needs="extreme node_x",
    paper="Fig. 2a",
)
def figure_domain(results: xr.Dataset) -> Figure:
    """Draw domain, boundaries and mesh, with close-ups of the gap, the lips and the contact."""
    scene = read_scene(results)
    figure, axes, room = main_scene(scene, extra=CLOSE_UPS)
    _paint(axes, scene, scene.whole, 0.25)
    _boundaries(axes, scene, results)

    gap = scene_axes(figure, room.left, room.top - room.fit(scene.exit), room.width, scene.exit)
    _paint(gap, scene, scene.exit, 0.25)
    frame(gap)
    letter(gap, "gap and bead (dashed frame)")
    mark_window(axes, scene.exit)

    half = 0.5 * CLOSE_UP * scene.width
    places = {
        "upstream lip": scene.lips[0],
        "contact point": scene.contact,
        "downstream lip": scene.lips[1],
    }
    wide = (room.width - 2 * BETWEEN) / 3
    for k, (name, (x, y)) in enumerate(places.items()):
        window = Window(x - half, x + half, y - 0.8 * half, y + 0.8 * half)
        bottom = room.top - room.fit(scene.exit) - 8 - 0.8 * wide
        close = scene_axes(figure, room.left + k * (wide + BETWEEN), bottom, wide, window)
        _paint(close, scene, window, 0.3)
        frame(close, VERMILION)
        letter(close, name)
        gap.plot(x, y, marker="s", markersize=4, color="none", markeredgecolor=VERMILION, zorder=5)
        if k == 0:
            scale_bar(close, window)
    return figure


def _paint(axes: Axes, scene: Scene, window: Window, linewidth: float) -> None:
    draw_bead(axes, scene, window)
    draw_mesh(axes, scene, window, MESH, linewidth)


def _boundaries(axes: Axes, scene: Scene, results: xr.Dataset) -> None:
    """Write the paper's names of the boundaries and what holds there."""
    psi = results["node_stream_function"].to_numpy()
    flux = float(np.ptp(psi))
    inlet = scene.sides["inlet"]
    outlet, bed = scene.sides["outlet"], scene.sides["bed"]
    inlet_speed = flux / float(np.ptp(inlet[:, 0])) * MM * MM
    surface = scene.sides["downstream surface"]
    upstream = scene.sides["upstream surface"]
    wall = scene.sides["left wall"]
    middle = wall[np.argmin(np.abs(wall[:, 1] - 0.8 * scene.capillary_entrance))]
    heel = upstream[np.argmin(upstream[:, 0])]
    far = surface[np.argmin(np.abs(surface[:, 0] - 0.8 * surface[:, 0].max()))]
    mean = short(inlet_speed, 3)
    names = (
        (
            rf"$\Gamma_1$ inlet, mean {mean} mm/s",
            inlet.mean(axis=0),
            (0, 7),
            "center",
        ),
        (r"$\Gamma_2$", middle, (-19, 0), "right"),
        (r"$\Gamma_3$ free surface", far, (0, 7), "center"),
        (r"$\Gamma_3$", heel, (-13, 0), "right"),
        (
            rf"$\Gamma_4$ bed, {short(MM * bed_speed(results), 4)} mm/s",
            bed.mean(axis=0),
            (0, -11),
            "center",
        ),
        (r"$\Gamma_5$ outlet", outlet.mean(axis=0), (6, 0), "left"),
    )
    leader = {"arrowstyle": "-", "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0}
    for text, at, offset, align in names:
        axes.annotate(
            text,
            at,
            xytext=offset,
            textcoords="offset points",
            ha=align,
            va="center",
            arrowprops=leader if text.startswith(r"$\Gamma_2$") else None,
            zorder=6,
        )
