"""The pressure extremes of fibers over their way through the nozzle and onto the bed.

The paper's Fig. 16-20: for each fiber the lowest and the highest (surface pressure - streamline
pressure) over the whole way (location 0), before the capillary (Loc. 1, from the inlet to zone 1),
and in the swell (Loc. 2, from the nozzle's exit, zone 2, to the end of the swell, zone 3). The
capillary between them and the settled bead count to location 0 alone. Arrays carry the axes ``(...,
n_angles, location, kind)``, kind (min, max); a path without zones has location 0 alone. An extreme
is taken at a point of the path: its value is off by the square of the points' spacing, its time by
the spacing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.motion import Turning, angle_to_stream
from fibermelt.fiber.paths import refuse_another_path
from fibermelt.fiber.pressure import PressureBounds, SurfaceHistory
from fibermelt.history import FlowHistory

__all__ = [
    "KINDS",
    "SWELL",
    "WHOLE",
    "ZONES",
    "ExtremeStatistics",
    "Extremes",
    "extreme_bounds",
    "extreme_values",
    "extremes",
    "locations",
    "statistics",
]

Array = NDArray[np.float64]

WHOLE, ENTRANCE, SWELL = 0, 1, 2
"""The whole path; the paper's Loc. 1, "just prior to the entrance of the nozzle capillary section
(i.e., zone 1)"; its Loc. 2, "within the die swell region between zones 2 & 3" (section 3)."""

ZONES = 3
"""Zones of the paper's section 3: the capillary's entrance, the nozzle's exit, the swell's end."""

KINDS = ("min", "max")
"""Lowest and highest surface pressure over the streamline's."""


@dataclass(frozen=True, eq=False)
class Extremes:
    """Pressure extremes of each fiber: every array (..., n_angles, location, 2 kinds).

    Parameters
    ----------
    value : array
        Surface pressure minus streamline pressure [Pa].
    time : array
        When it happens [s].
    x, y, z : array
        Where it happens [m].
    pressure : array
        Surface pressure above the air's: with the streamline's own [Pa].
    angle : array
        Angle of the fiber to the streamline then [rad], in (-pi/2, pi/2].
    where : array
        Eccentric angle on the surface [rad], in (-pi/2, pi/2]; 0 is the tip.
    index : integer array
        Point of the path.
    """

    value: Array
    time: Array
    x: Array
    y: Array
    z: Array
    pressure: Array
    angle: Array
    where: Array
    index: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class ExtremeStatistics:
    """Statistics of `Extremes` over the initial angles: every array (..., location, 2 kinds).

    Parameters
    ----------
    mean, median, lowest, highest : array
        Of the extremes' values [Pa].
    x, y : array
        Mean position [m].
    """

    mean: Array
    median: Array
    lowest: Array
    highest: Array
    x: Array
    y: Array


def extremes(
    path: FlowHistory,
    pressure: SurfaceHistory,
    motion: Turning,
    zone_time: ArrayLike | None = None,
) -> Extremes:
    """Find the pressure extremes of every fiber at each location.

    Parameters
    ----------
    path : FlowHistory
        The path that the fibers were followed along.
    pressure : SurfaceHistory
        Their surface pressure along it: a `SurfacePressure`, or a `NewtonMotion`.
    motion : Turning
        Their angles along it: a `Motion`, or the same `NewtonMotion`.
    zone_time : (3,) or (..., 3) array, optional
        Times at zones 1 to 3 [s], as in `locations`; without them there is one location.

    Raises
    ------
    ConfigError
        As in `locations`.
    HistoryError
        If pressure or motion is along another path.
    """
    refuse_another_path(path, pressure.path)
    refuse_another_path(path, motion.path)
    picked = []
    for here in locations(path, zone_time).values():
        among = here[..., None, :]
        low = np.argmin(np.where(among, pressure.lowest, np.inf), axis=-1)
        high = np.argmax(np.where(among, pressure.highest, -np.inf), axis=-1)
        picked.append(np.stack([low, high], axis=-1))
    index = np.stack(picked, axis=-2)
    value = _pick_kinds(pressure.lowest, pressure.highest, index)
    along = _picker(index)
    return Extremes(
        value=value,
        time=along(path.time[..., None, :]),
        x=along(path.position[..., None, :, 0]),
        y=along(path.position[..., None, :, 1]),
        z=along(path.position[..., None, :, 2]),
        pressure=value + along(path.pressure[..., None, :]),
        angle=along(angle_to_stream(path, motion)),
        where=pressure.where_at(index),
        index=index,
    )


def extreme_values(lowest: Array, highest: Array, places: Mapping[int, NDArray[np.bool_]]) -> Array:
    """Return the values alone of `extremes`, (..., n_angles, location, 2) [Pa].

    Parameters
    ----------
    lowest, highest : (..., n_angles, n) array
        Pressures along the path [Pa].
    places : mapping
        The points (n,) of each location of that one path, as from `locations`.
    """
    sides = [
        [lowest[..., here].min(axis=-1), highest[..., here].max(axis=-1)]
        for here in places.values()
    ]
    return np.stack([np.stack(side, axis=-1) for side in sides], axis=-2)


def statistics(found: Extremes) -> ExtremeStatistics:
    """Return mean, median, lowest and highest over the initial angles, and the mean position."""
    axis = -3
    return ExtremeStatistics(
        mean=np.mean(found.value, axis=axis),
        median=np.median(found.value, axis=axis),
        lowest=np.min(found.value, axis=axis),
        highest=np.max(found.value, axis=axis),
        x=np.mean(found.x, axis=axis),
        y=np.mean(found.y, axis=axis),
    )


def extreme_bounds(
    path: FlowHistory, bounds: PressureBounds, zone_time: ArrayLike | None = None
) -> Array:
    """Return the bounds of every fiber's extremes, (..., location, kind, 2) [Pa].

    For "min" the lower side is the lowest over the path of the worst orientation, and the upper
    side the lowest over the path of the mildest: at the point where that is reached no fiber does
    better, whatever its angle. For "max" likewise, ordered [lower, upper].

    Parameters
    ----------
    path, zone_time
        As in `extremes`.
    bounds : PressureBounds
        Bounds over every orientation along the path.
    """
    sides = []
    for here in locations(path, zone_time).values():
        low = [_smallest(v, here) for v in (bounds.lowest, bounds.mildest_lowest)]
        high = [-_smallest(-v, here) for v in (bounds.mildest_highest, bounds.highest)]
        sides.append(np.stack([np.stack(low, -1), np.stack(high, -1)], axis=-2))
    return np.stack(sides, axis=-3)


def _smallest(values: Array, here: NDArray[np.bool_]) -> Array:
    """Return the least of the values over the points chosen, (...)."""
    least: Array = np.min(np.where(here, values, np.inf), axis=-1)
    return least


def locations(
    path: FlowHistory, zone_time: ArrayLike | None = None
) -> dict[int, NDArray[np.bool_]]:
    """Return which points (..., n) belong to each location, by its number.

    Location 0 has all of them, 1 those up to zone 1, 2 those from zone 2 to zone 3, both included.

    Parameters
    ----------
    path : FlowHistory
        One path or several.
    zone_time : (3,) or (..., 3) array, optional
        Times at zones 1 to 3 [s], of all paths or of each; NaN where a path reaches none. A
        location is left out unless every path reaches the zones that bound it.

    Raises
    ------
    ConfigError
        If the times have another shape, or a path has no point in a location.
    """
    refuse_other("path", path, FlowHistory)
    found = {WHOLE: np.ones(path.time.shape, dtype=bool)}
    if zone_time is None:
        return found
    when = real_array("zone_time", zone_time, duration=True)
    if when.shape not in ((ZONES,), (*path.time.shape[:-1], ZONES)):
        msg = (
            f"zone_time has shape {when.shape}: give the times at the {ZONES} zones, for all paths "
            f"or for each, {(*path.time.shape[:-1], ZONES)}"
        )
        raise ConfigError(msg)
    entrance, leave, end = (when[..., k, None] for k in range(ZONES))
    for place, start, stop in ((ENTRANCE, -np.inf, entrance), (SWELL, leave, end)):
        if not np.all(np.isfinite(stop) & ~np.isnan(start)):
            continue
        here = (path.time >= start) & (path.time <= stop)
        if not np.all(np.any(here, axis=-1)):
            bounds = "up to zone 1" if place == ENTRANCE else "from zone 2 to zone 3"
            msg = (
                f"zone_time = {when} s: every path needs a point {bounds} (paths run from "
                f"{np.min(path.time):.6g} to {np.max(path.time):.6g} s): take more "
                "streamlines.points, or other stations"
            )
            raise ConfigError(msg)
        found[place] = here
    return found


def _picker(index: NDArray[np.intp]) -> Callable[[Array], Array]:
    """Return a function that reads (..., n_angles or 1, n) arrays at all extremes."""
    flat = index.reshape(*index.shape[:-2], -1)

    def pick(values: Array) -> Array:
        whole = np.broadcast_to(values, (*flat.shape[:-1], values.shape[-1]))
        return np.take_along_axis(whole, flat, axis=-1).reshape(index.shape)

    return pick


def _pick_kinds(lowest: Array, highest: Array, index: NDArray[np.intp]) -> Array:
    """Return the lowest pressures at the first kind's points, the highest at the second's."""
    low = np.take_along_axis(lowest, index[..., 0], axis=-1)
    high = np.take_along_axis(highest, index[..., 1], axis=-1)
    return np.stack([low, high], axis=-1)
