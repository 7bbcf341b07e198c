"""One fiber over a turn in simple shear, beside Jeffery's (the paper's Fig. 8 and 9)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator

from fibermelt.paper.orbits.figures.turns import (
    JEFFERY,
    KPA,
    OURS,
    Turn,
    cell_name,
    plain,
    read_turn,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import COLUMN, Words, add_axes, letter, new_figure

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_motion", "figure_pressures"]

MODELS = ("confined-ellipse", "ellipse")
"""Ours and Jeffery's, as the results name them."""

BASE = 0
"""The case that the sweeps start from comes first."""

BEHIND: dict[str, Any] = {"color": JEFFERY, "linewidth": 2.0, "zorder": 2}
FRONT: dict[str, Any] = {"color": OURS, "linewidth": 0.9, "zorder": 3}
"""Jeffery's line is wide and ours narrow, so that both are seen where they coincide."""


def _both(results: xr.Dataset) -> tuple[Turn, Turn]:
    """Return our turn and Jeffery's of the base case."""
    return read_turn(results, BASE, MODELS[0]), read_turn(results, BASE, MODELS[1])


def _panels(results: xr.Dataset) -> tuple[Figure, Axes, Axes]:
    """Return two panels over one time scale."""
    ours, jeffery = _both(results)
    figure = new_figure(COLUMN, 96)
    upper, lower = (add_axes(figure, 13, bottom, 74, 35) for bottom in (54, 10))
    for axes in (upper, lower):
        axes.set_xlim(0.0, max(ours.time[-1], jeffery.time[-1]))
    upper.set_xticklabels([])
    lower.set_xlabel("time [s]")
    return figure, upper, lower


def _key(results: xr.Dataset) -> list[Line2D]:
    size = float(results["orbit_domain_size"])
    return [
        Line2D([], [], color=OURS, linewidth=0.9, label=f"cell, M = {size:g}"),
        Line2D([], [], color=JEFFERY, linewidth=2.0, label="Jeffery, unbounded"),
    ]


def motion_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    ours, jeffery = _both(results)
    if np.isnan(ours.period):
        told = (
            "Two panels of curves over time. The unbounded fiber falls by half a turn twice; the "
            f"one in its cell comes to rest at {ours.angle[-1]:.1f}° to the flow."
        )
    else:
        fastest = [float(np.abs(turn.spin).max()) for turn in (ours, jeffery)]
        told = (
            "Two panels of curves over time, one line for the cell and one unbounded. The angle "
            "stays near the flow's direction most of the time and falls by half a turn twice; the "
            f"spin reaches {fastest[0]:.3f} 1/s in the cell and {fastest[1]:.3f} 1/s unbounded, "
            "clockwise."
        )
    return Words(
        caption=(
            f"One turn of a fiber in simple shear, {_base(results)}: (a) its angle from the flow "
            f"and (b) its spin. Orange: in {cell_name(results)}. Blue: Jeffery's closed form in an "
            f"unbounded melt. Full turn: {_period(ours)} in the cell, {_period(jeffery)} unbounded."
        ),
        alt=told,
    )


@plate(
    "orbit-motion",
    "A fiber's turn in simple shear",
    section="shear",
    words=motion_words,
    needs="orbit_period",
    paper="Fig. 8",
)
def figure_motion(results: xr.Dataset) -> Figure:
    """Draw angle and spin over one turn."""
    figure, upper, lower = _panels(results)
    for turn, look in zip(_both(results), (FRONT, BEHIND), strict=True):
        upper.plot(turn.time, turn.angle, **look)
        lower.plot(turn.time, turn.spin, **look)
    for axes in (upper, lower):
        plain(axes)
    upper.yaxis.set_major_locator(MultipleLocator(90.0))
    upper.set_ylabel(r"angle $\theta$ from the flow [°]")
    lower.set_ylabel(r"spin $\dot\theta$ [1/s]")
    letter(upper, "a")
    letter(lower, "b")
    _legend(upper, _key(results))
    return figure


def _legend(axes: Axes, handles: list[Line2D]) -> None:
    axes.legend(
        handles=handles,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.02),
        ncols=2,
        columnspacing=1.4,
    )


def pressures_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    found = results.isel(case=BASE)
    lowest = [KPA * float(found["orbit_lowest"].sel(orbit_model=m)) for m in MODELS]
    angle = np.degrees(float(found["orbit_angle_at_lowest"].sel(orbit_model=MODELS[0])))
    return Words(
        caption=(
            f"Pressure on a fiber over one turn in simple shear, {_base(results)}, less the far "
            "field's: (a) highest (continuous) and lowest (dashed) over the surface, (b) at the "
            f"tips. Orange: in {cell_name(results)}. Blue: Jeffery's, unbounded. Lowest over "
            f"every orientation: {lowest[0]:.2f} kPa in the cell and {lowest[1]:.2f} kPa "
            f"unbounded, with the fiber at {angle:.0f}° to the flow, from where it turns into the "
            "flow's direction."
        ),
        alt=(
            "Two panels of curves over time. Each time a fiber flips, first the highest pressure "
            "peaks and then the lowest dips; at the tips the pressure rises and then falls. Over "
            f"every orientation the lowest is {lowest[0]:.1f} kPa in the cell, {lowest[1]:.1f} kPa "
            "unbounded."
        ),
    )


@plate(
    "orbit-pressure",
    "Pressure over a turn",
    section="shear",
    words=pressures_words,
    needs="orbit_period",
    paper="Fig. 9",
)
def figure_pressures(results: xr.Dataset) -> Figure:
    """Draw highest and lowest surface pressure, and that at the tips, over one turn."""
    figure, upper, lower = _panels(results)
    for turn, look in zip(_both(results), (FRONT, BEHIND), strict=True):
        upper.plot(turn.time, turn.highest, **look)
        upper.plot(turn.time, turn.lowest, linestyle=(0, (3, 1.5)), dash_capstyle="butt", **look)
        lower.plot(turn.time, turn.tip, **look)
    for axes in (upper, lower):
        plain(axes)
    upper.set_ylabel(r"$p - p_\infty$ over the surface [kPa]")
    lower.set_ylabel(r"$p - p_\infty$ at the tips [kPa]")
    letter(upper, "a")
    letter(lower, "b")
    _legend(upper, _key(results))
    return figure


def _base(results: xr.Dataset) -> str:
    """Return the base case in words."""
    ratio, rate, viscosity = (
        float(results[f"case_{name}"][BASE]) for name in ("aspect_ratio", "shear_rate", "viscosity")
    )
    return f"aspect ratio {ratio:g}, shear rate {rate:g} 1/s, viscosity {viscosity:g} Pa s"


def _period(turn: Turn) -> str:
    return "it comes to rest" if np.isnan(turn.period) else f"{turn.period:.2f} s"
