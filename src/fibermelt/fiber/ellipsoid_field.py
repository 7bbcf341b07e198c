"""Velocity and pressure all around a free ellipsoid in an unbounded melt.

The potentials of `fibermelt.fiber.ellipsoid`, written out for points outside. ``lambda >= 0`` is
the confocal ellipsoid through ``x``: ``sum x_i^2/(a_i^2 + lambda) = 1``. With ``V = a_1 a_2 a_3``,
``y_i = x_i/(a_i^2 + lambda)``, ``Delta^2 = prod (a_i^2 + lambda)``, integrals at ``lambda``, and
body axes (no sum over i; ``k`` summed),

    d_i Psi = -2 pi x_i I_i,    d_i lambda = 2 y_i/|y|^2,
    d_j d_k chi = 2 pi [delta_jk (...) - x_j x_k K_jk],
    4 mu (u - L x)_i = -2 a_i^2 I_ik T_ik x_k + x_i K_ik T_kk
                       - 2 V lambda (y . T y) y_i / (Delta |y|^2),
    p - p_inf = I_k T_kk/2 - V (y . T y)/(Delta |y|^2).

``T`` is taken without trace, so that what is large far away does not cancel. Far away the velocity
is the stresslet's, of order ``1/r^2``; the pressure falls like ``1/r^3``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError
from fibermelt.fiber.checks import checked_gradient, checked_unit
from fibermelt.fiber.ellipsoid import Ellipsoid, unbounded_ellipsoid
from fibermelt.fiber.ellipsoid_integrals import ellipsoid_integrals

__all__ = ["EllipsoidField", "body_axes", "ellipsoid_field"]

Array = NDArray[np.float64]

INSIDE_TOLERANCE = 1e-9
"""How far below one ``sum x_i^2/a_i^2`` may lie for a point of the surface: its rounding."""

STILL = 1e-15
"""Newton step over ``lambda + min a^2`` at which ``lambda`` stands still: rounding."""

MOST_STEPS = 100
"""Newton steps for ``lambda``: they rise monotonically; ten are the rule, more for thin bodies."""


@dataclass(frozen=True, eq=False)
class EllipsoidField:
    """The flow around a free ellipsoid whose centre moves with the melt.

    Parameters
    ----------
    velocity : (..., 3) array
        Relative to the centre [m/s], along the axes of the flow.
    pressure : (...) array
        ``(p - p_inf)/mu`` [1/s].
    angular_velocity : (3,) array
        The body's own [1/s], along the axes of the flow.
    """

    velocity: Array
    pressure: Array
    angular_velocity: Array


def body_axes(direction: ArrayLike) -> Array:
    """Return right-handed axes whose first one is a director, (3, 3), one axis a column.

    The other two are arbitrary, which a spheroid does not mind.

    Parameters
    ----------
    direction : (3,) array_like
        Unit vector [-].

    Raises
    ------
    ConfigError
        If it is not a unit vector, or more than one.
    """
    p = checked_unit(direction)
    if p.shape != (3,):
        msg = f"direction has shape {p.shape}, expected (3,): one at a time"
        raise ConfigError(msg)
    across = np.eye(3)[int(np.argmin(np.abs(p)))]
    second = np.cross(p, across)
    second /= np.linalg.norm(second)
    return np.stack([p, second, np.cross(p, second)], axis=-1)


def ellipsoid_field(
    body: Ellipsoid, gradient: ArrayLike, points: ArrayLike, axes: ArrayLike | None = None
) -> EllipsoidField:
    """Return the flow around a force- and torque-free ellipsoid, exact to rounding.

    Parameters
    ----------
    body : Ellipsoid
        The particle, centred at the origin.
    gradient : (3, 3) array_like
        Velocity gradient of the far field [1/s], without trace.
    points : (..., 3) array_like
        Where, from the centre along the axes of the flow [m]; on the surface or outside.
    axes : (3, 3) array_like, optional
        The body's axes as columns, orthonormal; those of the flow if not given.

    Raises
    ------
    HistoryError
        If the gradient is not finite or has a trace.
    ConfigError
        If a point lies inside the body or is not finite, or the axes are not orthonormal.
    """
    L = checked_gradient(gradient, 3)
    Q = np.eye(3) if axes is None else real_array("axes", axes)
    if Q.shape != (3, 3) or not np.allclose(Q.T @ Q, np.eye(3), rtol=0.0, atol=1e-10):
        msg = f"axes = {Q.tolist()}: must be three orthonormal columns (bound 1e-10)"
        raise ConfigError(msg)
    x = real_array("points", points)
    if L.shape != (3, 3) or x.shape[-1:] != (3,) or not np.all(np.isfinite(x)):
        msg = f"gradient of shape {L.shape}, points of shape {x.shape}: (3, 3) and finite (..., 3)"
        raise ConfigError(msg)
    response = unbounded_ellipsoid(body)
    own = Q.T @ L @ Q
    disturbance, pressure = _disturbance(
        response.semi_axes, response.surface_stress(own), (x @ Q).reshape(-1, 3)
    )
    return EllipsoidField(
        x @ L.T + (disturbance @ Q.T).reshape(x.shape),
        pressure.reshape(x.shape[:-1]),
        Q @ response.angular_velocity(own),
    )


def _disturbance(a: Array, stress: Array, x: Array) -> tuple[Array, Array]:
    """Return ``u - L x`` and ``(p - p_inf)/mu`` at points (n, 3), all in body axes."""
    T = stress - np.trace(stress) / 3.0 * np.eye(3)
    shift = _confocal(a, x)
    integrals = ellipsoid_integrals(a, shift)
    square = a * a
    outer = square + shift[:, None]
    y = x / outer
    # V/Delta as a product of ratios, so that micrometres do not underflow
    ratio = np.prod(a / np.sqrt(outer), axis=-1)
    pull = ratio * np.einsum("ni,ij,nj->n", y, T, y) / np.einsum("ni,ni->n", y, y)
    near = -2.0 * square * np.einsum("nik,ik,nk->ni", integrals.double, T, x)
    swell = x * (integrals.moment @ np.diag(T))
    velocity = 0.25 * (near + swell - 2.0 * (shift * pull)[:, None] * y)
    pressure = 0.5 * integrals.single @ np.diag(T) - pull
    return velocity, pressure


def _confocal(a: Array, x: Array) -> Array:
    """Return ``lambda`` [m2] of the confocal ellipsoids through points (n, 3).

    Newton's method on ``1/S - 1``, ``S = sum x_i^2/(a_i^2 + lambda)``: concave and rising, so that
    from a lower bound it climbs without overshooting; exact at once where one term rules.
    """
    square, point = a * a, x * x
    total = np.sum(point / square, axis=-1)
    inside = total < 1.0 - INSIDE_TOLERANCE
    if np.any(inside):
        msg = (
            f"point {x[inside][0].tolist()} m (body axes) lies inside the ellipsoid of semi-axes "
            f"{a.tolist()} m: there is no melt"
        )
        raise ConfigError(msg)
    shift = np.maximum(np.sum(point, axis=-1) - np.max(square), np.max(point - square, axis=-1))
    shift = np.where(total > 1.0, np.maximum(shift, 0.0), 0.0)
    for _ in range(MOST_STEPS):
        outer = square + shift[:, None]
        S = np.sum(point / outer, axis=-1)
        step = S * (S - 1.0) / np.sum(point / outer**2, axis=-1)
        step = np.where(total > 1.0, np.maximum(step, 0.0), 0.0)
        shift = shift + step
        if np.all(step <= STILL * (shift + np.min(square))):
            break
    return shift
