"""Velocity and pressure all around an unbounded ellipse, in closed form.

Derived in `fibermelt.fiber.jeffery`: in the fiber's axes, ``z = x + i y = c (q + m/q)`` with
``c = (a + b)/2``, ``m = (a - b)/(a + b)`` and the surface on ``|q| = 1``,

    u + i v = E conj(z) + i W z + f(z) - z conj(f'(z)) - conj(g(z)),   p - p_inf = -4 mu Re f',
    f = c A/q,   g = c [k/q + A (1 + m q^2)/(q (q^2 - m))],
    A = -(E + i (W - w) m),   k = conj(E) m - i (W - w),   E = D_11 + i D_12,

for any spin ``w``. Far away ``f ~ c^2 A/z`` and ``g ~ c^2 (k + A m)/z``: the disturbance falls like
``1/z``, no term ``log z`` means no force, and the imaginary part of ``g``'s coefficient is the
rotlet, hence the torque on the fiber,

    T = -2 pi mu [(a^2 + b^2)(w - W) - (a^2 - b^2) D_12],

zero for ``w = W + xi D_12``. The gradient follows by ``d_z`` and ``d_zbar`` of the same formula.
References: Jeffery 1922, doi 10.1098/rspa.1922.0078; the paper's Eq. 25, 48-58.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, refuse_no_number, refuse_other
from fibermelt.fiber.checks import checked_gradient, checked_number
from fibermelt.fiber.shape import Ellipse

__all__ = ["EllipseField", "ellipse_field", "ellipse_spin", "ellipse_torque"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

INSIDE_TOLERANCE = 1e-9
"""How far below one ``|q|`` may lie for a surface point: its rounding is ``1e-16 r_e``."""


@dataclass(frozen=True, eq=False)
class EllipseField:
    """The flow around an ellipse whose centre moves with the melt.

    Parameters
    ----------
    velocity : (..., 2) array
        Relative to the fiber's centre [m/s], along the axes of the flow.
    pressure : (...) array
        ``(p - p_inf)/mu`` [1/s].
    gradient : (..., 2, 2) array
        ``d u_i/d x_j`` [1/s]: the stress is ``mu (-pressure I + gradient + gradient^T)``.
    spin : float
        The fiber's angular velocity [1/s].
    torque : float
        Of the melt on the fiber, over ``mu`` and per depth [m2/s].
    """

    velocity: Array
    pressure: Array
    gradient: Array
    spin: float
    torque: float


def ellipse_spin(fiber: Ellipse, gradient: ArrayLike, angle: float) -> float:
    """Return the torque-free angular velocity ``W_21 + xi D_12`` [1/s] (the paper's Eq. 59).

    Parameters
    ----------
    fiber : Ellipse
        The fiber.
    gradient : (2, 2) array_like
        Velocity gradient of the far field [1/s].
    angle : float
        The fiber's angle from the x axis [rad].
    """
    refuse_other("fiber", fiber, Ellipse)
    strain, melt = _local(gradient, angle)
    return melt + fiber.jeffery_factor * strain.imag


def ellipse_torque(fiber: Ellipse, gradient: ArrayLike, angle: float, spin: float) -> float:
    """Return the torque on an ellipse that turns at ``spin``, over ``mu`` and depth [m2/s].

    ``-2 pi [(a^2 + b^2)(w - W) - (a^2 - b^2) D_12]``: positive turns it counter-clockwise.
    Parameters and errors as in `ellipse_field`.
    """
    spin = checked_number("spin", spin)
    refuse_other("fiber", fiber, Ellipse)
    strain, melt = _local(gradient, angle)
    a, b = fiber.half_length, fiber.semi_minor
    resist = (a * a + b * b) * (spin - melt)
    return -2.0 * math.pi * (resist - (a - b) * (a + b) * strain.imag)


def ellipse_field(
    fiber: Ellipse,
    gradient: ArrayLike,
    angle: float,
    points: ArrayLike,
    spin: float | None = None,
) -> EllipseField:
    """Return the flow around an ellipse in an unbounded melt, exact to rounding.

    Parameters
    ----------
    fiber : Ellipse
        The fiber, centred at the origin.
    gradient : (2, 2) array_like
        Velocity gradient of the far field, ``L[i, j] = d u_i/d x_j`` [1/s], without trace.
    angle : float
        The fiber's angle from the x axis [rad].
    points : (..., 2) array_like
        Where, from the fiber's centre along the axes of the flow [m]; on the surface or outside.
    spin : float, optional
        The fiber's angular velocity [1/s], counter-clockwise; torque-free if not given.

    Raises
    ------
    HistoryError
        If the gradient is not finite or has a trace.
    ConfigError
        If a point lies inside the fiber, or an angle, spin or point is not finite.
    """
    refuse_other("fiber", fiber, Ellipse)
    strain, melt = _local(gradient, angle)
    free = melt + fiber.jeffery_factor * strain.imag
    turning = free if spin is None else checked_number("spin", spin)
    a, b = fiber.half_length, fiber.semi_minor
    c, m = 0.5 * (a + b), (a - b) / (a + b)
    turn = complex(math.cos(angle), math.sin(angle))
    z, q = _preimage(real_array("points", points), turn, c, m)
    slip = 1j * (melt - turning)
    A = -(strain + slip * m)
    k = strain.conjugate() * m - slip
    square = q * q
    f1 = -A / (square - m)
    rate = square / (c * (square - m))  # dq/dz
    f2 = 2.0 * A * q / (square - m) ** 2 * rate
    cubic = q * (square - m)
    g = c * (k / q + A * (1.0 + m * square) / cubic)
    swing = 2.0 * m * q * cubic - (1.0 + m * square) * (3.0 * square - m)
    g1 = c * rate * (A * swing / cubic**2 - k / square)
    velocity = strain * z.conj() + 1j * melt * z + c * A / q - z * f1.conj() - g.conj()
    along = f1 - f1.conj() + 1j * melt
    across = (strain - z * f2.conj() - g1.conj()) * (turn * turn)
    return EllipseField(
        _components(velocity * turn),
        np.asarray(-4.0 * f1.real),
        np.stack([_components(along + across), _components(1j * (along - across))], axis=-1),
        turning,
        ellipse_torque(fiber, gradient, angle, turning),
    )


def _local(gradient: ArrayLike, angle: float) -> tuple[complex, float]:
    """Return ``D_11 + i D_12`` in the fiber's axes and ``W_21`` [1/s]."""
    L = checked_gradient(gradient, 2)
    refuse_no_number("angle", angle)
    if L.shape != (2, 2) or not math.isfinite(angle):
        msg = f"gradient of shape {L.shape}, angle = {angle:g}: one gradient and one finite angle"
        raise ConfigError(msg)
    strain = 0.5 * complex(L[0, 0] - L[1, 1], L[0, 1] + L[1, 0])
    back = complex(math.cos(2.0 * angle), -math.sin(2.0 * angle))
    return strain * back, 0.5 * float(L[1, 0] - L[0, 1])


def _preimage(points: Array, turn: complex, c: float, m: float) -> tuple[Complex, Complex]:
    """Return the points in the fiber's axes, ``z``, and ``q`` with ``z = c (q + m/q)``."""
    if points.shape[-1:] != (2,) or not np.all(np.isfinite(points)):
        msg = f"points of shape {points.shape}: must be finite, (..., 2)"
        raise ConfigError(msg)
    z = (points[..., 0] + 1j * points[..., 1]) * turn.conjugate()
    s = z / (2.0 * c)
    # two roots in place of sqrt(s^2 - m): the cut then runs between the foci, inside the fiber
    q = s + np.sqrt(s - math.sqrt(m)) * np.sqrt(s + math.sqrt(m))
    inside = np.abs(q) < 1.0 - INSIDE_TOLERANCE
    if np.any(inside):
        msg = (
            f"point {points[inside][0].tolist()} m lies inside the fiber (half-length "
            f"{c * (1.0 + m):g} m, half-width {c * (1.0 - m):g} m): there is no melt"
        )
        raise ConfigError(msg)
    return z, q


def _components(value: Complex) -> Array:
    return np.stack([value.real, value.imag], axis=-1)
