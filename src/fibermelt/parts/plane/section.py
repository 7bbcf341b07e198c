"""The section on the planar answer beside a bead in space: a table of both."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.parts.plane.quantities import QUANTITIES
from fibermelt.parts.plane.summary import COMPARED
from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table, number, printed

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["plane"]


@section("plane", "What the plane gets right", place=55, needs="plane")
def plane(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table of the bead in space and of the slot's."""
    del results
    found = summary["plane"]
    columns = (
        Column("Quantity", is_text=True),
        Column("In space"),
        Column("In the plane"),
        Column("Unit", is_text=True),
        Column("Plane over space"),
    )
    rows = []
    for name in COMPARED:
        one, row = QUANTITIES[f"plane_{name}"], found[name]
        size = max(abs(row[side] or 0.0) for side in ("space", "plane"))
        cells = [
            "–"
            if row[side] is None
            else printed(one.written(row[side], row[f"{side}_error"] or float("nan"), size=size))
            for side in ("space", "plane")
        ]
        ratio = "–" if row["ratio"] is None else number(row["ratio"], 3)
        rows.append((one.title, *cells, one.shown_unit, ratio))
    slot = QUANTITIES["plane_slot"]
    return {
        "table_of_both": Table("The bead in space, and the slot's in the plane", columns, rows),
        "slot": slot.with_unit(found["slot"], size=found["slot"], digits=4),
    }
