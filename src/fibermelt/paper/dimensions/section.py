"""The section on two dimensions against three."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.parts.bead.beside import MODELS as MODELS_BESIDE
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.report.kit.scene import MPA
from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table, fixed, number, short

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["dimensions"]

MODELS = {name: SHAPES[name].label for name in MODELS_BESIDE}
"""What the models are called in a table's head."""


@section("two-and-three", "Two dimensions against three", place=50, needs="dimensions")
def dimensions(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the plane ellipse costs: peaks in shear, and lows along the streamlines."""
    del results
    found = summary["dimensions"]
    return {
        "size": short(found["domain_size"]),
        "peaks": _peaks(found["peaks"]),
        "along": _along(found["streamlines"]),
    }


def _peaks(peaks: Sequence[Mapping[str, Any]]) -> Table:
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
    return Table("Highest pressure in simple shear over viscosity × shear rate", columns, rows)


def _along(lows: Sequence[Mapping[str, Any]]) -> Table:
    """Return the lowest pressures along the marked streamlines, model by model."""
    by_place: dict[tuple[int, int], dict[str, Mapping[str, Any]]] = {}
    for low in lows:
        by_place.setdefault((low["streamline"], low["location"]), {})[low["model"]] = low
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
    caption = "Lowest surface pressure along streamlines, less the melt’s own"
    return Table(caption, columns, rows)
