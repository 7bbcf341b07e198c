"""What summary.json says of orientation and of the size of the cell, as functions of results."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.parts.interaction.models import model_in_words

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "interaction_in_words",
    "orientation_in_words",
    "stored_model",
    "summarize_interaction",
    "summarize_orientation",
]


def summarize_interaction(results: xr.Dataset) -> dict[str, Any]:
    """Return what summary.json says of content and the size of the cell, in SI.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.

    Returns
    -------
    dict
        ``{"interaction": {...}}``: coefficient, preferred angle, domain size and regime of the
        study's content, the largest domain in which the fiber stalls, and how far the paper's
        Eq. 32, 33 and 34 are from the computed curves, 33 and 34 by convention.
    """
    conventions = [str(name) for name in results["convention"].to_numpy()]
    return {
        "interaction": {
            "interaction": float(results["interaction_coefficient"]),
            "preferred_angle": float(results["preferred_angle"]),
            "domain_size": float(results["content_domain_size"]),
            "regime": str(results["content_regime"].item()),
            "largest_stalling_domain": float(results["largest_stalling_domain"]),
            "shape_factor_error": float(results["stall_shape_factor_error"]),
            "difference_from_eq_32": float(results["stall_curve_difference"]),
            **{
                f"difference_from_eq_{equation}": dict(
                    zip(conventions, results[name].to_numpy().tolist(), strict=True)
                )
                for equation, name in (
                    (33, "interaction_angle_difference"),
                    (34, "interaction_domain_size_difference"),
                )
            },
        }
    }


def interaction_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what a summary says of content and the size of the cell, for a person."""
    found = summary["interaction"]
    angle = math.degrees(found["preferred_angle"])
    by = {k: found[f"difference_from_eq_{k}"] for k in (33, 34)}
    return [
        f"content         C_I = {found['interaction']:.4f} ({found['regime']}): preferred angle "
        f"{angle:.2f} deg, stalled there in a cell of M = {found['domain_size']:.3f}",
        f"stall           in cells up to M = {found['largest_stalling_domain']:.3f}; the paper's "
        f"Eq. 32 is off by up to {found['difference_from_eq_32']:.3f} rad",
        "paper's fits    "
        + "; ".join(
            f"{name} convention: Eq. 33 off by up to {by[33][name]:.3f} rad, Eq. 34 by "
            f"{by[34][name]:.2f}"
            for name in by[33]
        ),
    ]


def stored_model(results: xr.Dataset) -> tuple[str, float | None, dict[str, float]]:
    """Return the model that tensors follow: its name, ``C_I`` where it has one, and the rest.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.
    """
    interaction = results.get("orientation_interaction")
    own = {}
    if "model_parameter" in results:
        names = results["model_parameter"].to_numpy().tolist()
        own = dict(zip(names, results["orientation_parameter"].to_numpy().tolist(), strict=True))
    # Results that name none are of a time when a study had one model only.
    named = results.get("orientation_model")
    name = "folgar-tucker" if named is None else str(named.item())
    return name, None if interaction is None else float(interaction), own


def summarize_orientation(results: xr.Dataset) -> dict[str, Any]:
    """Return what summary.json says of the orientation along the streamlines.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.

    Returns
    -------
    dict
        ``{"orientation_tensor": {...}}``: the model with its parameters, the interaction
        coefficient (None where the model has none), the estimated error of the integration and the
        largest excess of an eigenvalue over [0, 1], the tensor in the finished bead by streamline,
        and the closure's largest error along one of them (None where the distribution is not
        known: for any model but Folgar and Tucker's).
    """
    model, interaction, own = stored_model(results)
    tensor = results["orientation"].transpose("streamline", "point", "axis", "other_axis")
    last = tensor.to_numpy()[:, -1]
    return {
        "orientation_tensor": {
            "model": model,
            "parameters": own,
            "interaction": interaction,
            "error": float(results["orientation_error"].max()),
            "violation": float(results["orientation_violation"].max()),
            "in_the_bead": [
                {"streamline": int(number), "a": a.tolist()}
                for number, a in zip(results["streamline"].to_numpy(), last, strict=True)
            ],
            "closure_error": {
                "streamline": int(results["closure_streamline"]),
                "largest": float(results["closure_error"].max()),
                "in_the_bead": float(results["closure_error"][-1]),
            }
            if "closure_error" in results
            else None,
        }
    }


def orientation_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what a summary says of the orientation along the streamlines, for a person."""
    found = summary["orientation_tensor"]
    along = [one["a"][0][0] for one in found["in_the_bead"]]
    closure = found["closure_error"]
    model = model_in_words(found["model"], found["interaction"], found["parameters"])
    given = "paths" in summary and "bead_height" not in summary["flow"]
    where, word = ("where the paths end", "path") if given else ("in the bead", "streamline")
    lines = [f"orientation     a_xx {where} {min(along):.3f} to {max(along):.3f}, by {model}"]
    if closure is not None:
        lines[0] += (
            f"; the closure is off by up to {closure['largest']:.3f} on {word} "
            f"{closure['streamline']}, {closure['in_the_bead']:.3f} {where}"
        )
    if found["violation"] > 0:
        lines.append(f"                eigenvalues leave [0, 1] by up to {found['violation']:.1e}")
    return lines
