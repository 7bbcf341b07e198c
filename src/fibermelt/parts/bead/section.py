"""Sections on fibers in the bead: their figures, and the numbers of flow and fibers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.report.kit.scene import MM, MPA
from fibermelt.report.kit.sections import Section, section
from fibermelt.report.kit.tables import QUANTITY, Column, Table, measured, number, sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FIBERS", "FLOW", "numbers"]

FIBERS = Section(
    "fibers", "Fibers along the streamlines", place=40, of_paths="Fibers along the paths"
)

FLOW = (
    ("Bead height", "bead_height", MM, "mm"),
    ("Inlet pressure", "inlet_pressure", MPA, "MPa"),
    ("Contact point, from the nozzle's axis", "contact_point", MM, "mm"),
    ("Heel, the melt's foremost point upstream", "heel", MM, "mm"),
    ("Flux error at the outlet, of the inlet's flux", "mass_imbalance", 1.0, ""),
    ("Flow through the free surface, in bed speeds", "kinematic_residual", 1.0, ""),
    ("Newton steps, all meshes together", "newton_steps", 1, ""),
    ("Unknowns of the flow", "unknowns", 1, ""),
    ("Triangles of the mesh", "elements", 1, ""),
)
"""What is told of the flow: words, name in the summary, factor and unit on the page."""


@section("numbers", "Numbers", place=100, needs="flow")
def numbers(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of fibers in the bead, with their units and error estimates."""
    flow = [
        (words, _with_error(results, name, summary["flow"][name], factor), unit)
        for words, name, factor, unit in FLOW
        if name in summary["flow"]
    ]
    locations = sorted({item["location"] for item in summary["extremes"]})
    return {
        "flow": Table("The flow, ± estimated error", QUANTITY, flow),
        "fiber": Table("The fiber, ± estimated error", QUANTITY, _fiber(summary["cell"])),
        "lowest": _lowest(summary, locations),
        "is_divided": any(locations),
    }


def _with_error(results: xr.Dataset, name: str, value: float, factor: float) -> str:
    if isinstance(value, int):
        return number(value)
    error = results.get(f"{name}_error")
    return measured(factor * value, math.nan if error is None else factor * float(error))


def _fiber(cell: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    error = cell.get("error_estimate") or {}
    stall = cell["stall_angle"]
    tip = cell["tip_pressure"]
    size = cell["domain_size"]
    return [
        ("Aspect ratio", number(cell["aspect_ratio"]), ""),
        ("Domain-size factor M", "unbounded" if size is None else number(size), ""),
        ("Shape factor B", _estimated(cell["shape_factor"], error.get("shape_factor")), ""),
        (
            "Angle to simple shear at which it stalls",
            "it tumbles" if stall is None else number(math.degrees(stall)),
            "" if stall is None else "°",
        ),
        (
            "Largest surface pressure in simple shear",
            _estimated(
                tip, None if error.get("tip_pressure") is None else tip * error["tip_pressure"]
            ),
            "viscosity × shear rate",
        ),
        *_in_its_melt(cell),
        (
            "Unknowns of the cell",
            number(cell["unknowns"]) if cell["unknowns"] else "closed form",
            "",
        ),
    ]


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


def _estimated(value: float, error: float | None) -> str:
    return number(value) if error is None else measured(value, error)


def _lowest(summary: Mapping[str, Any], locations: Sequence[int]) -> Table:
    """Return the lowest surface pressures by streamline, above mid-capillary and below it."""
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
