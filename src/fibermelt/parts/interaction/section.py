"""The section on the paper's section 2.5: from content to the cell."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import QUANTITY, Column, Table, fixed, number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["content"]


@section("content", "From content to the cell", place=30, needs="interaction")
def content(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return content, interaction, preferred angle and size of the cell."""
    found = summary["interaction"]
    angle = found["preferred_angle"]
    rows = [
        ("Regime of concentration", found["regime"], ""),
        ("Interaction coefficient C_I", number(found["interaction"]), ""),
        (
            "Preferred angle to the flow",
            f"{number(angle)} ({math.degrees(angle):.2f}°)",
            "rad",
        ),
        ("Domain size M in which a fiber stalls at it", number(found["domain_size"]), ""),
        ("Largest M in which a fiber stalls", number(found["largest_stalling_domain"]), ""),
        ("Error of the shape factor between the cells", number(found["shape_factor_error"], 2), ""),
    ]
    return {
        "chain": Table("The study’s content", QUANTITY, rows),
        "polynomials": _polynomials(found),
        "curves": _curves(results),
    }


def _polynomials(found: Mapping[str, Any]) -> Table:
    """Return how far the paper's Eq. 32-34 are from the computed curves."""
    conventions = list(found["difference_from_eq_33"])
    columns = (
        Column("The paper’s polynomial", is_text=True),
        *(Column(f"Off by, {name} convention") for name in conventions),
        Column("Unit", is_text=True),
    )
    # No rate of deformation is in Eq. 32: it is the same by any convention.
    stall = number(found["difference_from_eq_32"])
    rows = [("Eq. 32, stall angle from M", *(stall for _ in conventions), "rad")]
    for equation, what, unit in ((33, "preferred angle from C_I", "rad"), (34, "M from C_I", "")):
        by = found[f"difference_from_eq_{equation}"]
        rows.append((f"Eq. {equation}, {what}", *(number(by[c]) for c in conventions), unit))
    return Table("Largest difference from the computed curves", columns, rows)


def _curves(results: xr.Dataset) -> Table:
    """Return preferred angle and domain size against the coefficient, by convention."""
    closure = str(results["interaction_closure"].item())
    known = [str(one) for one in results["closure"].to_numpy()]
    columns = [Column("C_I")]
    values = [[number(v) for v in results["interaction"].to_numpy()]]
    for name in map(str, results["convention"].to_numpy()):
        if closure in known:
            angle = results["interaction_angle"].sel(convention=name, closure=closure)
            columns.append(Column(f"Angle, {name}", "°"))
            values.append([fixed(v, 2) for v in np.degrees(angle.to_numpy())])
        columns.append(Column(f"M, {name}"))
        size = results["interaction_domain_size"].sel(convention=name)
        values.append([fixed(v, 3) for v in size.to_numpy()])
    caption = f"Preferred angle and domain size by convention, closure {closure}"
    return Table(caption, columns, list(zip(*values, strict=True)))
