"""Sections on fibers in the bead: their figures, and the numbers of flow and fibers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.engine.quantities import Quantity, with_error
from fibermelt.parts.bead.quantities import QUANTITIES as FIBER
from fibermelt.parts.flow.quantities import QUANTITIES as FLOW
from fibermelt.report.kit.sections import Section, section
from fibermelt.report.kit.tables import QUANTITY, Column, Table, measured, number, printed, sized
from fibermelt.units import MPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FIBERS", "numbers"]

FIBERS = Section(
    "fibers", "Fibers along the streamlines", place=40, of_paths="Fibers along the paths"
)

CELL = ("aspect_ratio", "domain_size", "shape_factor", "stall_angle", "tip_pressure")
"""What is told of the fiber."""


@section("numbers", "Numbers", place=100, needs="flow")
def numbers(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of fibers in the bead, with their units and error estimates."""
    flow = [one for name, one in FLOW.items() if name in summary["flow"]]
    fiber = [FIBER[name] for name in CELL]
    unknowns = [FIBER["cell_unknowns"]] if summary["cell"]["unknowns"] else []
    in_its_melt = _in_its_melt(summary["cell"])
    rows = [*_rows(results, fiber), *in_its_melt, *_rows(results, unknowns)]
    locations = sorted({item["location"] for item in summary["extremes"]})
    return {
        "flow": Table("The flow, ± estimated error", QUANTITY, _rows(results, flow)),
        "fiber": Table("The fiber, ± estimated error", QUANTITY, rows),
        "meanings": [(one.title, one.meaning) for one in (*flow, *fiber, *unknowns)],
        "lowest": _lowest(summary, locations),
        "is_divided": any(locations),
    }


def _rows(results: xr.Dataset, quantities: Iterable[Quantity]) -> list[tuple[str, str, str]]:
    """Return quantities of the results as rows: title, value ± error, unit."""
    rows = []
    for one in quantities:
        value, error = with_error(results, one.name, FLOW | FIBER)
        unit = "" if math.isnan(value) else one.shown_unit
        rows.append((one.title, printed(one.written(value, error)), unit))
    return rows


def _in_its_melt(cell: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return what a fiber answers in a melt that thins; what is beside it is of a Newtonian one."""
    if "thinning" not in cell:
        return []
    known = cell["thinning"]
    ends = [
        "at any rate" if known["rates"][0] == known["rates"][1] else f"{side} {number(rate, 2)} 1/s"
        for side, rate in zip(("up to", "from"), known["rates"], strict=True)
    ]
    rows = []
    error = known["error_estimate"]
    for end, factor, largest in zip(
        ends, known["shape_factors"], known["largest_pressures"], strict=True
    ):
        rows += [
            (f"As the melt thins, {end}: shape factor", measured(factor, error["spin"]), ""),
            (
                f"As the melt thins, {end}: largest surface pressure in simple shear",
                measured(largest, largest * error["pressure"]),
                "viscosity there × shear rate",
            ),
        ]
    return rows[:2] if len(set(ends)) == 1 else rows


def _lowest(summary: Mapping[str, Any], locations: Sequence[int]) -> Table:
    """Return the lowest surface pressures by streamline and location."""
    found = {
        (item["streamline"], item["location"]): item
        for item in summary["extremes"]
        if item["kind"] == "min"
    }
    word = "streamline" if "bead_height" in summary["flow"] else "path"
    columns = [Column(word.capitalize(), is_text=True), Column("Transit", "s")]
    for location in locations:
        columns += [Column(f"Loc. {location}, {what}", "MPa") for what in ("mean", "worst")]
    rows = []
    # Not by what is met near a singular corner, which has no limit.
    size = max(
        (
            abs(end)
            for line in summary["streamlines"]
            for location in locations
            for end in found[line["index"], location]["bounds"]
            if not line["near_singularity"]
        ),
        default=max(abs(item["mean"]) for item in found.values()),
    )
    for line in summary["streamlines"]:
        name = str(line["index"]) + ("*" if line["near_singularity"] else "")
        cells = [name, number(line["transit_time"], 3)]
        for location in locations:
            item = found[line["index"], location]
            cells += [
                sized(MPA * pressure, MPA * size, 4)
                for pressure in (item["mean"], min(item["bounds"]))
            ]
        rows.append(cells)
    return Table(f"Lowest pressure by {word}", columns, rows)
