"""Turns of single fibers in simple shear as figures read them: cases, half turns, colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from fibermelt.report.kit.style import BAND, BLUE, INK, VERMILION, Array, shades
from fibermelt.units import KPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "JEFFERY",
    "KPA",
    "OURS",
    "Turn",
    "angle_scale",
    "cell_name",
    "half_turn",
    "plain",
    "read_turn",
    "swept",
]


OURS, JEFFERY = VERMILION, BLUE
"""Colours of the fiber in its cell and of the unbounded one, as in the paper's Fig. 8 and 9."""

SWEEPS = {
    "aspect_ratio": ("case_aspect_ratio", "$r_e$ = {}"),
    "shear_rate": ("case_shear_rate", r"$\dot\gamma$ = {} s$^{{-1}}$"),
    "viscosity": ("case_viscosity", r"$\mu$ = {} Pa s"),
}
"""The variable of each sweep, and how a line is named."""


@dataclass(frozen=True)
class Turn:
    """A fiber's turn, as drawn.

    Parameters
    ----------
    time : (n,) array
        Since the fiber lay along the flow [s].
    angle : (n,) array
        From the flow direction [deg], continuous.
    spin : (n,) array
        Rate of the angle [1/s].
    lowest, highest, tip : (n,) arrays
        Pressure over the surface and at the tips [kPa].
    period : float
        Time of a full turn [s], NaN if the fiber stalls.
    """

    time: Array
    angle: Array
    spin: Array
    lowest: Array
    highest: Array
    tip: Array
    period: float


def read_turn(results: xr.Dataset, case: int, model: str) -> Turn:
    """Return the turn of a case for "confined-ellipse" or "ellipse"."""
    found = results.isel(case=case).sel(orbit_model=model)
    low, high, tip = (KPA * found[f"turn_{n}"].to_numpy() for n in ("lowest", "highest", "tip"))
    return Turn(
        time=found["turn_time"].to_numpy(),
        angle=np.degrees(found["turn_angle"].to_numpy()),
        spin=found["turn_spin"].to_numpy(),
        lowest=low,
        highest=high,
        tip=tip,
        period=float(found["orbit_period"]),
    )


def half_turn(turn: Turn) -> tuple[Array, Array, Array]:
    """Return angles over [-90, 90] deg, in order, and the lowest and the highest pressure there.

    The second half of a turn repeats the first; of a fiber that stalls, what it passes.
    """
    if np.isnan(turn.period):
        order = np.argsort(turn.angle, kind="stable")
        return turn.angle[order], turn.lowest[order], turn.highest[order]
    # clockwise from 0: the angles -270 to -90 are the half turn 90 to -90
    here = np.flatnonzero((turn.angle <= -90.0) & (turn.angle >= -270.0))
    here = np.arange(here[-1] + 1, here[0] - 2, -1)  # one more at both ends
    return turn.angle[here] + 180.0, turn.lowest[here], turn.highest[here]


def swept(results: xr.Dataset, sweep: str) -> list[tuple[int, str, str]]:
    """Return case, name and colour of every line of a sweep, in the order of the values.

    Parameters
    ----------
    results : xarray.Dataset
        Results of the sensitivity studies.
    sweep : {"aspect_ratio", "shear_rate", "viscosity"}
        Which.
    """
    variable, name = SWEEPS[sweep]
    cases = np.flatnonzero(results["case_sweep"].to_numpy() == sweep)
    values = results[variable].to_numpy()[cases]
    order = cases[np.argsort(values, kind="stable")]
    return [
        (
            int(case),
            name.format(f"{float(results[variable][case]):g}"),
            shade,
        )
        for case, shade in zip(order, shades(len(order)), strict=True)
    ]


def angle_scale(axes: Axes, first: float, last: float, step: float) -> None:
    """Set the scale of an axis of angles [deg] along x."""
    axes.set_xlim(first, last)
    axes.xaxis.set_major_locator(MultipleLocator(step))


def plain(axes: Axes) -> None:
    """Add the zero line and quiet horizontal lines."""
    axes.grid(axis="y", color=BAND, linewidth=0.4)
    axes.axhline(0.0, color=INK, linewidth=0.6, zorder=1.5)


def cell_name(results: xr.Dataset) -> str:
    """Return what "ours" is, in words."""
    size = float(results["orbit_domain_size"])
    return f"a cell of M = {size:g} (a circle of {0.5 * size:g} half-lengths)"
