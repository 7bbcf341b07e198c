"""What claims on single fibers and on suspensions are judged by; see `claims.measures`."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fibermelt.engine.results import study_of
from fibermelt.paper.claims.measures import Measure, NotStoredError, needing

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["FIBER"]

FIBER: dict[str, Measure] = {}
"""The quantities of single fibers and suspensions, by their names."""

orbits = partial(needing, FIBER, part="orbits")
suspension = partial(needing, FIBER, part="interaction")

CELL, UNBOUNDED = "confined-ellipse", "ellipse"


def _sweep(results: xr.Dataset, sweep: str, name: str, model: str = CELL) -> tuple[Array, Array]:
    """Return what is varied in a sweep, and what becomes of a variable."""
    rows = np.flatnonzero(results["case_sweep"].to_numpy() == sweep)
    if len(rows) < 2:
        msg = f"fewer than two values of {sweep} were looked at"
        raise NotStoredError(msg)
    of = results[name]
    if "orbit_model" in of.dims:
        of = of.sel(orbit_model=model)
    return results[f"case_{sweep}"].to_numpy()[rows], of.to_numpy()[rows]


def _base(results: xr.Dataset, name: str, model: str = CELL) -> float:
    """Return a variable of the base case."""
    row = int(np.flatnonzero(results["case_sweep"].to_numpy() == "base")[0])
    return float(results[name][row].sel(orbit_model=model))


def _printed(results: xr.Dataset, sweeps: tuple[str, ...], printed: str, model: str) -> Array:
    """Return ours less the printed period [s], and the printed one, where there is one."""
    pairs = [
        np.stack([_sweep(results, sweep, name, model)[1] for name in ("orbit_period", printed)])
        for sweep in sweeps
    ]
    both = np.concatenate(pairs, axis=1)
    both = both[:, np.isfinite(both).all(axis=0)]
    if not both.size:
        msg = "no case is one of the paper's"
        raise NotStoredError(msg)
    return np.asarray(both)


@orbits("orbit_period", "printed_period_jeffery")
def jeffery_period_error(results: xr.Dataset) -> float:
    """Return the largest difference of Jeffery's period from the printed one [s]."""
    sweeps = ("aspect_ratio", "shear_rate")
    ours, paper = _printed(results, sweeps, "printed_period_jeffery", UNBOUNDED)
    return float(abs(ours - paper).max())


@orbits("orbit_period", "printed_period")
def period_error_over_aspect_ratios(results: xr.Dataset) -> float:
    """Return the largest relative difference from the paper's period, over aspect ratios."""
    ours, paper = _printed(results, ("aspect_ratio",), "printed_period", CELL)
    return float(abs(ours / paper - 1).max())


@orbits("orbit_period", "printed_period")
def period_error_over_shear_rates(results: xr.Dataset) -> float:
    """Return the largest relative difference from the paper's period, over shear rates."""
    ours, paper = _printed(results, ("shear_rate",), "printed_period", CELL)
    return float(abs(ours / paper - 1).max())


@orbits("orbit_period")
def period_with_aspect_ratio(results: xr.Dataset) -> float:
    """Return the least growth of the period from one aspect ratio to the next, relative."""
    return _least_growth(*_sweep(results, "aspect_ratio", "orbit_period"))


@orbits("orbit_period")
def period_times_shear_rate(results: xr.Dataset) -> float:
    """Return the relative range of period times shear rate over the shear rates."""
    rate, period = _sweep(results, "shear_rate", "orbit_period")
    return _range(rate * period)


@orbits("orbit_period")
def period_over_viscosities(results: xr.Dataset) -> float:
    """Return the relative range of the period over the viscosities."""
    return _range(_sweep(results, "viscosity", "orbit_period")[1])


@orbits("orbit_highest")
def pressure_with_aspect_ratio(results: xr.Dataset) -> float:
    """Return the least growth of the highest pressure from one aspect ratio to the next."""
    return _least_growth(*_sweep(results, "aspect_ratio", "orbit_highest"))


@orbits("orbit_highest")
def pressure_with_shear_rate(results: xr.Dataset) -> float:
    """Return the least growth of the highest pressure from one shear rate to the next."""
    return _least_growth(*_sweep(results, "shear_rate", "orbit_highest"))


@orbits("orbit_highest")
def pressure_with_viscosity(results: xr.Dataset) -> float:
    """Return the least growth of the highest pressure from one viscosity to the next."""
    return _least_growth(*_sweep(results, "viscosity", "orbit_highest"))


@orbits("orbit_highest")
def base_pressure(results: xr.Dataset) -> float:
    """Return the highest pressure over the base case's turn [Pa]."""
    return _base(results, "orbit_highest")


@orbits("orbit_angle_at_lowest")
def angle_at_lowest(results: xr.Dataset) -> float:
    """Return the fiber's angle from the flow when its surface sees the lowest pressure [rad]."""
    return _base(results, "orbit_angle_at_lowest")


@orbits("orbit_where_lowest")
def place_of_lowest(results: xr.Dataset) -> float:
    """Return how far from a tip the lowest pressure is [rad], eccentric angle, base case."""
    return abs(_base(results, "orbit_where_lowest"))


@orbits("turn_highest", "case_aspect_ratio")
def circle_variation(results: xr.Dataset) -> float:
    """Return the range over a turn of the highest pressure on a circle, over its mean."""
    circles = np.flatnonzero(results["case_aspect_ratio"].to_numpy() == 1.0)
    if not len(circles):
        msg = "no fiber is a circle: sensitivity.aspect_ratios has no 1"
        raise NotStoredError(msg)
    return _range(results["turn_highest"][circles[0]].sel(orbit_model=CELL).to_numpy())


def _range(values: Array) -> float:
    """Return the range of values over their mean."""
    return float((values.max() - values.min()) / values.mean())


def _least_growth(of: Array, values: Array) -> float:
    """Return the least relative growth of values as what is varied grows, step by step."""
    ordered = values[np.argsort(of)]
    return float((ordered[1:] / ordered[:-1] - 1).min())


# Suspensions, section 2.5.


def _convention(results: xr.Dataset, name: str, convention: str) -> float:
    return float(results[name].sel(convention=convention))


@suspension("interaction_coefficient")
def interaction_of_content(results: xr.Dataset) -> float:
    """Return the interaction coefficient of the study's content."""
    return float(results["interaction_coefficient"])


@suspension("interaction_coefficient")
def content_over_concentrated(results: xr.Dataset) -> float:
    """Return the fiber content over that at which a suspension is concentrated, ``1/r_e``."""
    study = study_of(results)
    return float(study["interaction"]["volume_fraction"] * study["fiber"]["aspect_ratio"])


@suspension("stall_curve_difference")
def stall_angle_difference(results: xr.Dataset) -> float:
    """Return the largest difference of the computed stall angle from Eq. 32 [rad]."""
    _of_six(results)
    return float(results["stall_curve_difference"])


@suspension("interaction_angle_difference")
def preferred_angle_difference(results: xr.Dataset) -> float:
    """Return the largest difference from Eq. 33 [rad] in the standard convention."""
    _of_six(results)
    return _convention(results, "interaction_angle_difference", "standard")


@suspension("interaction_angle_difference")
def preferred_angle_difference_paper(results: xr.Dataset) -> float:
    """Return the largest difference from Eq. 33 [rad] in the paper's convention."""
    _of_six(results)
    return _convention(results, "interaction_angle_difference", "paper")


@suspension("interaction_domain_size_difference")
def domain_size_difference_paper(results: xr.Dataset) -> float:
    """Return the largest difference from Eq. 34 in the paper's convention."""
    _of_six(results)
    return _convention(results, "interaction_domain_size_difference", "paper")


@suspension("content_domain_size")
def domain_size_of_content(results: xr.Dataset) -> float:
    """Return the domain size that follows from the study's content."""
    return float(results["content_domain_size"])


def _of_six(results: xr.Dataset) -> None:
    """Refuse a fiber for which the paper's polynomials were not made."""
    ratio = float(results["stall_aspect_ratio"])
    if ratio != 6.0:
        msg = f"the paper's polynomials are for an aspect ratio of 6, the study's is {ratio:g}"
        raise NotStoredError(msg)
