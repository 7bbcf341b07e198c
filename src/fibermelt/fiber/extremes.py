"""The pressure extremes of fibers over their way through the nozzle and onto the bed.

The paper's Fig. 16-20: for each fiber the lowest and the highest (surface pressure - streamline
pressure) above the middle of the capillary (Loc. 1) and from there on (Loc. 2). Arrays carry the
axes ``(..., n_angles, location, kind)``, location (1, 2), kind (min, max). An extreme is taken at
a point of the path: its value is off by the square of the points' spacing, its time by the spacing.
"""

from __future__ import annotations

from collections.abc import Callable
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
    "LOCATIONS",
    "ExtremeStatistics",
    "Extremes",
    "before_middle",
    "extreme_bounds",
    "extreme_values",
    "extremes",
    "statistics",
]

Array = NDArray[np.float64]

LOCATIONS = (1, 2)
"""The paper's Loc. 1, above the middle of the capillary, and Loc. 2, below it."""

KINDS = ("min", "max")
"""Lowest and highest surface pressure over the streamline's."""


@dataclass(frozen=True, eq=False)
class Extremes:
    """Pressure extremes of each fiber: every array (..., n_angles, 2 locations, 2 kinds).

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
    """Statistics of `Extremes` over the initial angles: every array (..., 2 locations, 2 kinds).

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
    path: FlowHistory, pressure: SurfaceHistory, motion: Turning, middle_time: ArrayLike
) -> Extremes:
    """Find the pressure extremes of every fiber at both locations.

    Parameters
    ----------
    path : FlowHistory
        The path that the fibers were followed along.
    pressure : SurfaceHistory
        Their surface pressure along it: a `SurfacePressure`, or a `NewtonMotion`.
    motion : Turning
        Their angles along it: a `Motion`, or the same `NewtonMotion`.
    middle_time : float or (...) array
        Time at the middle of the capillary [s]: Loc. 1 is before, Loc. 2 from there on.

    Raises
    ------
    ConfigError
        If a path has no point before, or none after, its middle time.
    HistoryError
        If pressure or motion is along another path.
    """
    refuse_another_path(path, pressure.path)
    refuse_another_path(path, motion.path)
    before = before_middle(path, middle_time)[..., None, :]
    picked = []
    for here in (before, ~before):
        low = np.argmin(np.where(here, pressure.lowest, np.inf), axis=-1)
        high = np.argmax(np.where(here, pressure.highest, -np.inf), axis=-1)
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


def extreme_values(lowest: Array, highest: Array, before: NDArray[np.bool_]) -> Array:
    """Return the values alone of `extremes`, (..., n_angles, 2, 2) [Pa].

    Parameters
    ----------
    lowest, highest : (..., n_angles, n) array
        Pressures along the path [Pa].
    before : (n,) array
        Which points are at location 1, as from `before_middle`.
    """
    sides = [
        [lowest[..., here].min(axis=-1), highest[..., here].max(axis=-1)]
        for here in (before, ~before)
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


def extreme_bounds(path: FlowHistory, bounds: PressureBounds, middle_time: ArrayLike) -> Array:
    """Return the bounds of every fiber's extremes, (..., location, kind, 2) [Pa].

    For "min" the lower side is the lowest over the path of the worst orientation, and the upper
    side the lowest over the path of the mildest: at the point where that is reached no fiber does
    better, whatever its angle. For "max" likewise, ordered [lower, upper].

    Parameters
    ----------
    path, middle_time
        As in `extremes`.
    bounds : PressureBounds
        Bounds over every orientation along the path.
    """
    before = before_middle(path, middle_time)
    sides = []
    for here in (before, ~before):
        low = [_smallest(v, here) for v in (bounds.lowest, bounds.mildest_lowest)]
        high = [-_smallest(-v, here) for v in (bounds.mildest_highest, bounds.highest)]
        sides.append(np.stack([np.stack(low, -1), np.stack(high, -1)], axis=-2))
    return np.stack(sides, axis=-3)


def _smallest(values: Array, here: NDArray[np.bool_]) -> Array:
    """Return the least of the values over the points chosen, (...)."""
    least: Array = np.min(np.where(here, values, np.inf), axis=-1)
    return least


def before_middle(path: FlowHistory, middle_time: ArrayLike) -> NDArray[np.bool_]:
    """Return which points lie above the middle of the capillary, (..., n)."""
    refuse_other("path", path, FlowHistory)
    middle = real_array("middle_time", middle_time, duration=True)
    if middle.shape not in ((), path.time.shape[:-1]):
        msg = (
            f"middle_time has shape {middle.shape}: give one, or one for each of the paths, "
            f"{path.time.shape[:-1]}"
        )
        raise ConfigError(msg)
    before: NDArray[np.bool_] = path.time < middle[..., None]
    if not (np.all(np.any(before, axis=-1)) and np.all(np.any(~before, axis=-1))):
        msg = (
            f"middle_time = {middle} s: every path needs points on both sides of it "
            f"(paths run from {np.min(path.time):.6g} to {np.max(path.time):.6g} s)"
        )
        raise ConfigError(msg)
    return before


def _picker(index: NDArray[np.intp]) -> Callable[[Array], Array]:
    """Return a function that reads (..., n_angles or 1, n) arrays at (..., n_angles, 2, 2)."""
    flat = index.reshape(*index.shape[:-2], 4)

    def pick(values: Array) -> Array:
        whole = np.broadcast_to(values, (*flat.shape[:-1], values.shape[-1]))
        return np.take_along_axis(whole, flat, axis=-1).reshape(index.shape)

    return pick


def _pick_kinds(lowest: Array, highest: Array, index: NDArray[np.intp]) -> Array:
    """Return the lowest pressures at the first kind's points, the highest at the second's."""
    low = np.take_along_axis(lowest, index[..., 0], axis=-1)
    high = np.take_along_axis(highest, index[..., 1], axis=-1)
    return np.stack([low, high], axis=-1)
