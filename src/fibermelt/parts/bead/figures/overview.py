"""The bead at a glance: where fibers may pull the melt below its vapor (Fig. 18, 19)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fibermelt.parts.bead.figures.spread import draw_spread, spread_key
from fibermelt.parts.flow.figures.carpet import weave
from fibermelt.parts.flow.figures.judged import (
    colors_said,
    held_against,
    key_of_unjudged,
    vapor_above_air,
)
from fibermelt.parts.flow.figures.lines import features, regular
from fibermelt.report.kit.drawing import (
    draw_bead,
    draw_bed_motion,
    main_scene,
    mark_exit,
    on_paper,
    scene_axes,
    spread_out,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, MPA, Scene, Window, read_scene
from fibermelt.report.kit.style import (
    UNJUDGED,
    Array,
    Words,
    add_axes,
    key_above,
    letter,
)
from fibermelt.report.kit.tables import number, ranged, sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_overview"]

CHARTS, SCALE = 64.0, 25.0
"""Height of the charts below the scene, and of the colour scale above the exit [mm]."""

PLACES = {1: "before the capillary", 2: "in the swell"}
"""Where the paper's Loc. 1 and Loc. 2 lie."""

WHAT = "lowest pressure on a fiber"

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
            "The bead at a glance: lowest pressure on the surface of a fiber; "
            f"{colors_said(results)}. (a) In the "
            "worst direction there and then: no fiber sees less. (b) Near the exit, what "
            f"{share:.0f} % of the fibers fall below that enter in random directions: in the "
            "capillary fibers lie along the flow, and the worst direction is rare. Hatched: melt "
            "beyond the first and the last streamline, and around those that pass near a sharp "
            "corner, whose numbers depend on the mesh. (c, d) Lowest surface pressure less the "
            "melt's own, by streamline, before the capillary and in the swell; diamonds: "
            "streamlines near a sharp corner."
        ),
        alt=(
            "Map of the lowest pressure on fibers, from well above the atmosphere's in the upper "
            f"nozzle to about the atmosphere's in the settled bead. {_verdict(results, bound)}Away "
            "from sharp corners the worst direction gives "
            f"{number(chosen[row, at], 3)} MPa above the atmosphere's, on streamline "
            f"{int(results['streamline'][row])} at x = {where[0]} mm, y = {where[1]} mm. "
            "Two charts by streamline of the lowest pressure on a fiber less the melt's own: its "
            "mean over the initial angles lies at Loc. 1 between "
            f"{ranged(mean[0].min(), mean[0].max(), between='and')} MPa, at Loc. 2 between "
            f"{ranged(mean[1].min(), mean[1].max(), between='and')} MPa."
        ),
    )


def _verdict(results: xr.Dataset, bound: Array) -> str:
    """Return on how many streamlines red is met; nothing where nothing is judged."""
    vapor = vapor_above_air(results)
    if vapor is None:
        return ""
    below = (bound[regular(results)] < vapor).any(axis=1)
    return f"Red is met on {np.count_nonzero(below)} of the {below.size} streamlines judged. "


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
    left_out = results["near_singularity"].to_numpy() > 0
    against = held_against(results, worst[regular(results)], WHAT)
    for panel, window, values in ((axes, scene.whole, worst), (gap, scene.exit, unlucky)):
        _bead(panel, results, scene, window)
        if carpet is not None:
            against.paint(panel, carpet, values, left_out)
    draw_bed_motion(axes, results, scene)
    _numbers(axes, results)
    mark_exit(axes, gap, scene)
    share = 100 * float(results["quantile"][0])
    letter(axes, "a  worst direction of a fiber", inside=True)
    letter(gap, f"b  {share:.0f} % of randomly entering fibers see less (dashed frame)")
    bar = add_axes(figure, room.left, room.bottom + room.fit(scene.exit) + 17, room.width, 2.5)
    against.bar(bar)
    key_of_unjudged(bar, results)
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
    draw_bead(axes, scene, window, fill=UNJUDGED)
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
