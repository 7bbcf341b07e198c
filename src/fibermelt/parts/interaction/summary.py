"""What summary.json says of content and the size of the cell, as functions of results."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["interaction_in_words", "summarize_interaction"]


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
