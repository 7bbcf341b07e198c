"""What claims on the deposition flow, section 2.1, are judged by; see `claims.measures`."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.results import study_of
from fibermelt.paper.claims.measures import (
    LEFT,
    RIGHT,
    Measure,
    NotStoredError,
    needing,
    off_center,
    paper_line,
    rank_correlation,
    regular_lines,
)

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["FLOW"]

FLOW: dict[str, Measure] = {}
"""The quantities of the flow, by their names."""

needs = partial(needing, FLOW, part="bead")

NEAR_EXIT = 0.5
"""How far above the exit counts as near it, in capillary widths: the flow is developed beyond."""


def _some(chosen: NDArray[np.bool_]) -> None:
    """Refuse a region in which no point of a streamline lies."""
    if not chosen.any():
        msg = "no point of a streamline lies in that region: raise streamlines.points"
        raise NotStoredError(msg)


def _at_level(results: xr.Dataset, level: float, name: str) -> Array:
    """Return a variable where each streamline comes down to a height y [m]."""
    values, y = results[name].to_numpy(), results["y"].to_numpy()
    first = np.argmax(y <= level, axis=1)
    rows = np.arange(len(y))
    share = (y[rows, first - 1] - level) / (y[rows, first - 1] - y[rows, first])
    return np.asarray((1 - share) * values[rows, first - 1] + share * values[rows, first])


@needs("x", "y", "u", "v", "near_singularity")
def capillary_profile_error(results: xr.Dataset) -> float:
    """Return the largest difference from the parabola at half the capillary's length, relative."""
    nozzle = study_of(results)["flow"]
    level = nozzle["gap"] + 0.5 * nozzle["capillary_length"]
    width = nozzle["capillary_width"]
    top = 1.5 * nozzle["inlet_speed"] * nozzle["inlet_width"] / width
    parabola = top * (1 - (2 * _at_level(results, level, "x") / width) ** 2)
    return float(np.max(np.abs(-_at_level(results, level, "v") - parabola)) / top)


@needs("time", "flux_fraction", "near_singularity")
def transit_time_from_center(results: xr.Dataset) -> float:
    """Return the rank correlation of transit time and distance from the center."""
    regular = regular_lines(results)
    transit = results["time"].to_numpy()[:, -1]
    return rank_correlation(transit[regular], off_center(results)[regular])


@needs("gradient", "y", "near_singularity")
def dominating_gradient_share(results: xr.Dataset) -> float:
    """Return the share of places just above the exit at which dv_y/dx is the largest component."""
    nozzle, regular = study_of(results)["flow"], regular_lines(results)
    y = results["y"].to_numpy()[regular]
    near = (y > nozzle["gap"]) & (y < nozzle["gap"] + NEAR_EXIT * nozzle["capillary_width"])
    _some(near)
    gradient = np.abs(results["gradient"].to_numpy()[regular][near]).reshape(-1, 4)
    return float(np.mean(np.argmax(gradient, axis=1) == 2))


@needs("gradient", "y", "near_singularity")
def gradient_from_center(results: xr.Dataset) -> float:
    """Return the rank correlation of |dv_y/dx| just above the exit and distance from the center."""
    nozzle, regular = study_of(results)["flow"], regular_lines(results)
    level = nozzle["gap"] + 0.5 * NEAR_EXIT * nozzle["capillary_width"]
    shear = results.assign(shear=results["gradient"][..., 1, 0])
    return rank_correlation(
        np.abs(_at_level(shear, level, "shear"))[regular], off_center(results)[regular]
    )


def _downstream(results: xr.Dataset) -> tuple[NDArray[np.bool_], dict[str, Any]]:
    """Return which points lie one to two bead heights before the outlet, and the flow's table."""
    nozzle = study_of(results)["flow"]
    height = nozzle["inlet_speed"] * nozzle["inlet_width"] / nozzle["bed_speed"]
    x = results["x"].to_numpy()
    chosen = (x > nozzle["outlet"] - 2 * height) & (x < nozzle["outlet"] - height)
    _some(chosen)
    return np.asarray(chosen), nozzle


@needs("x", "u", "v")
def downstream_speed_deviation(results: xr.Dataset) -> float:
    """Return the largest difference from the bed's velocity downstream, relative."""
    chosen, nozzle = _downstream(results)
    u, v = (results[name].to_numpy()[chosen] for name in ("u", "v"))
    return float(np.max(np.hypot(u - nozzle["bed_speed"], v)) / nozzle["bed_speed"])


@needs("x", "shear_rate")
def downstream_stress(results: xr.Dataset) -> float:
    """Return the largest rate of deformation downstream over that of the capillary's wall."""
    chosen, nozzle = _downstream(results)
    wall = 6 * nozzle["inlet_speed"] * nozzle["inlet_width"] / nozzle["capillary_width"] ** 2
    return float(results["shear_rate"].to_numpy()[chosen].max() / wall)


@needs("zone_time", "near_singularity")
def swell_time_from_right(results: xr.Dataset) -> float:
    """Return the rank correlation of the time from zone 2 to 3 and the number from the right."""
    regular = regular_lines(results)
    zone = results["zone_time"].to_numpy()[regular]
    return rank_correlation(zone[:, 2] - zone[:, 1], -results["streamline"].to_numpy()[regular])


@needs("zone_time")
def swell_time_right_over_left(results: xr.Dataset) -> float:
    """Return the time from zone 2 to 3 on streamline 18 over that on streamline 4."""
    zone = results["zone_time"].to_numpy()
    right, left = (zone[paper_line(results, k)] for k in (RIGHT, LEFT))
    return float((right[2] - right[1]) / (left[2] - left[1]))
