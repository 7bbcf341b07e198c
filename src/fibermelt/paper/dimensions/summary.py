"""What summary.json says of the plane ellipse beside a spheroid, as functions of the results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["dimension_rows", "dimensions_in_words", "summarize_dimensions"]


def summarize_dimensions(results: xr.Dataset) -> dict[str, Any]:
    """Return what the plane ellipse costs, in SI.

    Parameters
    ----------
    results : xarray.Dataset
        With the variables of `fibermelt.paper.dimensions.stages.dimensions_stage`.

    Returns
    -------
    dict
        Under ``"dimensions"``: ``domain_size`` of the confined ellipses; ``peaks``, by aspect ratio
        the highest pressure in
        simple shear over ``mu gamma_dot`` of each model, with ``spheroid_over_ellipse``; and
        ``streamlines`` (`dimension_rows`).
    """
    models = [str(model) for model in results["dimension_model"].to_numpy()]
    table = results["peak_at_ratio"].transpose("ratio", "dimension_model").to_numpy()
    peaks = []
    for ratio, values in zip(results["ratio"].to_numpy(), table, strict=True):
        row = {model: float(value) for model, value in zip(models, values, strict=True)}
        ratios = {"spheroid_over_ellipse": row["spheroid"] / row["ellipse"]}
        peaks.append({"aspect_ratio": float(ratio), **row, **ratios})
    return {
        "dimensions": {
            "domain_size": float(results["dimension_domain_size"]),
            "peaks": peaks,
            "streamlines": dimension_rows(results),
        }
    }


def dimension_rows(results: xr.Dataset) -> list[dict[str, Any]]:
    """Return the lowest pressures along the feature streamlines, model by model.

    Parameters
    ----------
    results : xarray.Dataset
        As in `summarize_dimensions`.

    Returns
    -------
    list of dict
        One for each streamline, location (0 the whole way, 1 before the capillary, 2 from the
        exit to the end of the swell) and model: ``lowest`` and ``mean`` over the initial angles
        in the plane of the lowest surface pressure less the streamline's [Pa], and ``bound`` over
        every orientation.
    """
    extreme, bound = results["feature_extreme"], results["feature_extreme_bound"]
    rows = []
    for f, streamline in enumerate(results["feature_streamline"].to_numpy()):
        for location in results["location"].to_numpy():
            for model in results["dimension_model"].to_numpy():
                at = {"location": location, "dimension_model": model}
                values = extreme.isel(feature=f).sel(at).to_numpy()
                rows.append(
                    {
                        "streamline": int(streamline),
                        "location": int(location),
                        "model": str(model),
                        "lowest": float(values.min()),
                        "mean": float(values.mean()),
                        "bound": float(bound.isel(feature=f).sel(at)),
                    }
                )
    return rows


def dimensions_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what the plane ellipse costs as lines for a person.

    Parameters
    ----------
    summary : mapping
        The content of summary.json.
    """
    lines, found = [], summary["dimensions"]
    if found["peaks"]:
        worst = max(found["peaks"], key=lambda row: float(row["spheroid_over_ellipse"]))
        lines.append(
            f"3D against 2D   a spheroid sees up to {worst['spheroid_over_ellipse']:.2f} times the "
            f"pressure of an unbounded ellipse (aspect ratio {worst['aspect_ratio']:g})"
        )
    lines += [
        f"spheroid        {-row['lowest'] / 1e6:.3f} MPa below the melt's own pressure on "
        f"streamline {row['streamline']}, location {row['location']}"
        for row in found["streamlines"]
        if row["model"] == "spheroid"
    ]
    return lines
