"""Sections on single fibers: in simple shear, and in two dimensions against three."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.report.kit.tables import Column, fixed, number, percent, short, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["dimensions", "shear"]

KPA, MPA = 1e-3, 1e-6
"""From pascals."""

VARIED = {
    "aspect_ratio": ("Aspect ratio", ""),
    "shear_rate": ("Shear rate", "1/s"),
    "viscosity": ("Viscosity", "Pa s"),
}
"""What the sweeps vary: words and unit."""

MODELS = {name: SHAPES[name].label for name in ("confined-ellipse", "ellipse", "spheroid")}
"""What the models are called in a table's head."""


def shear(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return what the cell is, Table 1 of the paper with ours beside it, and the extremes."""
    del results
    found = summary["orbits"]
    base, size = found["cases"][0], short(found["domain_size"])
    words = Markup(
        "<p>A fiber of aspect ratio {} lies in a shear of {} 1/s and a melt of {} Pa s, and turns. "
        "The melt around it is cut off by a circle, the fiber’s cell, whose edge moves as the "
        "undisturbed flow does. Its radius is M/2 half-lengths of the fiber: here M = {}, {}. "
        "Jeffery’s fiber lies in an unbounded melt.</p>\n"
    ).format(*(short(base[name]) for name in VARIED), size, _felt(base))
    tables = [_periods(found["periods"], sweep, size) for sweep in VARIED]
    return words + Markup().join(tables) + _pressures(found["cases"], size)


def _felt(base: Mapping[str, Any]) -> str:
    """Return how much a fiber feels its cell."""
    ours, free = base["confined-ellipse"]["period"], base["ellipse"]["period"]
    if ours is None:
        return "so near that the fiber stalls in it"
    return f"in which a turn takes {percent(ours / free, 1)} % of the time that Jeffery’s takes"


def _periods(periods: Sequence[Mapping[str, Any]], sweep: str, size: str) -> Markup:
    """Return the lines of Table 1 of a sweep; nothing if it has none."""
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
    if not rows:
        return Markup()
    what, unit = VARIED[sweep]
    columns = (
        Column(what, unit),
        Column("Jeffery", "s"),
        Column(f"Here, M = {size}", "s"),
        Column("above Jeffery", "%"),
        Column("The paper’s finite elements", "s"),
        Column("above Jeffery", "%"),
    )
    return table(f"Time of a full turn by {what.lower()} (the paper’s Table 1)", columns, rows)


def _pressures(cases: Sequence[Mapping[str, Any]], size: str) -> Markup:
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
    return table(caption, columns, rows)


def _degrees(angle: float | None) -> str:
    return "–" if angle is None else fixed(math.degrees(angle), 1)


def dimensions(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return what the plane ellipse costs: peaks in shear, and lows along the streamlines."""
    del results
    found = summary["dimensions"]
    size = short(found["domain_size"])
    words = Markup(
        "<p>The paper’s fiber is an ellipse, which stands for a cylinder across the plane of the "
        "flow. A fiber is nearer to a spheroid: long in one direction only. Both are met here "
        "without a cell in closed form; the ellipse in its cell of M = {} beside them.</p>\n"
    ).format(size)
    return words + _peaks(found["peaks"]) + _along(found["streamlines"])


def _peaks(peaks: Sequence[Mapping[str, Any]]) -> Markup:
    if not peaks:
        return Markup()
    columns = (
        Column("Aspect ratio"),
        *(Column(words.capitalize()) for words in MODELS.values()),
        Column("Spheroid over unbounded ellipse"),
    )
    rows = [
        (
            short(row["aspect_ratio"]),
            *(short(row[model], 4) for model in MODELS),
            number(row["spheroid_over_ellipse"]),
        )
        for row in peaks
    ]
    return table("Highest pressure in simple shear over viscosity × shear rate", columns, rows)


def _along(lows: Sequence[Mapping[str, Any]]) -> Markup:
    """Return the lowest pressures along the marked streamlines, model by model."""
    by_place: dict[tuple[int, int], dict[str, Mapping[str, Any]]] = {}
    for low in lows:
        by_place.setdefault((low["streamline"], low["location"]), {})[low["model"]] = low
    if not by_place:
        return Markup()
    columns = [Column("Streamline", is_text=True), Column("Location", is_text=True)]
    for words in MODELS.values():
        columns += [
            Column(f"{words.capitalize()}: lowest", "MPa"),
            Column("any direction", "MPa"),
        ]
    rows = [
        (
            str(streamline),
            str(location),
            *(
                fixed(MPA * found[model][value], 3)
                for model in MODELS
                for value in ("lowest", "bound")
            ),
        )
        for (streamline, location), found in by_place.items()
    ]
    note = Markup(
        "<p>Location 1 lies above the middle of the capillary, 2 below it. Lowest over the "
        "initial angles in the plane, and over every direction that a fiber can have.</p>\n"
    )
    caption = "Lowest surface pressure along streamlines, less the melt’s own"
    return table(caption, columns, rows) + note
