"""Spheroids that leave the plane of a planar flow: their motion, and the extremes on their surface.

In a planar flow ``F_dot = (W + xi D) F`` leaves the z axis alone, so that a director is along
``(F q_0, p_z0)``: seen along z it turns like a fiber in the plane, and it rises out of the plane by
``tan(elevation) = p_z0/|F q_0|``. The motion in the plane (`fibermelt.fiber.follow`) is all there
is to compute; the pressure is that of `fibermelt.fiber.spheroid`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError
from fibermelt.fiber.checks import checked_unit
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.directions import equal_area_directions
from fibermelt.fiber.motion import ANGLE_TOLERANCE, follow
from fibermelt.fiber.paths import refuse_another_path, strain_polar
from fibermelt.fiber.pressure import Viscosity, newtonian_viscosity
from fibermelt.fiber.propagator import Propagator
from fibermelt.fiber.spheroid import SpheroidResponse
from fibermelt.history import FlowHistory

__all__ = [
    "SpatialMotion",
    "SpatialPressure",
    "follow_spatial",
    "half_sphere",
    "spatial_pressure",
    "turned_directions",
]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpatialMotion:
    """The directions of fibers along a path, in and out of the plane of its flow.

    Parameters
    ----------
    initial_directions : (n_directions, 3) array
        Unit vectors at the start.
    angle : (..., n_directions, n) array
        Angle from the x axis [rad] of the director seen along z, continuous in time.
    elevation : (..., n_directions, n) array
        Angle out of the plane [rad], in [-pi/2, pi/2]; its sign stays.
    spin : (..., n_directions, n) array
        Rate of ``angle`` [1/s].
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
        return _directions(self.angle, self.elevation)


@dataclass(frozen=True, eq=False)
class SpatialPressure:
    """Lowest and highest pressure on spheroids along the way.

    Parameters
    ----------
    lowest, highest : (..., n_directions, n) array
        Over the surface, relative to the streamline's pressure [Pa].
    place_lowest, place_highest : (..., n_directions, n, 3) array
        Eccentric vectors of them, as in `SpheroidResponse.extremes`.
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
            p = _directions(
                np.take_along_axis(self.motion.angle, at, axis=-1),
                np.take_along_axis(self.motion.elevation, at, axis=-1),
            )
            across = np.linalg.norm(np.cross(place, p), axis=-1)
            size = np.arctan2(across, np.einsum("...i,...i->...", place, p))
            left = p[..., 0] * place[..., 1] - p[..., 1] * place[..., 0]
            sides.append(np.where(left < 0.0, -size, size))
        return fold_angle(np.stack(sides, axis=-1))


def half_sphere(count: int) -> Array:
    """Return directions that stand for equal areas of the sphere, for a planar flow, (count, 3).

    `equal_area_directions`, with what a planar flow does not tell apart taken together (the two
    ends of a fiber, above and below the plane): ``x >= 0, z > 0``, by the angle seen along z.

    Parameters
    ----------
    count : int
        Number of directions, at least 1.
    """
    p = equal_area_directions(count)
    p[:, :2] *= np.where(p[:, :1] < 0.0, -1.0, 1.0)
    return p[np.argsort(np.arctan2(p[:, 1], p[:, 0]))]


def follow_spatial(
    path: FlowHistory,
    shape_factor: float,
    directions: ArrayLike,
    tolerance: float = ANGLE_TOLERANCE,
) -> SpatialMotion:
    """Follow spheroids along a path of planar flow from all initial directions at once.

    The same as `fibermelt.fiber.follow_directors`, which takes any flow and a step at a time.

    Parameters
    ----------
    path : FlowHistory
        One path (n points) or several of equal length (leading axis).
    shape_factor : float
        ``xi`` [-].
    directions : (n_directions, 3) array_like
        Unit vectors at the start, none along z: there it has no angle in the plane.
    tolerance : float
        Angle error in the plane over the whole path [rad], as in `follow`.

    Raises
    ------
    ConfigError
        If a direction is no unit vector or along z, or as in `follow`.
    ConvergenceError
        As in `follow`.
    """
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
    path: FlowHistory, spheroid: SpheroidResponse, viscosity: Viscosity, motion: SpatialMotion
) -> SpatialPressure:
    """Return the lowest and highest surface pressure of every spheroid at every point of its path.

    Parameters
    ----------
    path : FlowHistory
        The path that the fibers were followed along.
    spheroid : SpheroidResponse
        Their pressure response.
    viscosity : float, ViscosityLaw or LocalViscosity
        The melt, as in `fibermelt.fiber.surface_pressure`.
    motion : SpatialMotion
        Their directions along the path.

    Raises
    ------
    ConfigError
        If the viscosity is not positive.
    HistoryError
        If the fibers were followed along another path.
    """
    refuse_another_path(path, motion.path)
    size, _ = strain_polar(path.gradient)
    scale = newtonian_viscosity(viscosity, size[..., None, :])
    gradient = path.gradient[..., None, :, :, :]
    found = spheroid.extremes(gradient, motion.direction)
    return SpatialPressure(
        scale * found.lowest,
        scale * found.highest,
        found.where_lowest,
        found.where_highest,
        motion,
    )


def _directions(angle: Array, elevation: Array) -> Array:
    """Return unit vectors from angle and elevation [rad], (..., 3)."""
    across = np.cos(elevation)
    parts = [across * np.cos(angle), across * np.sin(angle), np.sin(elevation)]
    return np.stack(parts, axis=-1)
