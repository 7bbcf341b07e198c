"""What would keep a melt free of voids, in a sentence: the same one wherever it is told."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import ROUND_DOWN, Context
from typing import Any

from fibermelt.units import PERCENT
from fibermelt.voids.constants import ATMOSPHERE

__all__ = ["advice"]

DIGITS = 2
"""Significant digits of what is advised."""

ROUNDING_DIGITS = 12
"""Digits of a share that are no rounding: 0.12 is 12 %, not 11, wherever its last bit went."""


def advice(found: Mapping[str, Any]) -> str:
    """Return what would keep the melt free of voids, in a sentence.

    The creeping flow of a power law has all pressures over the air's go with the speeds' ``n``-th
    power, ``n`` = 1 of a Newtonian melt: by ``(p_air / (p_air - P_L))^(1/n)`` of them the lowest
    absolute pressure ``P_L`` < 0 is zero. Other melts have no such share. A flow without a profile
    was not solved here, and has other speeds than those of inlet and bed.

    Parameters
    ----------
    found : mapping
        What summary.json has under ``"voids"``.
    """
    if found["lowest_pressure"] is None:
        word = "streamline" if found["profile"] else "path"
        return f"Not told: every {word} passes a singular corner; follow more of them."
    critical, lowest = _worst_fiber(found)
    if critical is None:
        return "Nothing: no moisture that the polymer can hold starts a void."
    if critical > 0:
        below = f"below {_percent(critical)} moisture no void starts on any fiber"
        if found["moisture"] < critical:
            return f"Keep it this dry: {below}."
        return f"Dry the material: {below}."
    speeds = "both speeds" if found["profile"] else "all speeds of the flow"
    tension = (
        "at fibers in their worst direction the melt is under tension, which no drying helps, "
        f"until {speeds} are {_slower(lowest, found['speed_exponent'])}"
    )
    alone = found["by_basis"]["melt"]["critical_moisture"]
    if not alone or found["moisture"] < alone:
        return f"Slow down: {tension}."
    return (
        f"Dry below {_percent(alone)}, so that the melt between the fibers cannot boil, and slow "
        f"down: {tension}."
    )


def _worst_fiber(found: Mapping[str, Any]) -> tuple[float | None, float]:
    """Return the lowest critical moisture of any fiber, None if none starts a void, and pressure.

    What is said of any fiber must hold for each that is told of beside it.
    """
    told = [found, *(one for basis, one in found["by_basis"].items() if basis == "spheroid")]
    critical = [one["critical_moisture"] for one in told if one["critical_moisture"] is not None]
    return min(critical, default=None), min(float(one["lowest_pressure"]) for one in told)


def _slower(lowest: float, exponent: float | None) -> str:
    """Return how slow is slow enough for a lowest pressure [Pa, absolute] below zero."""
    if exponent is None:
        return "low enough: how low, runs at other speeds tell, as this melt follows no power"
    share = (ATMOSPHERE / (ATMOSPHERE - lowest)) ** (1.0 / exponent)
    return f"below {_percent(share)} of these"


def _percent(share: float) -> str:
    """Return a share in percent with two significant digits, the zeros among them.

    Rounded down: what is told to stay below must not lie above the bound itself.
    """
    exact = Context(prec=ROUNDING_DIGITS).create_decimal_from_float(PERCENT * share)
    return (
        f"{float(Context(prec=DIGITS, rounding=ROUND_DOWN).plus(exact)):#.2g}".removesuffix(".")
        + " %"
    )
