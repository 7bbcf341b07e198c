"""Pressure and orientation of all fibers over time on the marked streamlines (Fig. 17)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fibermelt.parts.flow.figures.lines import (
    Feature,
    against_paper,
    features,
    initial_angles,
    regular,
)
from fibermelt.parts.flow.figures.timeline import (
    SIDES,
    draw_bound,
    draw_own,
    mark_zones,
    on_fibers,
    span,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import (
    BAND,
    FULL,
    GREY,
    INK,
    Array,
    Roomy,
    Words,
    add_axes,
    color_bar,
    key_mark,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_profiles", "relative_angle"]

LEFT, RIGHT, BETWEEN, FOOT, TALL, HEAD = 14.0, 2.5, 5.0, 9.0, 42.0, 19.0
"""Margins, room between panels, heights of foot, panels and head [mm]."""

SHARED = 0.4 * BETWEEN * 72.0 / 25.4
"""How far the numbers below a panel may reach to its neighbour [points]."""

HUES = ListedColormap(mpl.colormaps["plasma"](np.linspace(0.0, 0.85, 256)))
"""Initial angles: dark to bright, without the yellow that white paper swallows."""

RIGHT_ANGLE = 90.0

ROWS = (*SIDES, "angle")


def relative_angle(results: xr.Dataset, row: int) -> Array:
    """Return the angle of each fiber to the streamline over time [degrees], (initial angle, point).

    A fiber has no head: each curve goes on without jumps, and half turns are added to all of it so
    that it ends within a quarter turn of the streamline, as the paper does.
    """
    way = np.unwrap(np.arctan2(results["v"].to_numpy()[row], results["u"].to_numpy()[row]))
    turned = np.unwrap(results["angle"].to_numpy()[row], period=np.pi, axis=-1) - way
    half_turns = np.round(turned[:, -1:] / np.pi)
    found: Array = np.degrees(turned - np.pi * half_turns)
    return found


def profiles_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    marked = features(results)
    numbers = ", ".join(str(feature.number) for feature in marked)
    told = []
    for feature in marked:
        low = on_fibers(results, "lowest", feature.row)
        end = np.abs(relative_angle(results, feature.row)[:, -1])
        told.append(
            f"on streamline {feature.number} the lowest is {number(low.min(), 3)} MPa, and at "
            f"the end the fibers lie within {end.max():.0f}° of the streamline, half of them "
            f"within {np.median(end):.0f}°"
        )
    stay = np.diff(results["zone_time"].to_numpy())[:, 1]
    stays = ", ".join(f"{number(stay[feature.row], 3)} s" for feature in marked)
    # Both ways across: entering angles are stored in radians, rounded at most in the last digit.
    across = np.isclose(np.abs(results["initial_angle"].to_numpy()), 0.5 * np.pi)
    same = " Fibers that enter at ±90° are the same fiber." if across.sum() > 1 else ""
    beside = against_paper(
        results,
        "The paper's text has fibers on its center streamline depend most on the initial angle, "
        "and the time between zones 2 and 3 grow from the downstream edge to the upstream one; "
        f"here it is {stays} on streamlines {numbers}.",
    )
    return Words(
        caption=(
            f"Fig. 17 of the paper: streamlines {numbers}, fibers of {initial_angles(results)}. "
            "From above: lowest and highest pressure on the fiber, against the atmosphere's; angle "
            "to the streamline, each curve shifted by half turns so that it ends within 90°, as "
            "the paper does. Bands reach from the melt's own pressure to the bound over every "
            "orientation; angles have no such bound, as every direction is at all times that of "
            f"some fiber.{same} Each streamline has its own "
            "time scale, from where something happens to behind zone 3."
            f"{beside}"
        ),
        alt=(
            f"Three panels over time for each of the streamlines {numbers}: "
            + "; ".join(told)
            + "."
        ),
    )


@plate(
    "profiles",
    "Pressure and orientation over time",
    section="fibers",
    words=profiles_words,
    needs="extreme node_x",
    paper="Fig. 17",
)
def figure_profiles(results: xr.Dataset) -> Figure:
    """Draw lowest and highest pressure and relative angle, a column for each marked streamline."""
    marked = features(results)
    wide = (FULL - LEFT - RIGHT - (len(marked) - 1) * BETWEEN) / len(marked)
    figure = new_figure(FULL, FOOT + len(ROWS) * (TALL + BETWEEN) + HEAD)
    limits = _limits(results, marked)
    names = ("lowest pressure [MPa]", "highest pressure [MPa]", "angle to the streamline [°]")
    for column, feature in enumerate(marked):
        for k, what in enumerate(ROWS):
            left = LEFT + column * (wide + BETWEEN)
            axes = add_axes(figure, left, FOOT + (2 - k) * (TALL + BETWEEN), wide, TALL)
            axes.set_xlim(*span(results, feature.row))
            axes.set_ylim(*limits[what])
            _panel(axes, results, feature, what)
            mark_zones(axes, results, feature.row, numbers=k == 0)
            axes.xaxis.set_major_locator(Roomy(max(2, int(wide / 11)), beyond=SHARED))
            if k < len(ROWS) - 1:
                axes.tick_params(labelbottom=False)
            else:
                axes.set_xlabel("time since the inlet [s]")
            if column == 0:
                axes.set_ylabel(names[k])
            else:
                axes.tick_params(labelleft=False)
            if k == 0:
                _name(axes, f"{'abcde'[column]}  streamline {feature.number}", feature)
    _head(figure, results, wide)
    return figure


def _name(axes: Axes, text: str, feature: Feature) -> None:
    """Write over a column which streamline it is of."""
    letter(axes, text)
    axes.texts[-1].set(color=feature.color, fontweight="bold", position=(0, 13))


def _head(figure: Figure, results: xr.Dataset, wide: float) -> None:
    """Draw the key and the scale of the initial angles above the panels."""
    top = 25.4 * float(figure.get_size_inches()[1])
    bar = add_axes(figure, FULL - RIGHT - 62.0, top - 4.0, 58.0, 2.2)
    hues = ScalarMappable(Normalize(-RIGHT_ANGLE, RIGHT_ANGLE), HUES)
    color_bar(hues, bar, "initial angle of the fibers [°]").set_ticks([-90, -45, 0, 45, 90])
    key = add_axes(figure, LEFT, top - 10.0, 100.0, 8.0)
    key.set_axis_off()
    handles = [
        Line2D([], [], color=INK, linewidth=1.3, label="melt's own pressure"),
        Patch(facecolor=GREY, alpha=0.25, label="to the bound over every orientation"),
        key_mark("o", "zones 1 to 3", INK, 6),
    ]
    key.legend(handles=handles, loc="upper left", ncols=2, columnspacing=2.0)


def _limits(results: xr.Dataset, marked: list[Feature]) -> dict[str, tuple[float, float]]:
    """Return the scales that all columns share; lines near a sharp corner do not set them."""
    steady = regular(results)
    rows = [f.row for f in marked if steady[f.row]] or [f.row for f in marked]
    found: dict[str, tuple[float, float]] = {}
    for side in SIDES:
        shown = [on_fibers(results, f"bound_{side}", row) for row in rows]
        melt = [on_fibers(results, side, row) for row in rows]
        ends = [np.concatenate([v.ravel() for v in (*shown, *melt)])]
        low, high = float(np.min(ends)), float(np.max(ends))
        found[side] = (low - 0.05 * (high - low), high + 0.05 * (high - low))
    angle = np.concatenate([relative_angle(results, feature.row).ravel() for feature in marked])
    low, high = np.floor(angle.min() / RIGHT_ANGLE), np.ceil(angle.max() / RIGHT_ANGLE)
    found["angle"] = (RIGHT_ANGLE * float(low), RIGHT_ANGLE * float(high))
    return found


def _panel(axes: Axes, results: xr.Dataset, feature: Feature, what: str) -> None:
    """Draw one quantity on one streamline."""
    time = results["time"].to_numpy()[feature.row]
    if what == "angle":
        values = relative_angle(results, feature.row)
        low, high = axes.get_ylim()
        quarters = np.arange(low, high + 1.0, RIGHT_ANGLE)
        axes.set_yticks(quarters)
        for level in quarters[np.isclose(quarters % (2 * RIGHT_ANGLE), 0.0)]:
            axes.axhline(level, color=BAND, linewidth=0.8, zorder=0.8)
    else:
        for side in SIDES:
            if side == what:
                draw_bound(axes, results, feature.row, side)
        draw_own(axes, results, feature.row)
        values = on_fibers(results, what, feature.row)
    start = np.degrees(results["initial_angle"].to_numpy())
    ahead = (start + RIGHT_ANGLE) % (2.0 * RIGHT_ANGLE) - RIGHT_ANGLE
    shade = 0.5 + 0.5 * np.where(np.abs(start) > RIGHT_ANGLE, ahead, start) / RIGHT_ANGLE
    # Over ±90 degrees the same fiber enters twice: the first stays in sight.
    for k in reversed(range(len(start))):
        axes.plot(time, values[k], color=HUES(shade[k]), linewidth=0.7, zorder=2)
