"""What claims on the bead are judged by; see `fibermelt.study.claims.quantities`."""

from __future__ import annotations

import tomllib
from functools import partial
from typing import TYPE_CHECKING, Any

from fibermelt.study.claims.quantities import NotStoredError, by_name, needing

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["BEAD"]

needs = partial(needing, part="bead")

LEFT, CENTER, RIGHT = 4, 10, 18
"""The paper's feature streamlines: near the left edge, the center, near the right edge."""

NEAR_EXIT = 0.5
"""How far above the exit counts as near it, in capillary widths: the flow is developed beyond."""

TIP = 0.0873
"""Eccentric angle [rad] up to which a place counts as the tip: 5 degrees, 0.4 % of the length."""


def _study(results: xr.Dataset) -> dict[str, Any]:
    """Return the resolved study that the results hold, as tables."""
    return tomllib.loads(results.attrs["config"])


def _regular(results: xr.Dataset) -> NDArray[np.bool_]:
    """Return which streamlines pass no singular corner."""
    import numpy as np  # noqa: PLC0415  lazy, as in the stages

    regular = ~results["near_singularity"].to_numpy().astype(bool)
    if np.count_nonzero(regular) < 3:
        msg = "fewer than three streamlines stay away from the singular corners"
        raise NotStoredError(msg)
    return np.asarray(regular)


def _line(results: xr.Dataset, number: int) -> int:
    """Return the place of a streamline of the paper."""
    numbers = results["streamline"].to_numpy().tolist()
    if len(numbers) != 22:
        msg = f"the paper's streamline {number} is one of 22; this study has {len(numbers)}"
        raise NotStoredError(msg)
    return int(numbers.index(number))


def _means(results: xr.Dataset, location: int, kind: str) -> Array:
    """Return the extreme of every streamline [Pa], mean over the initial angles."""
    means: Array = _extreme(results, "extreme", location, kind).mean(axis=1)
    return means


def _extreme(results: xr.Dataset, name: str, location: int, kind: str) -> Array:
    """Return a variable of the extremes, (streamline, initial angle)."""
    import numpy as np  # noqa: PLC0415

    of = results[name].transpose("streamline", "initial_angle", "location", "kind").to_numpy()
    return np.asarray(of[:, :, location - 1, 0 if kind == "min" else 1])


def _rank_correlation(first: Array, second: Array) -> float:
    """Return Spearman's rank correlation."""
    import numpy as np  # noqa: PLC0415
    from scipy.stats import spearmanr  # noqa: PLC0415

    if not np.ptp(first) or not np.ptp(second):
        msg = "the same on all streamlines: there is no trend to judge"
        raise NotStoredError(msg)
    return float(spearmanr(first, second).statistic)


def _some(chosen: NDArray[np.bool_]) -> None:
    """Refuse a region in which no point of a streamline lies."""
    if not chosen.any():
        msg = "no point of a streamline lies in that region: raise streamlines.points"
        raise NotStoredError(msg)


def _off_center(results: xr.Dataset) -> Array:
    """Return how far each streamline is from the center one, as a share of the flux."""
    import numpy as np  # noqa: PLC0415

    return np.asarray(np.abs(results["flux_fraction"].to_numpy() - 0.5))


def _height(results: xr.Dataset) -> Array:
    """Return the height of each streamline in the finished bead [m]."""
    import numpy as np  # noqa: PLC0415

    return np.asarray(results["y"].to_numpy()[:, -1])


def _at_level(results: xr.Dataset, level: float, name: str) -> Array:
    """Return a variable where each streamline comes down to a height y [m]."""
    import numpy as np  # noqa: PLC0415

    values, y = results[name].to_numpy(), results["y"].to_numpy()
    first = np.argmax(y <= level, axis=1)
    rows = np.arange(len(y))
    share = (y[rows, first - 1] - level) / (y[rows, first - 1] - y[rows, first])
    return np.asarray((1 - share) * values[rows, first - 1] + share * values[rows, first])


# The flow, section 2.1.


@needs("x", "y", "u", "v", "near_singularity")
def capillary_profile_error(results: xr.Dataset) -> float:
    """Return the largest difference from the parabola at half the capillary's length, relative."""
    import numpy as np  # noqa: PLC0415

    nozzle = _study(results)["flow"]
    level = nozzle["gap"] + 0.5 * nozzle["capillary_length"]
    width = nozzle["capillary_width"]
    top = 1.5 * nozzle["inlet_speed"] * nozzle["inlet_width"] / width
    parabola = top * (1 - (2 * _at_level(results, level, "x") / width) ** 2)
    return float(np.max(np.abs(-_at_level(results, level, "v") - parabola)) / top)


@needs("time", "flux_fraction", "near_singularity")
def transit_time_from_center(results: xr.Dataset) -> float:
    """Return the rank correlation of transit time and distance from the center."""
    regular = _regular(results)
    transit = results["time"].to_numpy()[:, -1]
    return _rank_correlation(transit[regular], _off_center(results)[regular])


@needs("gradient", "y", "near_singularity")
def dominating_gradient_share(results: xr.Dataset) -> float:
    """Return the share of places just above the exit at which dv_y/dx is the largest component."""
    import numpy as np  # noqa: PLC0415

    nozzle, regular = _study(results)["flow"], _regular(results)
    y = results["y"].to_numpy()[regular]
    near = (y > nozzle["gap"]) & (y < nozzle["gap"] + NEAR_EXIT * nozzle["capillary_width"])
    _some(near)
    gradient = np.abs(results["gradient"].to_numpy()[regular][near]).reshape(-1, 4)
    return float(np.mean(np.argmax(gradient, axis=1) == 2))


@needs("gradient", "y", "near_singularity")
def gradient_from_center(results: xr.Dataset) -> float:
    """Return the rank correlation of |dv_y/dx| just above the exit and distance from the center."""
    import numpy as np  # noqa: PLC0415

    nozzle, regular = _study(results)["flow"], _regular(results)
    level = nozzle["gap"] + 0.5 * NEAR_EXIT * nozzle["capillary_width"]
    shear = results.assign(shear=results["gradient"][..., 1, 0])
    return _rank_correlation(
        np.abs(_at_level(shear, level, "shear"))[regular], _off_center(results)[regular]
    )


def _downstream(results: xr.Dataset) -> tuple[NDArray[np.bool_], dict[str, Any]]:
    """Return which points lie one to two bead heights before the outlet, and the flow's table."""
    import numpy as np  # noqa: PLC0415

    nozzle = _study(results)["flow"]
    height = nozzle["inlet_speed"] * nozzle["inlet_width"] / nozzle["bed_speed"]
    x = results["x"].to_numpy()
    chosen = (x > nozzle["outlet"] - 2 * height) & (x < nozzle["outlet"] - height)
    _some(chosen)
    return np.asarray(chosen), nozzle


@needs("x", "u", "v")
def downstream_speed_deviation(results: xr.Dataset) -> float:
    """Return the largest difference from the bed's velocity downstream, relative."""
    import numpy as np  # noqa: PLC0415

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
    regular = _regular(results)
    zone = results["zone_time"].to_numpy()[regular]
    return _rank_correlation(zone[:, 2] - zone[:, 1], -results["streamline"].to_numpy()[regular])


@needs("zone_time")
def swell_time_right_over_left(results: xr.Dataset) -> float:
    """Return the time from zone 2 to 3 on streamline 18 over that on streamline 4."""
    zone = results["zone_time"].to_numpy()
    right, left = (zone[_line(results, k)] for k in (RIGHT, LEFT))
    return float((right[2] - right[1]) / (left[2] - left[1]))


# The fibers' extremes, section 3.


@needs("extreme", "near_singularity")
def entrance_minimum(results: xr.Dataset) -> float:
    """Return the mean minimum at Loc. 1, mean over the streamlines [Pa]."""
    return float(_means(results, 1, "min")[_regular(results)].mean())


@needs("extreme", "near_singularity")
def entrance_minimum_range(results: xr.Dataset) -> float:
    """Return the range over the streamlines of the mean minimum at Loc. 1, over its mean."""
    import numpy as np  # noqa: PLC0415

    means = _means(results, 1, "min")[_regular(results)]
    return float(np.ptp(means) / abs(means.mean()))


@needs("extreme_y", "near_singularity")
def entrance_minimum_height(results: xr.Dataset) -> float:
    """Return how far above the entrance the mean place of the minimum at Loc. 1 is [m], lowest."""
    return float(_above_entrance(results).min())


@needs("extreme_y", "near_singularity")
def entrance_minimum_reach(results: xr.Dataset) -> float:
    """Return how far above the entrance the mean place of the minimum is, in widths, highest."""
    return float(_above_entrance(results).max() / _study(results)["flow"]["capillary_width"])


def _above_entrance(results: xr.Dataset) -> Array:
    nozzle = _study(results)["flow"]
    places = _extreme(results, "extreme_y", 1, "min").mean(axis=1)[_regular(results)]
    above: Array = places - (nozzle["gap"] + nozzle["capillary_length"])
    return above


@needs("extreme", "near_singularity")
def exit_minimum_left(results: xr.Dataset) -> float:
    """Return the lowest mean minimum at Loc. 2 on the left half of the streamlines [Pa]."""
    chosen = _regular(results) & (results["flux_fraction"].to_numpy() < 0.5)
    return float(_means(results, 2, "min")[chosen].min())


@needs("extreme", "near_singularity")
def exit_minimum_right(results: xr.Dataset) -> float:
    """Return the highest mean minimum at Loc. 2 on the right half of the streamlines [Pa]."""
    chosen = _regular(results) & (results["flux_fraction"].to_numpy() > 0.5)
    return float(_means(results, 2, "min")[chosen].max())


@needs("extreme", "near_singularity")
def deepest_from_left(results: xr.Dataset) -> float:
    """Return the share of the flux left of the streamline with the lowest mean minimum, Loc. 2."""
    import numpy as np  # noqa: PLC0415

    regular = _regular(results)
    deepest = np.argmin(_means(results, 2, "min")[regular])
    return float(results["flux_fraction"].to_numpy()[regular][deepest])


@needs("extreme_time", "zone_time", "near_singularity")
def exit_minimum_within_swell(results: xr.Dataset) -> float:
    """Return the share of fibers whose minimum at Loc. 2 lies between zones 2 and 3."""
    import numpy as np  # noqa: PLC0415

    regular, zone = _regular(results), results["zone_time"].to_numpy()
    when = _extreme(results, "extreme_time", 2, "min")
    within = (when >= zone[:, 1, None]) & (when <= zone[:, 2, None])
    return float(np.mean(within[regular]))


@needs("extreme_pressure")
def center_entrance_absolute(results: xr.Dataset) -> float:
    """Return the lowest pressure at Loc. 1 on streamline 10 above the air's [Pa], any angle."""
    of = _extreme(results, "extreme_pressure", 1, "min")
    return float(of[_line(results, CENTER)].min())


@needs("extreme_pressure", "initial_angle")
def center_exit_absolute(results: xr.Dataset) -> float:
    """Return the pressure at Loc. 2 on streamline 10 above the air's [Pa], entering along x."""
    import numpy as np  # noqa: PLC0415

    angles = results["initial_angle"].to_numpy()
    along = int(np.argmin(np.abs(angles)))
    if abs(angles[along]) > 1e-9:
        msg = "no fiber of this study enters at an angle of 0"
        raise NotStoredError(msg)
    of = _extreme(results, "extreme_pressure", 2, "min")
    return float(of[_line(results, CENTER), along])


@needs("extreme_where", "near_singularity")
def minima_at_tips(results: xr.Dataset) -> float:
    """Return the share of minima, at both locations, that lie within 5 degrees of a tip."""
    import numpy as np  # noqa: PLC0415

    regular = _regular(results)
    places = [_extreme(results, "extreme_where", k, "min")[regular] for k in (1, 2)]
    return float(np.mean(np.abs(np.stack(places)) <= TIP))


def _edge_over_center(results: xr.Dataset, location: int) -> float:
    """Return the mean maximum at the outermost two streamlines over that of the middle two."""
    import numpy as np  # noqa: PLC0415

    regular = _regular(results)
    means, off = _means(results, location, "max")[regular], _off_center(results)[regular]
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
    regular = _regular(results)
    first, second = (_means(results, k, "max")[regular].mean() for k in (1, 2))
    return float(first / second)


@needs("extreme_y", "near_singularity")
def exit_maximum_depth(results: xr.Dataset) -> float:
    """Return how far below the exit the maximum at Loc. 2 is [m], mean over all fibers."""
    places = _extreme(results, "extreme_y", 2, "max")[_regular(results)]
    return float(_study(results)["flow"]["gap"] - places.mean())


@needs("extreme")
def center_over_edge_sensitivity(results: xr.Dataset) -> float:
    """Return the least ratio of the spread over initial angles on streamline 10 to 4 and to 18."""
    center, *edges = (_line(results, k) for k in (CENTER, LEFT, RIGHT))
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
    import numpy as np  # noqa: PLC0415

    return float(np.median(np.abs(results["zone_angle"].to_numpy()[_regular(results)])))


@needs("zone_angle", "near_singularity")
def alignment_from_center(results: xr.Dataset) -> float:
    """Return the highest, over the zones, rank correlation of spread and distance from center."""
    regular = _regular(results)
    spread = results["zone_angle"].to_numpy()[regular].std(axis=1)
    off = _off_center(results)[regular]
    return max(_rank_correlation(spread[:, zone], off) for zone in range(spread.shape[1]))


@needs("zone_angle", "near_singularity")
def spread_between_zones(results: xr.Dataset) -> float:
    """Return the largest spread of a zone's angles, mean over the streamlines, over the least."""
    spread = results["zone_angle"].to_numpy()[_regular(results)].std(axis=1).mean(axis=0)
    if not spread.min():
        msg = "one fiber to a streamline has no spread"
        raise NotStoredError(msg)
    return float(spread.max() / spread.min())


@needs("lowest", "pressure", "near_singularity")
def lowest_pressure_with_height(results: xr.Dataset) -> float:
    """Return the rank correlation of the lowest pressure on any fiber and height in the bead."""
    regular = _regular(results)
    absolute = results["lowest"] + results["pressure"]
    lowest = absolute.min(dim=("initial_angle", "point")).to_numpy()
    return _rank_correlation(lowest[regular], _height(results)[regular])


BEAD = by_name(
    capillary_profile_error,
    transit_time_from_center,
    dominating_gradient_share,
    gradient_from_center,
    downstream_speed_deviation,
    downstream_stress,
    swell_time_from_right,
    swell_time_right_over_left,
    entrance_minimum,
    entrance_minimum_range,
    entrance_minimum_height,
    entrance_minimum_reach,
    exit_minimum_left,
    exit_minimum_right,
    deepest_from_left,
    exit_minimum_within_swell,
    center_entrance_absolute,
    center_exit_absolute,
    minima_at_tips,
    entrance_maximum_edges_over_center,
    exit_maximum_edges_over_center,
    entrance_over_exit_maximum,
    exit_maximum_depth,
    center_over_edge_sensitivity,
    angle_to_stream_below,
    alignment_from_center,
    spread_between_zones,
    lowest_pressure_with_height,
)
"""The quantities of fibers in the bead, by their names."""
