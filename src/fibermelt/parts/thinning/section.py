"""The section on what thinning does: tables over the index of the power law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.parts.thinning.figures import CAUSES, MODELS, megapascals, models_of
from fibermelt.report.kit.scene import MM, MPA
from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table, fixed, measured, number, short

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["thinning"]


@section("thinning", "What thinning does", place=60, needs="thinning")
def thinning(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of the bead and of each model of a fiber."""
    del results
    laws = summary["thinning"]
    columns = (
        Column("Index"),
        Column("Viscosity at 1 1/s", "Pa s"),
        Column("Inlet pressure", "MPa"),
        Column("Contact point", "mm"),
    )
    rows = [
        (
            short(law["index"]),
            number(law["consistency"], 4),
            fixed(MPA * law["inlet_pressure"], 3),
            fixed(MM * law["contact_point"], 3),
        )
        for law in laws
    ]
    bead = Table("The bead with melts that thin", columns, rows)
    return {"tables": [bead, *(_of_fibers(laws, model) for model in models_of(laws))]}


def _of_fibers(laws: list[dict[str, Any]], model: str) -> Table:
    """Return the table of one model of a fiber."""
    columns = (
        Column("Index"),
        Column("Turn × rate"),
        Column("Peak over ηγ̇"),
        *(Column(f"Thins: {said}", "MPa") for said, _ in CAUSES.values()),
        Column("Any direction, both", "MPa"),
    )
    rows = [(short(law["index"]), *_cells(law[model])) for law in laws]
    name = MODELS[model][0].capitalize()
    return Table(f"{name}: in simple shear, and lowest below the nozzle", columns, rows)


def _cells(one: Mapping[str, Any]) -> list[str]:
    return [
        "stalls" if one["period"] is None else fixed(one["period"], 2),
        measured(one["peak"], one["peak_error"]) if one["peak_error"] else number(one["peak"], 4),
        *(megapascals(one[cause]["lowest"]) for cause in CAUSES),
        megapascals(one["both"]["bound"]),
    ]
