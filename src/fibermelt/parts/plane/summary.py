"""What summary.json and the terminal say of the slot beside a bead in space."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.quantities import or_none
from fibermelt.parts.flow.quantities import QUANTITIES as FLOW
from fibermelt.parts.plane.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["COMPARED", "plane_in_words", "summarize_plane"]

COMPARED = {
    "bead_height": "bead_height",
    "heel": "heel",
    "inlet_pressure": "inlet_pressure",
    "lowest_pressure": "space_lowest_pressure",
    "exponent": "space_exponent",
}
"""What is compared, and where the bead in space has it."""


def summarize_plane(results: xr.Dataset) -> dict[str, Any]:
    """Return what the slot gets right, in SI.

    Returns
    -------
    dict
        Under ``"plane"`` the ``slot``'s width and of each of `COMPARED` ``space``, ``plane``,
        ``ratio`` (plane over space), and ``space_error``, ``plane_error``; None where there is
        none. Pressures are above the air's.
    """

    def number(name: str) -> float | None:
        return or_none(results[name]) if name in results else None

    rows = {}
    for name, there in COMPARED.items():
        space, plane = number(there), number(f"plane_{name}")
        rows[name] = {
            "space": space,
            "space_error": number(f"{there}_error"),
            "plane": plane,
            "plane_error": number(f"plane_{name}_error"),
            "ratio": plane / space if plane is not None and space else None,
        }
    return {"plane": {"slot": float(results["plane_slot"]), **rows}}


def plane_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what the slot gets right as a few lines for a person."""
    told = summary["plane"]
    parts = []
    for name in COMPARED:
        one, row = (FLOW | QUANTITIES)[f"plane_{name}"], told[name]
        if row["plane"] is not None and row["space"] is not None:
            size = max(abs(row["plane"]), abs(row["space"]))
            plane, space = (one.with_unit(row[k], size=size, digits=3) for k in ("plane", "space"))
            parts.append(f"{one.title.lower()} {plane} for {space}")
    width = QUANTITIES["plane_slot"].with_unit(told["slot"], size=told["slot"], digits=4)
    return [f"in the plane    a slot of {width} has {'; '.join(parts)}"]
