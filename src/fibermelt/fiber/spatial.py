"""Fibers in space: their motion along any path, and the extremes on their surface.

In a planar flow ``F_dot = (W + xi D) F`` leaves the z axis alone, so that a director is along
``(F q_0, p_z0)``: seen along z it turns like a fiber in the plane, and it rises out of the plane by
``tan(elevation) = p_z0/|F q_0|``. The motion in the plane (`fibermelt.fiber.follow`) is all there
is to compute. On a path in space spheroids are carried from point to point
(`fibermelt.fiber.directors`), ellipsoids of three axes on any path (`fibermelt.fiber.frames`). The
pressure is that of `fibermelt.fiber.spheroid` and `fibermelt.fiber.ellipsoid`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.checks import checked_unit
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.directions import equal_area_directions, raised_directions
from fibermelt.fiber.directors import DirectorMotion, follow_directors
from fibermelt.fiber.ellipsoid import EllipsoidResponse
from fibermelt.fiber.motion import ANGLE_TOLERANCE, follow
from fibermelt.fiber.paths import refuse_another_path
from fibermelt.fiber.pressure import PressureBounds, Viscosity, newtonian_viscosity
from fibermelt.fiber.propagator import Propagator
from fibermelt.fiber.spheroid import SpheroidResponse
from fibermelt.history import FlowHistory

__all__ = [
    "EllipsoidMotion",
    "SpatialMotion",
    "SpatialPressure",
    "angles_seen_along_z",
    "follow_spatial",
    "half_sphere",
    "spatial_bounds",
    "spatial_pressure",
    "spin_about_z",
    "turned_directions",
]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpatialMotion:
    """The directions of fibers along a path, in and out of the plane of x and y.

    Parameters
    ----------
    initial_directions : (n_directions, 3) array
        Unit vectors at the start.
    angle : (..., n_directions, n) array
        Angle from the x axis [rad] of the director seen along z, continuous in time.
    elevation : (..., n_directions, n) array
        Angle out of the plane [rad], in [-pi/2, pi/2]; in a planar flow its sign stays.
    spin : (..., n_directions, n) array
        Rate of ``angle`` [1/s]; zero for a fiber along z, which has no angle.
    path : FlowHistory
        What the fibers were followed along.
    """

    initial_directions: Array
    angle: Array
    elevation: Array
    spin: Array
    path: FlowHistory = field(repr=False)

    @property
    def direction(self) -> Array:
        """Return the unit vectors along the path, (..., n_directions, n, 3)."""
        return raised_directions(self.angle, self.elevation)


@dataclass(frozen=True, eq=False)
class EllipsoidMotion(SpatialMotion):
    """The frames of ellipsoids along a path; the director is the body's first axis.

    Parameters
    ----------
    second : (..., n_directions, n, 3) array
        The second axis, a unit vector at right angles to the first.
    substeps : int
        Largest number of sub-steps that an interval took.
    """

    second: Array
    substeps: int


@dataclass(frozen=True, eq=False)
class SpatialPressure:
    """Lowest and highest pressure on spheroids or ellipsoids along the way.

    Parameters
    ----------
    lowest, highest : (..., n_directions, n) array
        Over the surface, relative to the streamline's pressure [Pa].
    place_lowest, place_highest : (..., n_directions, n, 3) array
        Eccentric vectors of them along the axes of the flow, as in `SpheroidResponse.extremes`.
    motion : SpatialMotion
        The fibers' directions.
    """

    lowest: Array
    highest: Array
    place_lowest: Array
    place_highest: Array
    motion: SpatialMotion

    @property
    def path(self) -> FlowHistory:
        """Return what the fibers were followed along."""
        return self.motion.path

    def where_at(self, index: NDArray[np.intp]) -> Array:
        """Return the eccentric angles [rad] of the extremes at given points of the path.

        In (-pi/2, pi/2], 0 the tip. The sign is that of the side seen along z, as for a fiber in
        the plane; a place straight above or below the axis is positive.

        Parameters
        ----------
        index : (..., n_directions, location, 2) integer array
            Points of the path, last axis: for the lowest, for the highest.
        """
        sides = []
        for kind, places in enumerate((self.place_lowest, self.place_highest)):
            at = index[..., kind]
            place = np.take_along_axis(places, at[..., None], axis=-2)
            p = raised_directions(
                np.take_along_axis(self.motion.angle, at, axis=-1),
                np.take_along_axis(self.motion.elevation, at, axis=-1),
            )
            across = np.linalg.norm(np.cross(place, p), axis=-1)
            size = np.arctan2(across, np.einsum("...i,...i->...", place, p))
            left = p[..., 0] * place[..., 1] - p[..., 1] * place[..., 0]
            sides.append(np.where(left < 0.0, -size, size))
        return fold_angle(np.stack(sides, axis=-1))


def half_sphere(count: int, *, planar: bool = True) -> Array:
    """Return directions that stand for equal areas, in order of the angle seen along z, (count, 3).

    `equal_area_directions`, of which a fiber needs one half as its ends are alike, ``z > 0``. A
    planar flow does not tell above and below the plane apart either: ``x >= 0`` as well.

    Parameters
    ----------
    count : int
        Number of directions, at least 1.
    planar : bool
        Whether they are for planar flows.
    """
    p = equal_area_directions(count)
    if planar:
        p[:, :2] *= np.where(p[:, :1] < 0.0, -1.0, 1.0)
    return p[np.argsort(np.arctan2(p[:, 1], p[:, 0]))]


def follow_spatial(
    path: FlowHistory,
    shape_factor: float,
    directions: ArrayLike,
    tolerance: float = ANGLE_TOLERANCE,
) -> SpatialMotion:
    """Follow spheroids along a path from all initial directions at once.

    In the plane by `fibermelt.fiber.follow`, else by `fibermelt.fiber.follow_directors`: the same
    where both can be taken.

    Parameters
    ----------
    path : FlowHistory
        One path (n points) or several of equal length (leading axis).
    shape_factor : float
        ``xi`` [-].
    directions : (n_directions, 3) array_like
        Unit vectors at the start; for a planar path none along z, where it has no angle in the
        plane.
    tolerance : float
        Angle error in the plane, or in space, over the whole path [rad], as in `follow`.

    Raises
    ------
    ConfigError
        If a direction is no unit vector or along z, or as in `follow`.
    ConvergenceError
        As in `follow`.
    """
    refuse_other("path", path, FlowHistory)
    if not path.planar:
        turned = follow_directors(path, shape_factor, directions, tolerance)
        return _seen_along_z(path, shape_factor, turned)
    start = checked_unit(directions, "directions")
    if start.ndim != 2 or np.any((start[:, 0] == 0.0) & (start[:, 1] == 0.0)):
        msg = f"directions of shape {start.shape}: must be (n_directions, 3), none along z"
        raise ConfigError(msg)
    motion = follow(path, shape_factor, np.arctan2(start[:, 1], start[:, 0]), tolerance)
    image = np.einsum("...ij,kj->...ki", motion.deformation.matrix, start[:, :2])
    length = np.hypot(image[..., 0], image[..., 1])
    # F = exp(scale) G: the height shrinks instead, so that nothing overflows
    height = start[:, 2] * np.exp(-motion.deformation.scale)[..., None]
    elevation = np.swapaxes(np.arctan2(height, length), -1, -2)
    return SpatialMotion(start, motion.angle, np.ascontiguousarray(elevation), motion.spin, path)


def _seen_along_z(path: FlowHistory, shape_factor: float, turned: DirectorMotion) -> SpatialMotion:
    """Return the motion of directors in space by their angles."""
    p = turned.direction
    angle, elevation = angles_seen_along_z(p)
    # of W + xi D; what keeps the length has no part in the angle
    L = path.gradient
    A = 0.5 * ((1.0 + shape_factor) * L - (1.0 - shape_factor) * np.swapaxes(L, -1, -2))
    rate = np.einsum("...nij,...knj->...kni", A[..., :2, :], p)
    return SpatialMotion(turned.initial_directions, angle, elevation, spin_about_z(p, rate), path)


def angles_seen_along_z(p: Array) -> tuple[Array, Array]:
    """Return the angle seen along z, continuous in time, and the elevation of directions [rad].

    Parameters
    ----------
    p : (..., n, 3) array
        Unit vectors along a path; one along z is given the angle zero.
    """
    angle = np.unwrap(np.arctan2(p[..., 1], p[..., 0]), axis=-1)
    return angle, np.arctan2(p[..., 2], np.hypot(p[..., 0], p[..., 1]))


def spin_about_z(p: Array, rate: Array) -> Array:
    """Return the rate of the angle seen along z [1/s]; zero for a director along z.

    Parameters
    ----------
    p, rate : (..., 3) and (..., 2 or 3) array
        Unit vectors, and their rates [1/s], of which a multiple of ``p`` may be missing.
    """
    size = p[..., 0] ** 2 + p[..., 1] ** 2
    moment = p[..., 0] * rate[..., 1] - p[..., 1] * rate[..., 0]
    return np.asarray(np.where(size > 0.0, moment / np.where(size > 0.0, size, 1.0), 0.0))


def turned_directions(deformation: Propagator, start: Array) -> Array:
    """Return where directions are turned to, unit vectors (n_directions, n, 3), without the angles.

    Parameters
    ----------
    deformation : Propagator
        ``F`` in the plane along one path, leading shape (n,).
    start : (n_directions, 3) array
        Unit vectors at the start.
    """
    g = deformation.matrix
    turned = np.empty((len(start), len(g), 3))
    for k in range(2):
        turned[..., k] = np.outer(start[:, 0], g[:, k, 0]) + np.outer(start[:, 1], g[:, k, 1])
    # F = exp(scale) G: the height shrinks instead, so that nothing overflows
    turned[..., 2] = np.outer(start[:, 2], np.exp(-deformation.scale))
    turned /= np.sqrt(np.einsum("...i,...i->...", turned, turned))[..., None]
    return turned


def spatial_pressure(
    path: FlowHistory,
    body: SpheroidResponse | EllipsoidResponse,
    viscosity: Viscosity,
    motion: SpatialMotion,
) -> SpatialPressure:
    """Return the lowest and highest surface pressure of every fiber at every point of its path.

    Parameters
    ----------
    path : FlowHistory
        The path that the fibers were followed along.
    body : SpheroidResponse or EllipsoidResponse
        Their pressure response.
    viscosity : float, ViscosityLaw or LocalViscosity
        The melt, as in `fibermelt.fiber.surface_pressure`.
    motion : SpatialMotion
        Their directions along the path; an ellipsoid's is an `EllipsoidMotion`.

    Raises
    ------
    ConfigError
        If the viscosity is not positive, or the motion no ellipsoid's.
    HistoryError
        If the fibers were followed along another path.
    """
    refuse_another_path(path, motion.path)
    scale = newtonian_viscosity(viscosity, 0.5 * path.shear_rate[..., None, :])
    gradient = path.gradient[..., None, :, :, :]
    if isinstance(body, EllipsoidResponse):
        refuse_other("motion", motion, EllipsoidMotion)
        assert isinstance(motion, EllipsoidMotion)
        found = body.turned_extremes(gradient, motion.direction, motion.second)
    else:
        found = body.extremes(gradient, motion.direction)
    return SpatialPressure(
        scale * found.lowest,
        scale * found.highest,
        found.where_lowest,
        found.where_highest,
        motion,
    )


def spatial_bounds(
    path: FlowHistory, body: SpheroidResponse | EllipsoidResponse, viscosity: Viscosity
) -> PressureBounds:
    """Return the bounds of the pressure extremes over every direction in space, (..., n) [Pa].

    No direction is sampled; for a spheroid in a planar flow the worst are those of
    `fibermelt.fiber.pressure_bounds`.

    Parameters
    ----------
    path : FlowHistory
        One path or several.
    body : SpheroidResponse or EllipsoidResponse
        The fibers' response.
    viscosity : float, ViscosityLaw or LocalViscosity
        The melt, as in `fibermelt.fiber.surface_pressure`.

    Raises
    ------
    ConfigError
        If the viscosity is not positive.
    """
    refuse_other("path", path, FlowHistory)
    scale = newtonian_viscosity(viscosity, 0.5 * path.shear_rate)
    worst, mildest = body.bounds(path.gradient), body.mildest(path.gradient)
    return PressureBounds(*(scale * side for side in (*worst, *mildest)))
