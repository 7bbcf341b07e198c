"""The section on single fibers in simple shear."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table, fixed, number, percent, short
from fibermelt.units import KPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["shear"]

VARIED = {
    "aspect_ratio": ("Aspect ratio", ""),
    "shear_rate": ("Shear rate", "1/s"),
    "viscosity": ("Viscosity", "Pa s"),
}
"""What the sweeps vary: words and unit."""


@section("shear", "One fiber in simple shear", place=20, needs="orbits")
def shear(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the cell is, Table 1 of the paper with ours beside it, and the extremes."""
    del results
    found = summary["orbits"]
    base, size = found["cases"][0], short(found["domain_size"])
    periods = (_periods(found["periods"], sweep, size) for sweep in VARIED)
    return {
        "base": base,
        "size": size,
        "felt": _felt(base),
        "tables": [*(one for one in periods if one.rows), _pressures(found["cases"], size)],
    }


def _felt(base: Mapping[str, Any]) -> str:
    """Return how much a fiber feels its cell."""
    ours, free = base["confined-ellipse"]["period"], base["ellipse"]["period"]
    if ours is None:
        return "so near that the fiber stalls in it"
    return f"in which a turn takes {percent(ours / free, 1)} % of the time that Jeffery’s takes"


def _periods(periods: Sequence[Mapping[str, Any]], sweep: str, size: str) -> Table:
    """Return the lines of Table 1 of a sweep."""
    rows = [
        (
            short(row[sweep]),
            fixed(row["jeffery"], 2),
            fixed(row["ours"], 2),
            percent(row["ours_above_jeffery"]),
            fixed(row["paper"], 2),
            percent(row["paper_above_jeffery"]),
        )
        for row in periods
        if row["sweep"] == sweep
    ]
    what, unit = VARIED[sweep]
    columns = (
        Column(what, unit),
        Column("Jeffery", "s"),
        Column(f"Here, M = {size}", "s"),
        Column("above Jeffery", "%"),
        Column("The paper’s finite elements", "s"),
        Column("above Jeffery", "%"),
    )
    return Table(f"Time of a full turn by {what.lower()} (the paper’s Table 1)", columns, rows)


def _pressures(cases: Sequence[Mapping[str, Any]], size: str) -> Table:
    """Return the lowest pressures of the cases, and where they are met."""
    columns = (
        *(Column(what, unit) for what, unit in VARIED.values()),
        Column(f"Lowest, M = {size}", "kPa"),
        Column("Lowest, unbounded", "kPa"),
        Column("Fiber to the flow then", "°"),
    )
    rows = [
        (
            *(short(case[name]) for name in VARIED),
            number(KPA * case["confined-ellipse"]["min_pressure"]),
            number(KPA * case["ellipse"]["min_pressure"]),
            _degrees(case["confined-ellipse"]["angle_at_min"]),
        )
        for case in cases
        if case["sweep"] in VARIED
    ]
    caption = "Lowest pressure on the fiber’s surface over a turn, less the far field’s"
    return Table(caption, columns, rows)


def _degrees(angle: float | None) -> str:
    return "–" if angle is None else fixed(math.degrees(angle), 1)
