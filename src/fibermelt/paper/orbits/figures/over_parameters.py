"""Pressure over half a turn for aspect ratios, shear rates, viscosities (Fig. 10, 12, 13)."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fibermelt.paper.orbits.figures.turns import (
    KPA,
    angle_scale,
    cell_name,
    half_turn,
    plain,
    read_turn,
    swept,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import COLUMN, INK, Words, add_axes, new_figure

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["BY_ASPECT_RATIO", "BY_SHEAR_RATE", "BY_VISCOSITY"]

NAMES = {
    "aspect_ratio": ("aspect ratio", ""),
    "shear_rate": ("shear rate", " 1/s"),
    "viscosity": ("viscosity", " Pa s"),
}
"""What is swept, in words, and its unit."""

JEFFERY_LOOK: dict[str, Any] = {"color": INK, "linewidth": 0.5, "linestyle": (0, (3, 3))}
"""Thin and dashed, on top of ours."""

PER_ROW = 3
"""Entries of the legend side by side."""

LINE = 4.0
"""Height of a line of the legend [mm]."""


def _draw(results: xr.Dataset, sweep: str) -> Figure:
    """Draw highest and lowest surface pressure over half a turn, against the angle."""
    lines = swept(results, sweep)
    key = LINE * math.ceil((len(lines) + 1) / PER_ROW) + 2
    figure = new_figure(COLUMN, 68 + key)
    axes = add_axes(figure, 13, 10, 74, 56)
    for case, _, color in lines:
        ours: dict[str, Any] = {"color": color, "linewidth": 1.6}
        for model, look in (("confined-ellipse", ours), ("ellipse", JEFFERY_LOOK)):
            angle, lowest, highest = half_turn(read_turn(results, case, model))
            for values in (lowest, highest):
                axes.plot(angle, values, **look)
    plain(axes)
    angle_scale(axes, -90.0, 90.0, 45.0)
    axes.set_xlabel(r"angle $\theta$ from the flow [°]")
    axes.set_ylabel(r"$p - p_\infty$ over the surface [kPa]")
    handles = [Line2D([], [], color=c, linewidth=1.6, label=name) for _, name, c in lines]
    handles.append(Line2D([], [], label="Jeffery", **JEFFERY_LOOK))
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.02),
        ncols=PER_ROW,
        columnspacing=1.4,
    )
    return figure


def _words(results: xr.Dataset, sweep: str) -> Words:
    """Return caption and alternative text."""
    name, unit = NAMES[sweep]
    found = []
    for case, _, _ in swept(results, sweep):
        value = float(results[f"case_{sweep}"][case])
        one = results.isel(case=case).sel(orbit_model="confined-ellipse")
        found.append((value, KPA * float(one["orbit_lowest"]), float(one["orbit_period"])))
    lows = ", ".join(f"{low:.2f} kPa at {value:g}{unit}" for value, low, _ in found)
    periods = ", ".join("none" if np.isnan(period) else f"{period:.2f} s" for _, _, period in found)
    return Words(
        caption=(
            f"Highest (above zero) and lowest (below zero) pressure on the surface of a fiber "
            f"in simple shear, less the far field's, by {name}: {_fixed(results, sweep)}. The "
            "fiber turns clockwise, from right to left; the other half of the turn is the "
            f"same. Coloured: in {cell_name(results)}. Dashed, on top: Jeffery's, unbounded. "
            f"Full turns in the cell, in the order of the key: {periods}."
        ),
        alt=(
            f"Curves over the fiber's angle from -90 to 90 degrees, a pair for each {name}, "
            "mirrored at zero pressure. The lowest pressure in the cell over the turn: "
            f"{lows}."
        ),
    )


def _fixed(results: xr.Dataset, sweep: str) -> str:
    """Return the parameters that stay, in words."""
    kept = [
        f"{name} {float(results[f'case_{other}'][0]):g}{unit}"
        for other, (name, unit) in NAMES.items()
        if other != sweep
    ]
    return " and ".join(kept)


BY_ASPECT_RATIO, BY_SHEAR_RATE, BY_VISCOSITY = (
    plate(
        f"orbit-{sweep.replace('_', '-')}",
        f"Pressure over half a turn by {name}",
        section="shear",
        words=partial(_words, sweep=sweep),
        needs="orbit_period",
        paper=paper,
    )(partial(_draw, sweep=sweep))
    for (sweep, (name, _)), paper in zip(
        NAMES.items(), ("Fig. 10", "Fig. 12", "Fig. 13"), strict=True
    )
)
