"""Named sets of directions, and Jeffery's orbits in simple shear.

In ``u_x = gamma_dot y`` the director is along ``(C r_e cos k, -C sin k, 1)``: the phase ``k`` grows
at the even rate ``gamma_dot/(r_e + 1/r_e)`` and the orbit constant ``C`` stays, from 0 (a log
rolling about the vorticity axis z) to infinity (tumbling in the plane of shear). Jeffery 1922,
doi 10.1098/rspa.1922.0078; ``C`` as in Leal and Hinch 1971, doi 10.1017/S0022112071000788.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, refuse_no_count
from fibermelt.fiber.checks import (
    checked_finite,
    checked_number,
    checked_positive,
    checked_unit,
)

__all__ = [
    "equal_area_directions",
    "even_frames",
    "jeffery_director",
    "orbit_constant",
    "orbit_phase",
    "planar_directions",
    "raised_directions",
]

Array = NDArray[np.float64]

GOLDEN_TURN = math.pi * (3.0 - math.sqrt(5.0))
"""The golden section of a full turn [rad]."""

PLASTIC_PART = 0.7548776662466927
"""The inverse of the plastic ratio, the real root of ``x^3 = x + 1``: with it the turns about the
axis are even, and do not follow the golden ones."""


def planar_directions(angles: ArrayLike) -> Array:
    """Return directions in the plane of the flow at angles from the x axis [rad], (..., 3).

    With `fibermelt.fiber.paper_angles` they are the paper's 13 (section 3).

    Raises
    ------
    ConfigError
        If an angle is not finite.
    """
    theta = checked_finite("angles", angles)
    return np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], axis=-1)


def raised_directions(angle: Array, elevation: Array) -> Array:
    """Return directions from their angle seen along z and elevation out of the plane, (..., 3).

    Parameters
    ----------
    angle, elevation : (...) array
        From the x axis, and from the plane of x and y [rad].
    """
    across = np.cos(elevation)
    parts = [across * np.cos(angle), across * np.sin(angle), np.sin(elevation)]
    return np.stack(parts, axis=-1)


def equal_area_directions(count: int, *, whole_sphere: bool = False) -> Array:
    """Return directions that stand for equal areas, the Fibonacci lattice, (count, 3).

    Heights are the middles of equal parts of the z axis (equal zones, by Archimedes), azimuths
    golden sections of the turn apart. The upper half is enough for fibers, whose two ends are
    alike; averages over it converge like ``1/count``.

    Parameters
    ----------
    count : int
        Number of directions, at least 1.
    whole_sphere : bool
        Whether both halves are covered.

    References
    ----------
    Gonzalez 2010, doi 10.1007/s11004-009-9257-x.
    """
    refuse_no_count("count", count)
    part = (np.arange(count) + 0.5) / count
    z = 1.0 - 2.0 * part if whole_sphere else 1.0 - part
    azimuth = GOLDEN_TURN * np.arange(count)
    across = np.sqrt((1.0 - z) * (1.0 + z))
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), z], axis=-1)


def even_frames(count: int) -> Array:
    """Return right-handed body axes spread over all rotations, (count, 3, 3), one axis a column.

    The first axes are `equal_area_directions`, the turns about them, over half a turn as a body of
    three axes looks the same after one, multiples of the plastic ratio's part.

    Parameters
    ----------
    count : int
        Number of frames, at least 1.
    """
    p = equal_area_directions(count)
    across = np.eye(3)[np.argmin(np.abs(p), axis=1)]
    second = np.cross(p, across)
    second /= np.linalg.norm(second, axis=1, keepdims=True)
    turn = np.pi * (PLASTIC_PART * (np.arange(count) + 0.5) % 1.0)[:, None]
    second = np.cos(turn) * second + np.sin(turn) * np.cross(p, second)
    return np.stack([p, second, np.cross(p, second)], axis=-1)


def orbit_constant(direction: ArrayLike, aspect_ratio: float) -> Array:
    """Return Jeffery's orbit constant ``C`` [-] in ``u_x = gamma_dot y``, (...).

    ``sqrt(p_y^2 + p_x^2/r_e^2)/|p_z|``; infinite in the plane of shear.

    Parameters
    ----------
    direction : (..., 3) array_like
        Unit vectors.
    aspect_ratio : float
        ``r_e`` [-].

    Raises
    ------
    ConfigError
        If a direction is not a unit vector, or the aspect ratio not positive.
    """
    p = checked_unit(direction)
    r = checked_positive("fiber.aspect_ratio", aspect_ratio, "", "6")
    inside = np.hypot(p[..., 0] / r, p[..., 1])
    height = np.abs(p[..., 2])
    flat = height == 0.0
    return np.where(flat, np.inf, inside / np.where(flat, 1.0, height))


def orbit_phase(direction: ArrayLike, aspect_ratio: float) -> Array:
    """Return Jeffery's phase ``k`` [rad] in (-pi, pi], (...), zero along the flow.

    It is told from the end of the fiber that points to ``z >= 0``. Parameters and
    errors as in `orbit_constant`.
    """
    p = checked_unit(direction)
    r = checked_positive("fiber.aspect_ratio", aspect_ratio, "", "6")
    sign = np.where(p[..., 2] < 0.0, -1.0, 1.0)
    return np.asarray(np.arctan2(-sign * p[..., 1], sign * p[..., 0] / r))


def jeffery_director(
    time: ArrayLike, shear_rate: float, aspect_ratio: float, direction: ArrayLike
) -> Array:
    """Return the director in ``u_x = gamma_dot y`` in closed form, ``time.shape + (3,)``.

    Parameters
    ----------
    time : array_like
        Time since the start [s].
    shear_rate : float
        ``gamma_dot`` [1/s].
    aspect_ratio : float
        ``r_e`` [-], positive.
    direction : (3,) array_like
        Unit vector at time zero.

    Raises
    ------
    ConfigError
        If it is not a unit vector, or more than one, the aspect ratio not positive, or a number not
        finite.
    """
    p = checked_unit(direction)
    if p.shape != (3,):
        msg = f"direction has shape {p.shape}, expected (3,): one at a time"
        raise ConfigError(msg)
    r = checked_positive("fiber.aspect_ratio", aspect_ratio, "", "6")
    rate = checked_number("shear_rate", shear_rate)
    k = rate * checked_finite("time", time, duration=True) / (r + 1.0 / r)
    x, y = p[..., 0] / r, p[..., 1]
    turned = np.stack(
        [
            r * (x * np.cos(k) + y * np.sin(k)),
            y * np.cos(k) - x * np.sin(k),
            np.broadcast_to(p[..., 2], k.shape),
        ],
        axis=-1,
    )
    return np.asarray(turned / np.linalg.norm(turned, axis=-1, keepdims=True))
