"""What claims on fibers in the bead, section 3, are judged by; see `claims.measures`."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fibermelt.engine.results import study_of
from fibermelt.paper.claims.measures import (
    CENTER,
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

__all__ = ["BEAD"]

BEAD: dict[str, Measure] = {}
"""The quantities of fibers in the bead, by their names."""

needs = partial(needing, BEAD, part="bead")

TIP = 0.0873
"""Eccentric angle [rad] up to which a place counts as the tip: 5 degrees, 0.4 % of the length."""


def _means(results: xr.Dataset, location: int, kind: str) -> Array:
    """Return the extreme of every streamline [Pa], mean over the initial angles."""
    means: Array = _extreme(results, "extreme", location, kind).mean(axis=1)
    return means


def _extreme(results: xr.Dataset, name: str, location: int, kind: str) -> Array:
    """Return a variable of the extremes, (streamline, initial angle)."""
    of = results[name].sel(location=location, kind=kind)
    return np.asarray(of.transpose("streamline", "initial_angle").to_numpy())


def _deepest(results: xr.Dataset, name: str, first: int, last: int) -> Array:
    """Return a variable where each fiber's surface pressure less the melt's is lowest on a stretch.

    (streamline, initial angle); between zones ``first`` and ``last``, from the inlet for 0 and to
    the outlet for 4. Claims on where the extremes of a location lie are judged on a stretch that
    reaches beyond it: within the location there would be nothing to judge.
    """
    ends = np.pad(results["zone_time"].to_numpy(), ((0, 0), (1, 1)), constant_values=(-np.inf,))
    ends[:, -1] = np.inf
    time = results["time"].transpose("streamline", "point").to_numpy()
    here = (time >= ends[:, first, None]) & (time <= ends[:, last, None])
    lowest = results["lowest"].transpose("streamline", "initial_angle", "point").to_numpy()
    at = np.argmin(np.where(here[:, None], lowest, np.inf), axis=-1)
    values = results[name].transpose("streamline", "point").to_numpy()
    return np.asarray(np.take_along_axis(values, at, axis=-1))


def _height(results: xr.Dataset) -> Array:
    """Return the height of each streamline in the finished bead [m]."""
    return np.asarray(results["y"].to_numpy()[:, -1])


@needs("extreme", "near_singularity")
def entrance_minimum(results: xr.Dataset) -> float:
    """Return the mean minimum at Loc. 1, mean over the streamlines [Pa]."""
    return float(_means(results, 1, "min")[regular_lines(results)].mean())


@needs("extreme", "near_singularity")
def entrance_minimum_range(results: xr.Dataset) -> float:
    """Return the range over the streamlines of the mean minimum at Loc. 1, over its mean."""
    means = _means(results, 1, "min")[regular_lines(results)]
    return float(np.ptp(means) / abs(means.mean()))


@needs("lowest", "zone_time", "near_singularity")
def entrance_minimum_height(results: xr.Dataset) -> float:
    """Return how far above the entrance the mean place of the nozzle's minimum is [m], lowest."""
    return float(_above_entrance(results).min())


@needs("lowest", "zone_time", "near_singularity")
def entrance_minimum_reach(results: xr.Dataset) -> float:
    """Return how far above the entrance the mean place of the minimum is, in widths, highest."""
    return float(_above_entrance(results).max() / study_of(results)["flow"]["capillary_width"])


def _above_entrance(results: xr.Dataset) -> Array:
    nozzle = study_of(results)["flow"]
    places = _deepest(results, "y", 0, 2).mean(axis=1)[regular_lines(results)]
    above: Array = places - (nozzle["gap"] + nozzle["capillary_length"])
    return above


@needs("extreme", "near_singularity")
def exit_minimum_left(results: xr.Dataset) -> float:
    """Return the lowest mean minimum at Loc. 2 on the left half of the streamlines [Pa]."""
    chosen = regular_lines(results) & (results["flux_fraction"].to_numpy() < 0.5)
    return float(_means(results, 2, "min")[chosen].min())


@needs("extreme", "near_singularity")
def exit_minimum_right(results: xr.Dataset) -> float:
    """Return the highest mean minimum at Loc. 2 on the right half of the streamlines [Pa]."""
    chosen = regular_lines(results) & (results["flux_fraction"].to_numpy() > 0.5)
    return float(_means(results, 2, "min")[chosen].max())


@needs("extreme", "near_singularity")
def deepest_from_left(results: xr.Dataset) -> float:
    """Return the share of the flux left of the streamline with the lowest mean minimum, Loc. 2."""
    regular = regular_lines(results)
    deepest = np.argmin(_means(results, 2, "min")[regular])
    return float(results["flux_fraction"].to_numpy()[regular][deepest])


@needs("lowest", "zone_time", "near_singularity")
def exit_minimum_within_swell(results: xr.Dataset) -> float:
    """Return the share of fibers whose minimum from zone 1 on lies between zones 2 and 3."""
    regular, zone = regular_lines(results), results["zone_time"].to_numpy()
    when = _deepest(results, "time", 1, 4)
    within = (when >= zone[:, 1, None]) & (when <= zone[:, 2, None])
    return float(np.mean(within[regular]))


@needs("extreme_pressure")
def center_entrance_absolute(results: xr.Dataset) -> float:
    """Return the lowest pressure at Loc. 1 on streamline 10 above the air's [Pa], any angle."""
    of = _extreme(results, "extreme_pressure", 1, "min")
    return float(of[paper_line(results, CENTER)].min())


@needs("extreme_pressure", "initial_angle")
def center_exit_absolute(results: xr.Dataset) -> float:
    """Return the pressure at Loc. 2 on streamline 10 above the air's [Pa], entering along x."""
    angles = results["initial_angle"].to_numpy()
    along = int(np.argmin(np.abs(angles)))
    if abs(angles[along]) > 1e-9:
        msg = "no fiber of this study enters at an angle of 0"
        raise NotStoredError(msg)
    of = _extreme(results, "extreme_pressure", 2, "min")
    return float(of[paper_line(results, CENTER), along])


@needs("extreme_where", "near_singularity")
def minima_at_tips(results: xr.Dataset) -> float:
    """Return the share of minima, at both locations, that lie within 5 degrees of a tip."""
    regular = regular_lines(results)
    places = [_extreme(results, "extreme_where", k, "min")[regular] for k in (1, 2)]
    return float(np.mean(np.abs(np.stack(places)) <= TIP))


def _edge_over_center(results: xr.Dataset, location: int) -> float:
    """Return the mean maximum at the outermost two streamlines over that of the middle two."""
    regular = regular_lines(results)
    means, off = _means(results, location, "max")[regular], off_center(results)[regular]
    order = np.argsort(off, kind="stable")
    return float(means[order[-2:]].mean() / means[order[:2]].mean())


@needs("extreme", "near_singularity")
def entrance_maximum_edges_over_center(results: xr.Dataset) -> float:
    """Return the mean maximum at Loc. 1 at the edges over that at the center."""
    return _edge_over_center(results, 1)


@needs("extreme", "near_singularity")
def exit_maximum_edges_over_center(results: xr.Dataset) -> float:
    """Return the mean maximum at Loc. 2 at the edges over that at the center."""
    return _edge_over_center(results, 2)


@needs("extreme", "near_singularity")
def entrance_over_exit_maximum(results: xr.Dataset) -> float:
    """Return the mean maximum at Loc. 1 over that at Loc. 2."""
    regular = regular_lines(results)
    first, second = (_means(results, k, "max")[regular].mean() for k in (1, 2))
    return float(first / second)


@needs("extreme_y", "near_singularity")
def exit_maximum_depth(results: xr.Dataset) -> float:
    """Return how far below the exit the maximum at Loc. 2 is [m], mean over all fibers."""
    places = _extreme(results, "extreme_y", 2, "max")[regular_lines(results)]
    return float(study_of(results)["flow"]["gap"] - places.mean())


@needs("extreme")
def center_over_edge_sensitivity(results: xr.Dataset) -> float:
    """Return the least ratio of the spread over initial angles on streamline 10 to 4 and to 18."""
    center, *edges = (paper_line(results, k) for k in (CENTER, LEFT, RIGHT))
    ratios = []
    for location in (1, 2):
        spread = _extreme(results, "extreme", location, "min").std(axis=1)
        if not all(spread[edge] for edge in edges):
            msg = "the extremes do not depend on the initial angle: there is no spread to compare"
            raise NotStoredError(msg)
        ratios += [spread[center] / spread[edge] for edge in edges]
    return float(min(ratios))


@needs("zone_angle", "near_singularity")
def angle_to_stream_below(results: xr.Dataset) -> float:
    """Return the median angle between fiber and streamline [rad] over the three zones."""
    return float(np.median(np.abs(results["zone_angle"].to_numpy()[regular_lines(results)])))


@needs("zone_angle", "near_singularity")
def alignment_from_center(results: xr.Dataset) -> float:
    """Return the highest, over the zones, rank correlation of spread and distance from center."""
    regular = regular_lines(results)
    spread = results["zone_angle"].to_numpy()[regular].std(axis=1)
    off = off_center(results)[regular]
    return max(rank_correlation(spread[:, zone], off) for zone in range(spread.shape[1]))


@needs("zone_angle", "near_singularity")
def spread_between_zones(results: xr.Dataset) -> float:
    """Return the largest spread of a zone's angles, mean over the streamlines, over the least."""
    spread = results["zone_angle"].to_numpy()[regular_lines(results)].std(axis=1).mean(axis=0)
    if not spread.min():
        msg = "one fiber to a streamline has no spread"
        raise NotStoredError(msg)
    return float(spread.max() / spread.min())


@needs("lowest", "pressure", "near_singularity")
def lowest_pressure_with_height(results: xr.Dataset) -> float:
    """Return the rank correlation of the lowest pressure on any fiber and height in the bead."""
    regular = regular_lines(results)
    absolute = results["lowest"] + results["pressure"]
    lowest = absolute.min(dim=("initial_angle", "point")).to_numpy()
    return rank_correlation(lowest[regular], _height(results)[regular])
