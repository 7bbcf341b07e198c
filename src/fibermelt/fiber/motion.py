"""How a fiber turns along its path, for any number of initial angles at once.

``theta_dot = W_21 + B D_12(local)`` (the paper's Eq. 59, with angles from the flow's axis and ``B``
the confined fiber's shape factor) is the angle of the linear system ``F_dot = (W + B D) F``,
``F(0) = I``.

The gradient between the path's points, and the error control, are in `fibermelt.fiber.magnus`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Protocol, overload, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, refuse_no_count
from fibermelt.fiber.checks import checked_number, checked_positive
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.directions import raised_directions
from fibermelt.fiber.magnus import interval_propagators
from fibermelt.fiber.paths import (
    checked_path,
    refuse_another_path,
    strain_polar,
)
from fibermelt.fiber.propagator import Propagator, cumulate
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.fiber.thinning_motion import TABLE_TOLERANCE, ThinningMotion, follow_thinning
from fibermelt.history import FlowHistory

__all__ = [
    "Motion",
    "Turning",
    "angle_to_stream",
    "angle_to_stream_at",
    "checked_angles",
    "deformation_along",
    "follow",
    "isotropic_angles",
    "paper_angles",
    "turned",
]

Array = NDArray[np.float64]

UNCHECKED = np.inf
"""Tolerance with which no step is halved to see its error: of fourth order in a turn below one."""

ANGLE_TOLERANCE = 1e-8
"""Largest angle error over a path [rad] that is left to the time integration."""


def paper_angles() -> Array:
    """Return the paper's 13 initial angles, -90 to 90 degrees in steps of 15 [rad] (section 3)."""
    return np.linspace(-0.5 * np.pi, 0.5 * np.pi, 13)


def isotropic_angles(count: int) -> Array:
    """Return ``count`` directions of equal weight over the half turn [rad], the cells' middles.

    Raises
    ------
    ConfigError
        If the count is not a whole number of at least one.
    """
    refuse_no_count("count", count)
    return np.pi * ((np.arange(count) + 0.5) / count - 0.5)


class Turning(Protocol):
    """Fibers' angles along a path, by whichever way they were followed."""

    @property
    def angle(self) -> Array:
        """Angle [rad] from the x axis, continuous in time, shape (..., n_angles, n)."""

    @property
    def spin(self) -> Array:
        """Rate of the angle [1/s], shape (..., n_angles, n)."""

    @property
    def path(self) -> FlowHistory:
        """What they were followed along."""


@runtime_checkable
class SpatialTurning(Protocol):
    """Fibers' angles along a path that may leave the plane."""

    @property
    def angle(self) -> Array:
        """Angle [rad] of a fiber seen along z from the x axis, shape (..., n_angles, n)."""

    @property
    def elevation(self) -> Array:
        """Angle out of the plane of x and y [rad], shape (..., n_angles, n)."""


@dataclass(frozen=True, eq=False)
class Motion:
    """The angles of fibers along a path.

    Parameters
    ----------
    initial_angles : (n_angles,) array
        Angles at the start [rad] from the x axis.
    angle : (..., n_angles, n) array
        Angles [rad], continuous in time: a tumbling fiber goes on counting.
    deformation : Propagator
        ``F`` with ``p = F p_0/|F p_0|``, leading shape (..., n).
    spin : (..., n_angles, n) array
        ``theta_dot`` [1/s].
    substeps : int
        Largest number of sub-steps that an interval took.
    path : FlowHistory
        What the fibers were followed along.
    """

    initial_angles: Array
    angle: Array
    deformation: Propagator
    spin: Array
    substeps: int
    path: FlowHistory = field(repr=False)


@overload
def follow(
    path: FlowHistory,
    shape_factor: float,
    initial_angles: ArrayLike,
    tolerance: float = ...,
) -> Motion: ...


@overload
def follow(
    path: FlowHistory,
    shape_factor: ThinningResponse,
    initial_angles: ArrayLike,
    tolerance: float = ...,
) -> ThinningMotion: ...


def follow(
    path: FlowHistory,
    shape_factor: float | ThinningResponse,
    initial_angles: ArrayLike,
    tolerance: float = ANGLE_TOLERANCE,
) -> Motion | ThinningMotion:
    """Follow fibers along a path from all initial angles at once.

    Parameters
    ----------
    path : FlowHistory
        One path (n points) or several of equal length (leading axis).
    shape_factor : float or ThinningResponse
        ``B`` [-] of the confined fiber, or Jeffery's ``xi``; in a melt that thins, the fiber's
        table (`fibermelt.fiber.thinning_motion`; no tolerance below 1e-6 is worth its steps there).
    initial_angles : (n_angles,) array_like
        Angles from the x axis at the start [rad]; any number.
    tolerance : float
        Angle error of the time integration over the whole path [rad], by halving: a bound on the
        local errors' sum for the interpolated gradient. The rounding of ``F`` adds
        ``1e-16 |F|/|F p_0|``, which matters only for a start within ``1e-8`` of the direction from
        which all others flee, after a stretch by ``1e8``.

    Returns
    -------
    Motion or ThinningMotion
        Angles (..., n_angles, n), starting exactly at ``initial_angles``.

    Raises
    ------
    ConfigError
        If the path is none, or an angle, the shape factor or the tolerance is not usable.
    ConvergenceError
        If an interval needs more than ``2**16`` sub-steps.
    """
    angles = checked_angles(initial_angles)
    if isinstance(shape_factor, ThinningResponse):
        return follow_thinning(path, shape_factor, angles, max(tolerance, TABLE_TOLERANCE))
    deformation, substeps = deformation_along(path, shape_factor, tolerance)
    return turned(path, shape_factor, angles, deformation, substeps)


def deformation_along(
    path: FlowHistory, shape_factor: float, tolerance: float = ANGLE_TOLERANCE
) -> tuple[Propagator, int]:
    """Return the map ``F`` from the start of a path to each of its points, leading shape (..., n).

    The last one is kept at hand: any number of initial angles shares it. Parameters and errors as
    in `follow`; second comes the largest number of sub-steps of an interval. With the tolerance
    `UNCHECKED` each interval is stepped through once, at half the cost.
    """
    checked_path(path)
    factor = checked_number("shape_factor", shape_factor)
    if tolerance != UNCHECKED:
        tolerance = checked_positive("tolerance", tolerance, "rad", "1e-8")
    return _deformation(path, factor, tolerance)


@lru_cache(maxsize=1)
def _deformation(
    path: FlowHistory, shape_factor: float, tolerance: float
) -> tuple[Propagator, int]:
    """Return what `deformation_along` does; everybody gets the same arrays, so nobody writes."""
    steps, substeps = interval_propagators(path, shape_factor, tolerance)
    return cumulate(steps).read_only(), substeps


def turned(
    path: FlowHistory, shape_factor: float, angles: Array, deformation: Propagator, substeps: int
) -> Motion:
    """Return the motion of fibers whose path's `deformation_along` is known."""
    at_angles = Propagator(
        deformation.matrix[..., None, :, :, :],
        deformation.scale[..., None, :],
        deformation.turn[..., None, :],
    )
    angle = at_angles.angles(angles[:, None])
    angle[..., 0] = angles
    return Motion(angles, angle, deformation, _spin(path, shape_factor, angle), substeps, path)


def checked_angles(initial_angles: ArrayLike) -> Array:
    """Return initial angles as an array, or refuse them (`ConfigError`)."""
    angles = np.array(real_array("initial_angles", initial_angles))
    if angles.ndim != 1 or angles.size == 0 or not np.all(np.isfinite(angles)):
        msg = f"initial_angles = {angles}: must be a list of finite angles in radians"
        raise ConfigError(msg)
    return angles


def _spin(path: FlowHistory, shape_factor: float, angle: Array) -> Array:
    """Return ``theta_dot = W_21 + B D_12(local)`` [1/s], the paper's Eq. 59."""
    L = path.plane_gradient
    size, double = strain_polar(L)
    melt = 0.5 * (L[..., 1, 0] - L[..., 0, 1])
    local = np.sin(double[..., None, :] - 2.0 * angle)
    spin: Array = melt[..., None, :] + shape_factor * size[..., None, :] * local
    return spin


def angle_to_stream(path: FlowHistory, motion: Turning) -> Array:
    """Return the fibers' angles to the streamline [rad], (..., n_angles, n).

    In a planar flow those seen along z, in (-pi/2, pi/2]; on a path in space those between a fiber
    and the velocity, in [0, pi/2]. A melt at rest has the x axis for its direction.

    Raises
    ------
    HistoryError
        If the fibers were followed along another path.
    """
    refuse_another_path(path, motion.path)
    if not path.planar and isinstance(motion, SpatialTurning):
        stream = _stream(path.velocity)[..., None, :, :]
        return _angle_between(raised_directions(motion.angle, motion.elevation), stream)
    return fold_angle(motion.angle - path.direction[..., None, :])


def _stream(velocity: Array) -> Array:
    """Return the directions of velocities; at rest, the x axis."""
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    moves = speed > 0.0
    return np.where(moves, velocity, [1.0, 0.0, 0.0]) / np.where(moves, speed, 1.0)


def _angle_between(fiber: Array, stream: Array) -> Array:
    """Return the angle between a fiber, whose ends are alike, and a direction [rad]."""
    across = np.linalg.norm(np.cross(fiber, stream), axis=-1)
    return np.asarray(np.arctan2(across, np.abs(np.einsum("...i,...i->...", fiber, stream))))


def angle_to_stream_at(path: FlowHistory, motion: Turning, times: ArrayLike) -> Array:
    """Return the fibers' angles to the streamline at given times [rad] in (-pi/2, pi/2].

    Parameters
    ----------
    path, motion
        What `follow` was given, and what it returned.
    times : (..., k) array_like
        Times on the path [s], such as those at which the zones are reached.

    Returns
    -------
    (..., n_angles, k) array
        By cubic Hermite interpolation of the angle (its rate is known) and linear interpolation
        of the velocity's direction. On a path in space, of which see `angle_to_stream`, both
        directions are those between the neighbours' on a straight line.

    Raises
    ------
    ConfigError
        If a time lies outside the path, or there is no list of them.
    HistoryError
        If the fibers were followed along another path.
    """
    refuse_another_path(path, motion.path)
    time = path.time
    times = real_array("times", times, duration=True)
    if times.ndim == 0:
        msg = f"times = {times}: must be a list, e.g. [{times}]"
        raise ConfigError(msg)
    # so that what is not a number is refused, too
    if not np.all((times >= time[..., :1]) & (times <= time[..., -1:])):
        msg = f"times = {times}: outside the path, {time[..., 0].min()} to {time[..., -1].max()} s"
        raise ConfigError(msg)
    after = (time[..., None, :] <= times[..., :, None]).sum(axis=-1)
    index = np.clip(after - 1, 0, time.shape[-1] - 2)
    t0 = np.take_along_axis(time, index, -1)
    step = np.take_along_axis(time, index + 1, -1) - t0
    u = ((times - t0) / step)[..., None, :]
    if not path.planar and isinstance(motion, SpatialTurning):
        return _between_points(path, motion, index, u)
    stream = path.direction
    stream0 = np.take_along_axis(stream, index, -1)
    direction = stream0 + u[..., 0, :] * (np.take_along_axis(stream, index + 1, -1) - stream0)
    shape = (*motion.angle.shape[:-1], times.shape[-1])
    at = np.broadcast_to(index[..., None, :], shape)
    a0, a1 = (np.take_along_axis(motion.angle, at + k, -1) for k in (0, 1))
    w0, w1 = (np.take_along_axis(motion.spin, at + k, -1) * step[..., None, :] for k in (0, 1))
    bend, twist = 3.0 * (a1 - a0) - 2.0 * w0 - w1, w0 + w1 - 2.0 * (a1 - a0)
    angle = a0 + u * (w0 + u * (bend + u * twist))
    return fold_angle(angle - direction[..., None, :])


def _between_points(
    path: FlowHistory, motion: SpatialTurning, index: NDArray[np.intp], part: Array
) -> Array:
    """Return angles to the streamline on paths in space, at parts of the intervals named."""
    fiber = raised_directions(motion.angle, motion.elevation)
    stream = _stream(path.velocity)[..., None, :, :]
    at = index[..., None, :, None]
    ends = []
    for values in (fiber, stream):
        first, second = (np.take_along_axis(values, at + k, -2) for k in (0, 1))
        between = first + part[..., None] * (second - first)
        ends.append(between / np.linalg.norm(between, axis=-1, keepdims=True))
    return _angle_between(*ends)
