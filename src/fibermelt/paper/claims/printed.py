"""What the paper prints, from the data that ship with the package, each with its source."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

__all__ = ["PrintedPeriod", "printed_period", "printed_periods"]

SAME = 1e-9
"""Relative difference below which a study's parameter is the printed one: rounding of units."""


@dataclass(frozen=True)
class PrintedPeriod:
    """A line of the paper's Table 1, as printed to 0.01 s.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-].
    shear_rate : float
        ``gamma_dot`` [1/s].
    jeffery : float
        ``T_Jef`` [s], Jeffery's period (Eq. 24).
    finite_elements : float
        ``T_fea`` [s], that of the paper's finite elements.
    """

    aspect_ratio: float
    shear_rate: float
    jeffery: float
    finite_elements: float


@cache
def printed_periods() -> tuple[PrintedPeriod, ...]:
    """Return the paper's Table 1, line by line, the half over aspect ratios first."""
    text = files("fibermelt").joinpath("data", "table1.toml").read_text(encoding="utf-8")
    tables = tomllib.loads(text)
    by_ratio, by_rate = tables["aspect_ratio"], tables["shear_rate"]
    halves = (
        (by_ratio, by_ratio["aspect_ratios"], [by_ratio["shear_rate"]] * 5),
        (by_rate, [by_rate["aspect_ratio"]] * 5, by_rate["shear_rates"]),
    )
    return tuple(
        PrintedPeriod(float(ratio), float(rate), jeffery, elements)
        for half, ratios, rates in halves
        for ratio, rate, jeffery, elements in zip(
            ratios, rates, half["jeffery"], half["finite_elements"], strict=True
        )
    )


def printed_period(aspect_ratio: float, shear_rate: float) -> PrintedPeriod | None:
    """Return what Table 1 says of a fiber in simple shear, None if it says nothing.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-].
    shear_rate : float
        ``gamma_dot`` [1/s].
    """
    for line in printed_periods():
        if math.isclose(line.aspect_ratio, aspect_ratio, rel_tol=SAME) and math.isclose(
            line.shear_rate, shear_rate, rel_tol=SAME
        ):
            return line
    return None
