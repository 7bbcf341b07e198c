"""Sections on many fibers: from content to the cell, and orientation tensors in the bead."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from fibermelt.parts.flow.figures.lines import line_word
from fibermelt.parts.flow.imported import is_given
from fibermelt.parts.interaction.models import model_in_words
from fibermelt.parts.orientation.summary import stored_model
from fibermelt.report.kit.tables import Column, fixed, folded, number, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["content", "orientation"]

QUANTITY = (Column("Quantity", is_text=True), Column("Value"), Column("Unit", is_text=True))


def content(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the paper's section 2.5: content, interaction, preferred angle, size of the cell."""
    found = summary["interaction"]
    words = Markup(
        "<p>Other fibers keep a fiber from tumbling. The paper has a cell do it instead: from the "
        "fiber content follows an interaction coefficient, from that the angle at which most "
        "fibers lie in simple shear, by Folgar and Tucker’s model, and the cell is chosen so that "
        "a single fiber stalls at that angle.</p>\n"
    )
    angle = math.degrees(found["preferred_angle"])
    rows = [
        ("Regime of concentration", found["regime"], ""),
        ("Interaction coefficient C_I", number(found["interaction"]), ""),
        (
            "Preferred angle to the flow",
            f"{number(found['preferred_angle'])} ({angle:.2f}°)",
            "rad",
        ),
        ("Domain size M in which a fiber stalls at it", number(found["domain_size"]), ""),
        ("Largest M in which a fiber stalls", number(found["largest_stalling_domain"]), ""),
        ("Error of the shape factor between the cells", number(found["shape_factor_error"], 2), ""),
    ]
    chain = table("The study’s content", QUANTITY, rows)
    return words + chain + _polynomials(found) + _curves(results)


def _polynomials(found: Mapping[str, Any]) -> Markup:
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
    note = Markup(
        "<p>The coefficient multiplies a rate of deformation: sqrt(2 D:D) in the standard "
        "convention, sqrt(2) times that in the one that the paper’s Eq. 33 follows.</p>\n"
    )
    return table("Largest difference from the computed curves", columns, rows) + note


def _curves(results: xr.Dataset) -> Markup:
    """Return preferred angle and domain size against the coefficient, by convention, folded."""
    closure = str(results["interaction_closure"].item())
    known = [str(one) for one in results["closure"].to_numpy()]
    conventions = [str(one) for one in results["convention"].to_numpy()]
    columns = [Column("C_I")]
    values = []
    for name in conventions:
        if closure in known:
            angle = results["interaction_angle"].sel(convention=name, closure=closure)
            columns.append(Column(f"Angle, {name}", "°"))
            values.append([fixed(v, 2) for v in np.degrees(angle.to_numpy())])
        columns.append(Column(f"M, {name}"))
        size = results["interaction_domain_size"].sel(convention=name)
        values.append([fixed(v, 3) for v in size.to_numpy()])
    heads = [number(v) for v in results["interaction"].to_numpy()]
    rows = zip(heads, *values, strict=True)
    caption = f"Preferred angle and domain size by convention, closure {closure}"
    return folded(caption, table(caption, columns, rows))


def orientation(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the orientation tensor in the bead, or where paths end, and the closure's error."""
    found, word = summary["orientation_tensor"], line_word(results)
    axis, end, outlet = "the bead", "in the bead", "at the outlet"
    if is_given(results):
        axis, end, outlet = "the x axis", "where it ends", "where paths end"
    words = Markup(
        "<p>A tensor tells how fibers lie on average: a_xx is 1 where all lie along {} and "
        "1/3 where they lie every way. The model is {}, the closure {}. {} The integration is off "
        "by {} at most, an estimate. {}</p>\n"
    ).format(
        axis,
        model_in_words(*stored_model(results)),
        str(results["orientation_closure"].item()),
        _judged(found["closure_error"], word, end),
        number(found["error"], 2),
        f"Eigenvalues leave 0 to 1 by up to {number(found['violation'], 2)}."
        if found["violation"] > 0
        else "Eigenvalues stay between 0 and 1.",
    )
    near = dict(
        zip(
            results["streamline"].to_numpy().tolist(),
            results["near_singularity"].to_numpy().astype(bool).tolist(),
            strict=True,
        )
    )
    columns = (
        Column(word.capitalize(), is_text=True),
        *(Column(name) for name in ("a_xx", "a_yy", "a_zz", "a_xy")),
        Column(f"Mean direction to {'the x axis' if is_given(results) else 'the bed'}", "°"),
    )
    rows = [
        (
            f"{one['streamline']}{'*' if near[one['streamline']] else ''}",
            *(fixed(one["a"][i][j], 3) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1))),
            fixed(_direction(one["a"]), 1),
        )
        for one in found["in_the_bead"]
    ]
    note = Markup("<p>* passes close to a singular corner.</p>\n") if any(near.values()) else ""
    return words + table(f"Orientation tensor {outlet} by {word}", columns, rows) + note


def _judged(closure: Mapping[str, Any] | None, word: str, end: str) -> str:
    """Return how far the closure is off, or that nothing tells."""
    if closure is None:
        return (
            "What the closure costs is not told: the distribution itself is known for "
            "Folgar-Tucker only."
        )
    return (
        f"Against the distribution itself on {word} {closure['streamline']} the closure is off "
        f"by up to {fixed(closure['largest'], 3)}, and by {fixed(closure['in_the_bead'], 3)} {end}."
    )


def _direction(a: Any) -> float:
    """Return the angle of the principal axis in the plane of the flow [deg]."""
    return math.degrees(0.5 * math.atan2(2.0 * a[0][1], a[0][0] - a[1][1]))
