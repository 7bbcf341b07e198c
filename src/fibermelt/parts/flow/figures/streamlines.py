"""The streamlines, with zones and the places of the pressure extremes (the paper's Fig. 2b)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fibermelt.parts.flow.figures.lines import ZONES, at_corners, at_time, features, named, rest
from fibermelt.report.kit.drawing import (
    draw_bead,
    draw_bed_motion,
    frame,
    main_scene,
    mark_window,
    on_paper,
    scale_bar,
    scene_axes,
    spread_out,
    zone_badge,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, Scene, Window, read_scene
from fibermelt.report.kit.style import (
    GREY,
    INK,
    ORANGE,
    PINK,
    Words,
    add_axes,
    key_mark,
    letter,
)
from fibermelt.report.kit.tables import number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["draw_zones", "figure_streamlines"]

PLACES = (("o", PINK), ("^", ORANGE))
"""Mark and colour of the places of Loc. 1 and Loc. 2."""

KEY = 22.0
"""Height of the key to the marks [mm]."""

DIGITS = 6.5
"""Width of a bold digit, with its share of what stays free between two numbers [points]."""

ZONE_DASHES = (0, (2.5, 1.5))


def streamlines_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    count = results.sizes["streamline"]
    marked = ", ".join(str(feature.number) for feature in features(results))
    end = results["time"].to_numpy()[:, -1]
    zones = "; ".join(f"{k + 1}, {name}" for k, name in enumerate(ZONES))
    lines = f"{count} streamline{'' if count == 1 else 's'}"
    near = at_corners(
        results, "Near a sharp corner, and so dependent on the mesh: streamlines", "."
    )
    return Words(
        caption=(
            f"Fig. 2b of the paper: {lines} of the same share of the flux, numbered "
            f"from the upstream edge; {marked} are marked, in the same colours in every figure. "
            f"Dashed: zones ({zones}). Points: where the fibers of all initial angles meet their "
            "lowest surface pressure against the melt around them, before the capillary "
            f"(Loc. 1) and from the exit to the end of the swell (Loc. 2).{near}"
        ),
        alt=(
            "Streamlines run down the nozzle, crowd into the capillary, turn in the gap and leave "
            "with the bed; those from the upstream edge come to lie at the bottom of the bead, the "
            f"last at its top. The melt takes {number(end.min(), 3)} s on the fastest "
            f"line and {number(end.max(), 3)} s on the slowest."
        ),
    )


@plate(
    "streamlines",
    "Streamlines",
    section="flow",
    words=streamlines_words,
    needs="extreme node_x",
    paper="Fig. 2b",
)
def figure_streamlines(results: xr.Dataset) -> Figure:
    """Draw all streamlines in the nozzle's outline, and the gap once more, larger."""
    scene = read_scene(results)
    figure, axes, room = main_scene(scene, extra=KEY)
    _paint(axes, scene, scene.whole, results)
    draw_bed_motion(axes, results, scene)
    _numbers(axes, results)
    mark_window(axes, scene.exit)

    gap = scene_axes(figure, room.left, room.bottom, room.width, scene.exit)
    _paint(gap, scene, scene.exit, results)
    frame(gap)
    letter(gap, "gap and bead (dashed frame)")
    scale_bar(gap, scene.exit, height=0.85, share=0.12)
    _places(axes, results)
    _places(gap, results)
    key = add_axes(figure, room.left, room.bottom + room.fit(scene.exit) + 7.0, room.width, KEY)
    key.set_axis_off()
    key.legend(handles=_key(results), loc="lower left", labelspacing=0.55)
    return figure


def _key(results: xr.Dataset) -> list[Line2D]:
    """Return what the colours, marks and dashes mean."""
    marked = ", ".join(str(feature.number) for feature in features(results))
    names = f"streamlines of equal flux, {marked} marked"
    lines = [Line2D([], [], color=GREY, linewidth=0.6, label=names)]
    zones = ", ".join(f"{k + 1} {name}" for k, name in enumerate(ZONES))
    lines += [
        Line2D([], [], color=INK, linewidth=0.9, linestyle=ZONE_DASHES, label=f"zones: {zones}")
    ]
    where = ("before the capillary", "in the swell")
    return lines + [
        key_mark(mark, f"Loc. {k + 1}: lowest pressure on a fiber {where[k]}", color, 4)
        for k, (mark, color) in enumerate(PLACES)
    ]


def _paint(axes: Axes, scene: Scene, window: Window, results: xr.Dataset) -> None:
    draw_bead(axes, scene, window)
    x, y = MM * results["x"].to_numpy(), MM * results["y"].to_numpy()
    for row in rest(results):
        axes.plot(x[row], y[row], color=GREY, linewidth=0.5, zorder=1.5)
    for feature in features(results):
        axes.plot(x[feature.row], y[feature.row], color=feature.color, linewidth=1.6, zorder=1.8)
    draw_zones(axes, results)


def draw_zones(axes: Axes, results: xr.Dataset) -> None:
    """Draw a dashed line through the points where the streamlines reach each zone, numbered."""
    when = results["zone_time"].to_numpy()
    at = [MM * at_time(results, name, when).T for name in "xy"]
    for zone, (x, y) in enumerate(zip(*at, strict=True)):
        axes.plot(x, y, color=INK, linewidth=0.9, linestyle=ZONE_DASHES, zorder=4)
        end = int(np.argmax(y)) if zone == 2 else -1
        if not axes.viewLim.contains(x[end], y[end]):
            continue
        zone_badge(axes, zone + 1, (x[end], y[end]), (4, 6) if zone == 2 else (9, 0))


def _places(axes: Axes, results: xr.Dataset) -> None:
    """Mark where each fiber meets its lowest pressure, at Loc. 1 and Loc. 2."""
    at = {"kind": "min", "location": [*range(1, len(PLACES) + 1)]}
    x, y = (MM * results[f"extreme_{name}"].sel(at).to_numpy() for name in "xy")
    for k, (mark, color) in enumerate(PLACES):
        axes.plot(
            x[..., k].ravel(),
            y[..., k].ravel(),
            linestyle="none",
            marker=mark,
            markersize=2.6,
            markerfacecolor=color,
            markeredgecolor="white",
            markeredgewidth=0.25,
            zorder=3.5,
        )


def _numbers(axes: Axes, results: xr.Dataset) -> None:
    """Write the numbers of the marked streamlines, the first and the last over the inlet."""
    numbers = results["streamline"].to_numpy()
    shown = named(results)
    start = MM * results["x"].to_numpy()[[*shown], 0]
    top = MM * float(results["y"].max())
    wide = DIGITS * max(len(str(numbers[row])) for row in shown)
    for (row, color), x in zip(shown.items(), spread_out(start, on_paper(axes, wide)), strict=True):
        axes.annotate(
            str(numbers[row]),
            (x, top),
            xytext=(0, 2.5),
            textcoords="offset points",
            ha="center",
            va="bottom",
            color=color or GREY,
            fontweight="bold",
        )
