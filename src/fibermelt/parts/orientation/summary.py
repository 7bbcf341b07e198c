"""What summary.json says of orientation along the streamlines, as functions of results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.parts.interaction.models import model_in_words

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["orientation_in_words", "stored_model", "summarize_orientation"]


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
