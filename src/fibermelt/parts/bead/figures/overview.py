"""The bead at a glance: where fibers may pull the melt below the atmosphere (Fig. 18, 19)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fibermelt.parts.bead.figures.spread import draw_spread, spread_key
from fibermelt.parts.flow.figures.carpet import weave
from fibermelt.parts.flow.figures.lines import features, regular
from fibermelt.report.kit.drawing import (
    draw_bead,
    draw_bed_motion,
    main_scene,
    mark_exit,
    on_paper,
    paint,
    scene_axes,
    spread_out,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, MPA, Scene, Window, read_scene
from fibermelt.report.kit.style import (
    ATMOSPHERE,
    Words,
    add_axes,
    color_bar,
    key_above,
    letter,
    round_up,
)
from fibermelt.report.kit.tables import number, ranged, sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_overview"]

CHARTS, SCALE = 64.0, 21.0
"""Height of the charts below the scene, and of the colour scale above the exit [mm]."""

PLACES = {1: "before the capillary", 2: "in the swell"}
"""Where the paper's Loc. 1 and Loc. 2 lie."""

FIBERS = "#404040"

LINE = 9.0
"""Height of a line of text, with what stays free above it [points]."""


def overview_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    own = results["pressure"].to_numpy()
    bound = MPA * (own + results["bound_lowest"].to_numpy())
    chosen = np.where(regular(results)[:, None], bound, np.inf)
    row, at = np.unravel_index(np.argmin(chosen), chosen.shape)
    width = read_scene(results).width
    where = [sized(MM * float(results[name][row, at]), width) for name in "xy"]
    extreme = results["extreme"].sel(kind="min", location=[*PLACES]).mean("initial_angle")
    mean = MPA * extreme.transpose("location", "streamline").to_numpy()
    share = 100 * float(results["quantile"][0])
    return Words(
        caption=(
            "The bead at a glance. Red: the pressure on a fiber's surface lies below the "
            "atmosphere's, where a void may form. (a) For the worst orientation there and then: "
            f"no fiber sees less. (b) Near the exit, what {share:.0f} % of the fibers of an "
            "isotropic start fall below: in the capillary fibers lie along the flow, and the worst "
            "orientation is rare. Drawn between the first and the last streamline. (c, d) Lowest "
            "surface pressure less the melt's own, by streamline, before the capillary "
            "and from the exit to the end of the swell; diamonds: the streamline passes near a "
            "singular corner, and its numbers depend on the mesh."
        ),
        alt=(
            "Map of the lowest pressure on fibers, from well above the atmosphere's in the upper "
            "nozzle to about the atmosphere's in the settled bead. Away from singular corners "
            f"the worst orientation gives {number(chosen[row, at], 3)} MPa, on streamline "
            f"{int(results['streamline'][row])} at x = {where[0]} mm, y = {where[1]} mm. "
            "Two charts by streamline of the lowest pressure on a fiber less the melt's own: its "
            "mean over the initial angles lies at Loc. 1 between "
            f"{ranged(mean[0].min(), mean[0].max(), between='and')} MPa, at Loc. 2 between "
            f"{ranged(mean[1].min(), mean[1].max(), between='and')} MPa."
        ),
    )


@plate(
    "overview",
    "The bead at a glance",
    section="bead",
    words=overview_words,
    needs="extreme node_x",
    place=0,
)
def figure_overview(results: xr.Dataset) -> Figure:
    """Draw the lowest surface pressure over the bead, and the extremes by streamline."""
    scene = read_scene(results)
    figure, axes, room = main_scene(scene, extra=SCALE, below=CHARTS)
    gap = scene_axes(figure, room.left, room.bottom, room.width, scene.exit)
    carpet = weave(results)
    own = MPA * results["pressure"].to_numpy()
    worst = own + MPA * results["bound_lowest"].to_numpy()
    unlucky = own + MPA * results["quantile_lowest"].to_numpy()[..., 0]
    limit = round_up(float(own.max()))
    norm = Normalize(-limit, limit)
    for panel, window, values in ((axes, scene.whole, worst), (gap, scene.exit, unlucky)):
        _bead(panel, results, scene, window)
        if carpet is not None:
            paint(panel, carpet.triangles, carpet.values(values), norm, ATMOSPHERE)
    draw_bed_motion(axes, results, scene)
    _numbers(axes, results)
    mark_exit(axes, gap, scene)
    share = 100 * float(results["quantile"][0])
    letter(axes, "a  worst orientation of a fiber", inside=True)
    letter(gap, f"b  {share:.0f} % of fibers from an isotropic start see less (dashed frame)")
    bar = add_axes(figure, room.left, room.bottom + room.fit(scene.exit) + 17, room.width, 2.5)
    color_bar(
        ScalarMappable(norm, ATMOSPHERE),
        bar,
        "lowest pressure on a fiber [MPa], atmosphere = 0",
        extend="both",
    )
    for k, (left, (location, place)) in enumerate(zip((14.0, 109.0), PLACES.items(), strict=True)):
        chart = add_axes(figure, left, 9, 78, CHARTS - 24)
        draw_spread(chart, results, location, "min")
        letter(chart, f"{'cd'[k]}  Loc. {location}, {place}")
        if k == 0:
            chart.set_ylabel("lowest less melt's own [MPa]")
            key_above(chart, spread_key(results), 1.12, columns=6, between=1.1)
    return figure


def _bead(axes: Axes, results: xr.Dataset, scene: Scene, window: Window) -> None:
    """Draw the bead, with the marked streamlines as thin lines."""
    draw_bead(axes, scene, window)
    for feature in features(results):
        line = (MM * results[name].to_numpy()[feature.row] for name in "xy")
        axes.plot(*line, color=FIBERS, linewidth=0.4, zorder=2)


def _numbers(axes: Axes, results: xr.Dataset) -> None:
    """Write the numbers of the marked streamlines at the outlet."""
    marked = features(results)
    ends = MM * results["y"].to_numpy()[[feature.row for feature in marked], -1]
    right = MM * float(results["x"].max())
    heights = spread_out(ends, on_paper(axes, LINE))
    for feature, height in zip(marked, heights, strict=True):
        axes.annotate(
            str(feature.number),
            (right, height),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            color=feature.color,
            fontweight="bold",
        )
