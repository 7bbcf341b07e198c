"""One fiber on its way, and the melt around it at its first extreme (the paper's Fig. 16)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import LinearTriInterpolator

from fibermelt.engine.results import study_of
from fibermelt.parts.bead.figures.surroundings import (
    LEVELS,
    Instant,
    draw_contours,
    draw_fiber,
    read_instant,
    rotation,
)
from fibermelt.parts.flow.figures.lines import against_paper, center_feature
from fibermelt.parts.flow.figures.timeline import (
    SIDES,
    Side,
    draw_bound,
    draw_own,
    mark_zones,
    on_fibers,
    span,
)
from fibermelt.report.kit.drawing import scene_axes
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, MPA, Window
from fibermelt.report.kit.style import (
    DIVERGING,
    FULL,
    GREY,
    INK,
    SEQUENTIAL,
    Words,
    add_axes,
    color_bar,
    key_above,
    key_mark,
    letter,
    new_figure,
    round_up,
)
from fibermelt.report.kit.tables import number, ranged
from fibermelt.units import UM

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_history"]

STARTS: dict[Side, float] = {"lowest": 0.0, "highest": -90.0}
"""Initial angles [degrees] of the fibers whose lowest and highest pressure the paper draws."""

ROOM = (0.05, 0.14)
"""Free parts of the pressure's scale below and above, for the name."""

MARKS = {1: "o", 2: "v"}
"""Marks of the extremes at Loc. 1 and Loc. 2."""

AROUND = 78.0
"""Height of the panels of a fiber's surroundings [mm]."""

ARROWS = 11
"""Arrows across the surroundings."""

CLEAR = 1.12
"""Arrows begin this much outside the fiber, over its size: its own motion is not drawn."""


THINS = "In a melt that thins the flow around this fiber is not known, and not drawn. "


def _start(results: xr.Dataset, side: Side) -> int:
    """Return the place of the initial direction nearest to the one that the paper draws."""
    angle = results["initial_angle"].to_numpy() - np.radians(STARTS[side])
    rise = results["initial_elevation"].to_numpy() if "initial_elevation" in results else 0.0
    return int(np.argmax(np.abs(np.cos(angle) * np.cos(rise))))


def _degrees(results: xr.Dataset, side: Side) -> float:
    """Return the initial angle of that fiber [degrees]."""
    start = float(np.degrees(float(results["initial_angle"][_start(results, side)])))
    return round(start, 1) + 0.0


def _first_lowest(results: xr.Dataset) -> Instant:
    """Return the flow around the fiber of panel a when its pressure is lowest at Loc. 1."""
    row, fiber = center_feature(results).row, _start(results, "lowest")
    when = results["extreme_time"].isel(streamline=row, initial_angle=fiber).sel(location=1)
    time = results["time"].to_numpy()[row]
    point = int(np.argmin(np.abs(time - float(when.sel(kind="min")))))
    return read_instant(results, row, fiber, point, study_of(results)["fiber"]["half_length"])


def _is_known(results: xr.Dataset) -> bool:
    """Tell whether the flow around a fiber is known: of melts that thin, that in a cell is."""
    return "thinning_rate" not in results or "around_pressure" in results


def history_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    feature = center_feature(results)
    at = {
        side: results.isel(streamline=feature.row, initial_angle=_start(results, side))
        for side in STARTS
    }
    low, high = (
        at[side].sel(kind=SIDES[side][0], location=[*MARKS])["extreme_pressure"].to_numpy() * MPA
        for side in STARTS
    )
    beside = against_paper(
        results,
        "The paper's text has only Loc. 2 below the atmosphere, down to about -0.4 MPa; here this "
        f"fiber comes to {number(low[0], 3)} MPa at Loc. 1 and {number(low[1], 3)} MPa at Loc. 2.",
    )
    around = _around_in_words(results) if _is_known(results) else Words(THINS, "")
    return Words(
        caption=(
            f"Fig. 16 of the paper, streamline {feature.number}: (a) lowest pressure on the fiber "
            f"that enters at {_degrees(results, 'lowest'):g}°, (b) highest on the one that enters "
            f"at {_degrees(results, 'highest'):g}°, with the melt's own pressure; "
            "upright lines: ΔP at Loc. 1 and 2; bands: to the bound over every orientation. "
            f"{around.caption}The quiet ends are left out.{beside}"
        ).replace(" -", " −"),
        alt=(
            f"The lowest pressure on the fiber is {number(low[0], 3)} MPa at Loc. 1 and "
            f"{number(low[1], 3)} MPa at Loc. 2, the highest on the other {number(high[0], 3)} and "
            f"{number(high[1], 3)} MPa, all against the atmosphere's.{around.alt}"
        ),
    )


@plate(
    "history",
    "Pressure on a fiber along a streamline",
    section="fibers",
    words=history_words,
    needs="extreme node_x",
    paper="Fig. 16",
)
def figure_history(results: xr.Dataset) -> Figure:
    """Draw one fiber's lowest and another's highest pressure over time, and the melt around one."""
    around = AROUND if _is_known(results) else 0.0
    figure = new_figure(FULL, 66 + around)
    for k, side in enumerate(STARTS):
        axes = add_axes(figure, 15 + 94 * k, 10 + around, 78, 45)
        _panel(axes, results, side)
        name = f"{'ab'[k]}  {side} pressure, initial angle {_degrees(results, side):g}°"
        letter(axes, name.replace("-", "−"), inside=True)
        if k == 0:
            axes.set_ylabel("above the atmosphere's [MPa]")
            key_above(axes, _key(), 1.12, columns=7, between=1.4)
    if not around:
        return figure
    instant = _first_lowest(results)
    for k, draw in enumerate((_speed, _pressure)):
        axes = scene_axes(figure, 14 + 91 * k, 10, 61, _around(results))
        bar = add_axes(figure, 77.5 + 91 * k, 12, 2.2, 57)
        draw(axes, bar, results, instant)
        axes.set_xlabel("x from the fiber's center [µm]")
        axes.spines[["top", "right"]].set_visible(True)
        what = ("speed |v|", "pressure less the melt's own")[k]
        letter(axes, f"{'cd'[k]}  {what} at Loc. 1 of a")
        if k == 0:
            axes.set_ylabel("y from the fiber's center [µm]")
    return figure


def _panel(axes: Axes, results: xr.Dataset, side: Side) -> None:
    """Draw one side of the pressure on one fiber, its bound, and its two extremes."""
    row, fiber = center_feature(results).row, _start(results, side)
    time = results["time"].to_numpy()[row]
    color = SIDES[side][1]
    draw_bound(axes, results, row, side)
    draw_own(axes, results, row)
    value = on_fibers(results, side, row)[fiber]
    axes.plot(time, value, color=color, linewidth=1.2, zorder=3.2)
    axes.set_xlim(*span(results, row))
    low, high = (on_fibers(results, f"bound_{name}", row) for name in SIDES)
    most, least = float(high.max()), float(low.min())
    axes.set_ylim(least - ROOM[0] * (most - least), most + ROOM[1] * (most - least))
    axes.set_xlabel("time since the inlet [s]")
    mark_zones(axes, results, row)
    _extremes(axes, results, side)


def _extremes(axes: Axes, results: xr.Dataset, side: Side) -> None:
    """Mark the extremes of the panel's fiber, and write their distance from the melt's own."""
    kind, color = SIDES[side]
    row, fiber = center_feature(results).row, _start(results, side)
    found = results.isel(streamline=row, initial_angle=fiber).sel(kind=kind, location=[*MARKS])
    when = found["extreme_time"].to_numpy()
    end, rise = (MPA * found[name].to_numpy() for name in ("extreme_pressure", "extreme"))
    told = []
    for k, (location, mark) in enumerate(MARKS.items()):
        axes.plot([when[k]] * 2, [end[k], end[k] - rise[k]], color=INK, linewidth=0.9, zorder=4)
        axes.plot(when[k], end[k], mark, mfc="white", mec=color, markersize=4.5, zorder=4.2)
        sign = "+" if rise[k] > 0 else ""
        told.append(f"$\\Delta P$ = {sign}{number(rise[k], 3)} MPa at Loc. {location}")
    axes.annotate(
        "\n".join(told),
        (0.0, 0.0),
        xycoords="axes fraction",
        xytext=(4, 5),
        textcoords="offset points",
        va="bottom",
        linespacing=1.4,
        zorder=5,
    )


def _key() -> list[Line2D | Patch]:
    """Return what lines, bands and discs mean."""
    return [
        Line2D([], [], color=INK, linewidth=1.3, label="melt's own"),
        Line2D([], [], color=SIDES["lowest"][1], linewidth=1.2, label="lowest"),
        Line2D([], [], color=SIDES["highest"][1], linewidth=1.2, label="highest on the fiber"),
        Patch(facecolor=GREY, alpha=0.25, label="to the bound, every orientation"),
        *[
            key_mark(mark, f"Loc. {location}", INK, 4.5, face="white")
            for location, mark in MARKS.items()
        ],
        key_mark("o", "zones", INK, 6),
    ]


def _around(results: xr.Dataset) -> Window:
    """Return a window on the fiber's surroundings [µm]."""
    radius = 1.04 * UM * study_of(results)["fiber"]["half_length"] * _radius(results)
    return Window(-radius, radius, -radius, radius)


def _radius(results: xr.Dataset) -> float:
    """Return how far the surroundings reach, in half-lengths."""
    return float(np.hypot(*results["cell_point"].to_numpy().T).max())


def _in_micrometres(axes: Axes, results: xr.Dataset) -> None:
    """Draw what follows in half-lengths into axes that stay in micrometres."""
    scale = 1.0 / (UM * study_of(results)["fiber"]["half_length"])
    ticks = MaxNLocator(5, symmetric=True).tick_values(*axes.get_xlim())
    low, high = axes.get_xlim()
    shown = [tick for tick in ticks if low <= tick <= high]
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_ticks(
            [tick * scale for tick in shown], [f"{t:g}".replace("-", "−") for t in shown]
        )
    axes.set_xlim(low * scale, high * scale)
    axes.set_ylim(low * scale, high * scale)


def _speed(axes: Axes, bar: Axes, results: xr.Dataset, instant: Instant) -> None:
    """Draw the speed, and arrows of the velocity relative to the fiber's centre."""
    _in_micrometres(axes, results)
    triangles = instant.triangles
    speed = MM * instant.speed
    even = MaxNLocator(12, steps=[1, 2, 5, 10])
    levels = np.asarray(even.tick_values(float(speed.min()), float(speed.max())))
    field = draw_contours(axes, triangles, speed, levels, SEQUENTIAL)
    color_bar(field, bar, "|v| [mm/s]", upright=True)
    radius = _radius(results)
    grid = np.linspace(-0.92 * radius, 0.92 * radius, ARROWS)
    place = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    local = place @ rotation(instant.angle)
    outside = np.hypot(local[:, 0], local[:, 1] * float(results["aspect_ratio"])) > CLEAR
    place = place[outside & (np.hypot(*place.T) < 0.95 * radius)]
    u, v = (LinearTriInterpolator(triangles, part)(*place.T) for part in instant.around.T)
    axes.quiver(*place.T, u, v, color="white", ec=INK, lw=0.3, width=0.007, pivot="mid", zorder=3)
    _finish(axes, results, instant)


def _pressure(axes: Axes, bar: Axes, results: xr.Dataset, instant: Instant) -> None:
    """Draw the pressure less the melt's own."""
    _in_micrometres(axes, results)
    pressure = MPA * instant.pressure
    levels = round_up(float(np.abs(pressure).max())) * LEVELS
    field = draw_contours(axes, instant.triangles, pressure, levels, DIVERGING)
    scale = color_bar(field, bar, r"$p - p_\psi$ [MPa]", upright=True)
    scale.set_ticks([*levels[::2]])
    _finish(axes, results, instant)


def _finish(axes: Axes, results: xr.Dataset, instant: Instant) -> None:
    """Draw the fiber, the edge of what surrounds it, and where the melt goes."""
    radius = _radius(results)
    axes.add_patch(Circle((0, 0), radius, facecolor="none", edgecolor=GREY, lw=0.6, zorder=2))
    draw_fiber(axes, results, instant.angle)
    way = instant.melt / float(np.hypot(*instant.melt))
    axes.annotate(
        "",
        tuple(np.array([-0.86, -0.86]) * radius + 0.14 * radius * way),
        xytext=tuple(np.array([-0.86, -0.86]) * radius - 0.14 * radius * way),
        arrowprops={"arrowstyle": "-|>", "linewidth": 1.2, "color": INK},
    )


def _around_in_words(results: xr.Dataset) -> Words:
    """Return what caption and alternative text say of the panels around a fiber."""
    instant = _first_lowest(results)
    speed, pressure = MM * instant.speed, MPA * instant.pressure
    steep = np.degrees(abs(instant.elevation))
    plane = (
        ""
        if steep < 0.05
        else f"The fiber stands {steep:.0f}° out of the plane; drawn is one in the plane. "
    )
    return Words(
        caption=(
            f"(c, d) The melt around the fiber of (a) at {number(instant.time, 3)} s, lowest at "
            "Loc. 1, in the flow's directions: speed with the fiber's own as in the paper's Eq. 5 "
            "(outlined arrows: velocity relative to its center; full arrow: where it goes), and "
            f"pressure less the melt's own {number(MPA * instant.own, 3)} MPa. {plane}"
        ),
        alt=(
            " Around the fiber the speed "
            f"lies between {ranged(speed.min(), speed.max(), between='and')} mm/s, and the "
            f"pressure differs from the melt's own by {number(pressure.min(), 3)} MPa at its tips "
            f"and {number(pressure.max(), 3)} MPa at its flanks."
        ),
    )
