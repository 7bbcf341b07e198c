"""Where fibers meet their extremes of pressure, in the nozzle's outline (the paper's Fig. 19)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fibermelt.fiber.extremes import locations
from fibermelt.parts.bead.figures.extremes import EXTREMES
from fibermelt.parts.bead.figures.spread import extreme_of, spread_limits
from fibermelt.parts.bead.stages import stored_path, stored_zones
from fibermelt.parts.flow.figures.lines import against_paper, at_corners, initial_angles, regular
from fibermelt.parts.flow.figures.streamlines import draw_zones
from fibermelt.report.kit.drawing import draw_bead, frame, scale_bar, scene_axes
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, MPA, Scene, Window, read_scene
from fibermelt.report.kit.style import (
    FULL,
    INK,
    SEQUENTIAL,
    VERMILION,
    Array,
    Words,
    add_axes,
    color_bar,
    key_mark,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_positions", "worst_places"]

BETWEEN, FOOT, HEAD = 2.5, 1.5, 19.0
"""Room between panels, and below and above them [mm]."""

DOT = "#7d7c78"

MOST_POINTS = 2000
"""More fibers than this to a panel are painted in dots inside SVG."""


def positions_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    scene = read_scene(results)
    top, lips = _window(results, scene).top, scene.lips[0, 1]
    y = MM * results["extreme_y"].to_numpy()
    steady = regular(results)
    mean = {
        (location, kind): MM
        * extreme_of(results, "extreme_y", location, kind, "initial_angle")[steady].mean(axis=1)
        for _, location, kind in EXTREMES
    }
    outside = int(np.count_nonzero(y > top))
    left_out = (
        f" Above the frame, up to y = {sized(y.max(), scene.width)} mm, lie {outside} of {y.size}."
        if outside
        else ""
    )
    above = mean[1, "min"] - scene.capillary_entrance
    below = lips - mean[2, "max"]

    def apart(values: Array) -> str:
        low, high = (sized(end, scene.width) for end in (values.min(), values.max()))
        return f"{low} to {high}"

    beside = against_paper(
        results,
        "The paper's text has (d) about 0.5 mm below the exit, nearly evenly; here the means lie "
        f"{apart(below)} mm below it.",
    )
    near = at_corners(
        results, "Diamonds, left out of the means: streamlines", ", near a sharp corner."
    )
    return Words(
        caption=(
            f"Fig. 19 of the paper: where fibers of {initial_angles(results)} meet the extremes of "
            "pressure on their surface, less the melt's own, on all streamlines; dashed: zones. "
            "Crosses: where the bound over every orientation is reached, on some at zone 1 or 2, "
            f"where Loc. 1 ends and Loc. 2 begins.{near} The exact range of the places over all "
            f"initial angles is not stored.{left_out}{beside}"
        ),
        alt=(
            "Four outlines of the capillary and the gap with a point for every fiber. Mean places "
            f"by streamline: the lowest pressure at Loc. 1 {apart(above)} mm "
            "above the capillary's entrance; at Loc. 2 from y = "
            f"{apart(mean[2, 'min'])} mm, the exit being at {sized(lips, scene.width)} mm; the "
            f"highest at Loc. 2 {apart(below)} mm below the exit."
        ),
    )


@plate(
    "positions",
    "Where the extremes lie",
    section="fibers",
    words=positions_words,
    needs="extreme node_x",
    paper="Fig. 19",
)
def figure_positions(results: xr.Dataset) -> Figure:
    """Draw where the extremes lie, coloured by their size, and where the bounds are reached."""
    scene = read_scene(results)
    window = _window(results, scene)
    wide = (FULL - 2.0 - 3 * BETWEEN) / 4
    tall = wide * window.size[1] / window.size[0]
    figure = new_figure(FULL, FOOT + tall + HEAD)
    most = max(abs(end) for kind in ("min", "max") for end in spread_limits(results, kind))
    norm = Normalize(0.0, most)
    for k, (name, location, kind) in enumerate(EXTREMES):
        axes = scene_axes(figure, 1.0 + k * (wide + BETWEEN), FOOT, wide, window)
        draw_bead(axes, scene, window)
        draw_zones(axes, results)
        _places(axes, results, location, kind, norm)
        frame(axes)
        scale_bar(axes, window, height=0.55, share=0.2)
        letter(axes, f"{'abcd'[k]}  {name}")
    top = FOOT + tall + HEAD
    bar = add_axes(figure, FULL - 66, top - 4.0, 62, 2.2)
    hues = ScalarMappable(norm, SEQUENTIAL)
    color_bar(hues, bar, "size of the extreme, less the melt's own [MPa]", extend="max")
    key = add_axes(figure, 1.0, top - 9.5, 110, 9)
    key.set_axis_off()
    key.legend(handles=_key(), loc="upper left", ncols=2, columnspacing=2.0)
    return figure


def _window(results: xr.Dataset, scene: Scene) -> Window:
    """Return a window from the bed to a capillary's width above its entrance."""
    width = scene.width
    low = min(float(scene.sides["upstream surface"][:, 0].min()), float(scene.lips[0, 0]))
    top = scene.capillary_entrance + width
    x, y = (MM * results[f"extreme_{name}"].to_numpy() for name in "xy")
    right = max(float(x[y < top].max()), float(scene.lips[1, 0])) + 0.4 * width
    return Window(low - 0.25 * width, right, -0.12 * scene.lips[0, 1], top)


def worst_places(results: xr.Dataset, location: int, kind: str) -> Array:
    """Return where each streamline's bound over every orientation is reached, (streamline, 2) [m].

    Parameters
    ----------
    results : xarray.Dataset
        The results.
    location : int
        Which location, by its number.
    kind : str
        ``min`` or ``max``.
    """
    among = locations(stored_path(results), stored_zones(results))[location]
    bound = -results["bound_lowest"] if kind == "min" else results["bound_highest"]
    here = np.where(among, bound.to_numpy(), -np.inf)
    point = np.argmax(here, axis=1)[:, None]
    xy = [np.take_along_axis(results[name].to_numpy(), point, axis=1)[:, 0] for name in "xy"]
    return np.stack(xy, axis=-1)


def _places(axes: Axes, results: xr.Dataset, location: int, kind: str, norm: Normalize) -> None:
    """Draw the places of the extremes, their mean by streamline and those of the bounds."""
    value, x, y = (
        extreme_of(results, name, location, kind, "initial_angle")
        for name in ("extreme", "extreme_x", "extreme_y")
    )
    near = results["near_singularity"].to_numpy() > 0
    for rows, mark in ((~near, "o"), (near, "D")):
        axes.scatter(
            MM * x[rows].ravel(),
            MM * y[rows].ravel(),
            c=MPA * np.abs(value[rows]).ravel(),
            norm=norm,
            cmap=SEQUENTIAL,
            s=9,
            marker=mark,
            edgecolors="white",
            linewidths=0.25,
            rasterized=value.size > MOST_POINTS,
            zorder=4.5,
        )
    steady = regular(results)
    axes.plot(
        MM * x[steady].mean(axis=1), MM * y[steady].mean(axis=1), color=VERMILION, lw=1.1, zorder=5
    )
    worst = MM * worst_places(results, location, kind)
    axes.plot(*worst.T, "x", color=INK, markersize=3, markeredgewidth=0.7, zorder=4.2)


def _key() -> list[Line2D]:
    """Return what marks and lines mean."""
    return [
        key_mark("o", "a fiber's extreme", DOT, 6, edge="white"),
        key_mark("D", "the same, near a sharp corner", DOT, 6, edge="white"),
        Line2D([], [], color=VERMILION, linewidth=1.1, label="mean over the initial angles"),
        key_mark("x", "where the bound is reached", INK, 3),
    ]
