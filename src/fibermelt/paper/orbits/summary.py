"""What summary.json says of single fibers in simple shear, as functions of the results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.quantities import or_none

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["orbits_in_words", "period_rows", "summarize_orbits"]

TABLE_1 = ("aspect_ratio", "shear_rate")
"""The sweeps of the paper's Table 1; the viscosity changes no period."""


def summarize_orbits(results: xr.Dataset) -> dict[str, Any]:
    """Return the numbers of single fibers in simple shear, in SI.

    Parameters
    ----------
    results : xarray.Dataset
        With the variables of `fibermelt.paper.orbits.stages.orbits_stage`.

    Returns
    -------
    dict
        Under ``"orbits"``: ``domain_size`` of the cells; ``cases``, each with its sweep, its
        parameters and, by model
        (``confined-ellipse`` in its cell, ``ellipse`` in an unbounded melt), what a turn comes to:
        ``period`` null if the fiber stalls, pressures relative to the far field's,
        ``angle_at_min`` from the flow and ``where_at_min`` on the surface in radians; and
        ``periods``, Table 1 (`period_rows`).
    """
    return {
        "orbits": {
            "domain_size": float(results["orbit_domain_size"]),
            "cases": [_case(results, k) for k in range(results.sizes["case"])],
            "periods": period_rows(results),
        }
    }


def _case(results: xr.Dataset, k: int) -> dict[str, Any]:
    names = {
        "shape_factor": "orbit_shape_factor",
        "period": "orbit_period",
        "max_pressure": "orbit_highest",
        "min_pressure": "orbit_lowest",
        "tip_max": "orbit_tip_highest",
        "tip_min": "orbit_tip_lowest",
        "angle_at_min": "orbit_angle_at_lowest",
        "where_at_min": "orbit_where_lowest",
    }
    case: dict[str, Any] = {
        "sweep": str(results["case_sweep"][k].item()),
        "aspect_ratio": float(results["case_aspect_ratio"][k]),
        "shear_rate": float(results["case_shear_rate"][k]),
        "viscosity": float(results["case_viscosity"][k]),
    }
    for m, model in enumerate(results["orbit_model"].to_numpy()):
        case[str(model)] = {key: or_none(results[name][k, m]) for key, name in names.items()}
    return case


def period_rows(results: xr.Dataset) -> list[dict[str, Any]]:
    """Return the paper's Table 1 with ours beside it: time of a full turn [s].

    Parameters
    ----------
    results : xarray.Dataset
        As in `summarize_orbits`.

    Returns
    -------
    list of dict
        One for each aspect ratio and each shear rate: ``sweep``, ``aspect_ratio``, ``shear_rate``,
        ``jeffery`` (exact), ``ours`` (in the cell; null if the fiber stalls), ``paper_jeffery`` and
        ``paper`` (as printed; null where Table 1 has no such line), ``ours_above_jeffery`` and
        ``paper_above_jeffery`` (relative differences).
    """
    models = [str(model) for model in results["orbit_model"].to_numpy()]
    confined, unbounded = models.index("confined-ellipse"), models.index("ellipse")
    rows = []
    for k, sweep in enumerate(results["case_sweep"].to_numpy()):
        if str(sweep) not in TABLE_1:
            continue
        jeffery = float(results["orbit_period"][k, unbounded])
        ours = or_none(results["orbit_period"][k, confined])
        printed = or_none(results["printed_period"][k])
        rows.append(
            {
                "sweep": str(sweep),
                "aspect_ratio": float(results["case_aspect_ratio"][k]),
                "shear_rate": float(results["case_shear_rate"][k]),
                "jeffery": jeffery,
                "ours": ours,
                "paper_jeffery": or_none(results["printed_period_jeffery"][k]),
                "paper": printed,
                "ours_above_jeffery": None if ours is None else ours / jeffery - 1.0,
                "paper_above_jeffery": None if printed is None else printed / jeffery - 1.0,
            }
        )
    return rows


def orbits_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return Table 1 and the pressure extremes as lines for a person.

    Parameters
    ----------
    summary : mapping
        The content of summary.json.
    """
    found = summary["orbits"]
    base = found["cases"][0]
    lines = [
        f"one fiber       aspect ratio {base['aspect_ratio']:g}, {base['shear_rate']:g} 1/s, "
        f"{base['viscosity']:g} Pa s: {base['confined-ellipse']['min_pressure'] / 1e3:.2f} kPa at "
        f"the lowest, {base['ellipse']['min_pressure'] / 1e3:.2f} kPa unbounded"
    ]
    for sweep, heading in (("aspect_ratio", "r_e"), ("shear_rate", "rate [1/s]")):
        rows = [row for row in found["periods"] if row["sweep"] == sweep]
        if rows:
            lines += _table(
                ("period [s]", heading, [f"{row[sweep]:g}" for row in rows]),
                ("", "Jeffery", [_seconds(row["jeffery"]) for row in rows]),
                ("", f"M = {found['domain_size']:g}", [_seconds(row["ours"]) for row in rows]),
                ("", "the paper", [_seconds(row["paper"]) for row in rows]),
            )
    return lines


def _table(*rows: tuple[str, str, list[str]]) -> list[str]:
    """Return lines of a table: what it is, the row's name, its numbers."""
    return [
        f"{what:<16}{name:<12}" + "".join(f"{number:>8}" for number in numbers)
        for what, name, numbers in rows
    ]


def _seconds(period: float | None) -> str:
    return "none" if period is None else f"{period:.2f}"
