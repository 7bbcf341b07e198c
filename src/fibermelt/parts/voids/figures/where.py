"""Where in the bead voids can start: the risk map, and the profile from bed to free surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fibermelt.parts.flow.figures.carpet import weave
from fibermelt.parts.flow.figures.judged import held_against, key_of_unjudged
from fibermelt.parts.flow.figures.lines import regular
from fibermelt.report.kit.drawing import draw_bead, main_scene, mark_exit, scene_axes
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, read_scene
from fibermelt.report.kit.style import (
    BAND,
    BLUE,
    GREEN,
    GREY,
    INK,
    LOW,
    ORANGE,
    PINK,
    UNJUDGED,
    Array,
    Words,
    add_axes,
    letter,
)
from fibermelt.report.kit.tables import number, sized
from fibermelt.units import MPA, PERCENT
from fibermelt.voids.constants import ATMOSPHERE

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_voids"]

CHARTS, SCALE = 68.0, 23.0
"""Room for the profile below the scene, and for the colour scale over the exit [mm]."""

MEDIAN = "isotropic 50 %"

PAINTED = ("bounds", MEDIAN)
"""Bases of the two maps."""

CURVES = (
    ("melt", "melt itself", BLUE),
    (MEDIAN, "median of randomly entering fibers", ORANGE),
    ("bounds", "any direction", LOW),
    ("spheroid", "spheroid in space, any direction", PINK),
    ("oriented tips", "tips of spheroids as they lie, mean", GREEN),
)
"""Bases that the profile shows if there are any, what they are called, and their colours."""


def voids_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    vapor = MPA * float(results["void_vapor_pressure"])
    moisture = PERCENT * float(results["void_moisture"])
    name = str(results["void_material_name"].item())
    celsius = float(results["void_temperature"]) - 273.15
    worst = _of_selected(results, "void_layer_mean_pressure", "regular", "bounds")
    height = MM * results["void_layer"].to_numpy()
    if np.all(np.isnan(worst)):
        told = "Every streamline passes a sharp corner: no profile is told."
    else:
        deepest = int(np.nanargmin(worst))
        told = (
            "In the worst direction the lowest pressure by layer is "
            f"{number(MPA * worst[deepest], 3)} MPa, {sized(height[deepest], height[-1])} mm above "
            "the bed."
        )
    count = int(np.count_nonzero(results["near_singularity"].to_numpy()))
    without = f"thick without the {count} streamlines that pass close by a sharp corner, thin "
    thick, out = (f"; {without}with them", ", without those streamlines") if count else ("", "")
    return Words(
        caption=(
            f"Where voids can start at {moisture:.3g} % moisture in {name} at {celsius:.0f} °C, "
            f"whose vapor pressure is {number(vapor, 3)} MPa. (a, b) Lowest pressure on a fiber "
            "less vapor pressure, in the colours of the first picture: red where a bubble can "
            "grow, a line where the two are equal; hatched, what is left out. "
            "(c) Lowest pressure that each streamline meets, mean by flux over layers of "
            f"the finished bead{thick}. (d) Growth exponent: the logarithm of how much wider a "
            f"nucleus becomes while moisture lasts, by layer{out}. Pressures are absolute."
        ),
        alt=(
            "Two maps of the bead and two profiles over its height. The pressure on fibers is "
            f"lowest where the melt turns below the nozzle. {told}"
        ),
    )


@plate(
    "voids",
    "Where voids can start",
    section="risk",
    words=voids_words,
    needs="void_margin extreme node_x",
    place=1,
)
def figure_voids(results: xr.Dataset) -> Figure:
    """Draw local less vapor pressure over the bead, and the profile over the bead's height."""
    scene = read_scene(results)
    figure, axes, room = main_scene(scene, extra=SCALE, below=CHARTS)
    gap = scene_axes(figure, room.left, room.bottom, room.width, scene.exit)
    carpet = weave(results)
    left_out = results["near_singularity"].to_numpy() > 0
    vapor = float(results["void_vapor_pressure"]) - ATMOSPHERE
    local = [MPA * (vapor + _of(results, "void_margin_along", basis)) for basis in PAINTED]
    against = held_against(results, local[0][regular(results)], "lowest pressure on a fiber")
    for panel, window, own in zip((axes, gap), (scene.whole, scene.exit), local, strict=True):
        draw_bead(panel, scene, window, fill=UNJUDGED)
        if carpet is not None:
            against.paint(panel, carpet, own, left_out)
    mark_exit(axes, gap, scene)
    letter(axes, "a  worst direction of a fiber", inside=True)
    letter(gap, "b  half of randomly entering fibers see less (dashed frame)")
    bar = add_axes(figure, room.left, room.bottom + room.fit(scene.exit) + 17, room.width, 2.5)
    against.bar(bar)
    key_of_unjudged(bar, results)
    _profile(add_axes(figure, 14, 10, 96, CHARTS - 27), results)
    _exponents(add_axes(figure, 128, 10, 59, CHARTS - 27), results)
    return figure


def _of(results: xr.Dataset, name: str, basis: str) -> Array:
    """Return a variable of one basis."""
    values: Array = results[name].sel(void_basis=basis).to_numpy()
    return values


def _selected(results: xr.Dataset, name: str, selection: str) -> xr.DataArray:
    """Return a variable of the profile with or without the singular streamlines."""
    return results[name].sel(void_selection=selection)


def _edges(results: xr.Dataset) -> Array:
    """Return the heights between the layers [mm], bed and free surface included."""
    middle = MM * results["void_layer"].to_numpy()
    return np.linspace(0.0, middle[-1] + middle[0], len(middle) + 1)


def _profile(axes: Axes, results: xr.Dataset) -> None:
    """Draw the lowest pressure by layer; thin where singular streamlines are counted too."""
    edges = _edges(results)
    known = {str(label) for label in results["void_basis"].to_numpy()}
    for basis, name, color in (curve for curve in CURVES if curve[0] in known):
        for selection, width in (("regular", 1.5), ("all", 0.6)):
            layers = MPA * _of_selected(results, "void_layer_mean_pressure", selection, basis)
            label = name if selection == "regular" else None
            _steps(axes, layers, edges, color, width, label)
    fibers = MPA * _selected(results, "void_layer_fiber_pressure", "regular").to_numpy()
    _steps(axes, fibers, edges, INK, 1.5, "mean over the initial angles")
    vapor = MPA * float(results["void_vapor_pressure"])
    axes.axvline(0.0, color=GREY, linewidth=0.6, zorder=0.5)
    axes.axvline(vapor, color=INK, linewidth=0.9, linestyle=(0, (4, 2)), zorder=0.6)
    axes.annotate(
        "vapor pressure",
        (vapor, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-3, -3),
        textcoords="offset points",
        rotation=90,
        ha="right",
        va="top",
    )
    axes.set_ylim(edges[0], edges[-1])
    axes.set_xlabel("lowest local pressure [MPa, absolute], mean by flux")
    axes.set_ylabel("height in the finished bead [mm]")
    letter(axes, "c")
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.03, 1.0),
        ncols=2,
        columnspacing=1.2,
        handletextpad=0.5,
    )


def _of_selected(results: xr.Dataset, name: str, selection: str, basis: str) -> Array:
    values: Array = _selected(results, name, selection).sel(void_basis=basis).to_numpy()
    return values


def _steps(
    axes: Axes, layers: Array, edges: Array, color: str, width: float, label: str | None
) -> None:
    """Draw one value for each layer as a staircase; nothing in layers that have none."""
    axes.plot(np.repeat(layers, 2), np.repeat(edges, 2)[1:-1], color=color, lw=width, label=label)


def _exponents(axes: Axes, results: xr.Dataset) -> None:
    """Draw the growth exponents by layer, means by flux: the melt's own, and on fibers."""
    edges = _edges(results)
    for basis, name, color in (CURVES[0], CURVES[2]):
        layers = _of_selected(results, "void_layer_exponent", "regular", basis)
        _steps(axes, layers, edges, color, 1.5, name)
    fibers = _selected(results, "void_layer_fiber_exponent", "regular").to_numpy()
    _steps(axes, fibers, edges, INK, 1.5, "fibers")
    axes.set_ylim(edges[0], edges[-1])
    axes.set_xlim(left=-0.02 * axes.get_xlim()[1])
    axes.axvline(0.0, color=BAND, linewidth=0.6, zorder=0.5)
    axes.set_xlabel("growth exponent, mean by flux")
    axes.tick_params(labelleft=False)
    letter(axes, "d  how far a nucleus grows")
