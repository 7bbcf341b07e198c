"""An unbounded ellipse in closed form: Jeffery's motion and pressure in two dimensions.

Plane Stokes flow has ``u + i v = f(z) - z conj(f'(z)) - conj(g(z))`` and ``p = -4 mu Re f'(z)``
with ``f, g`` analytic (``z = x + i y``; the divergence ``2 Re`` of the z-derivative vanishes
identically, and ``4 mu d_z d_zbar (u + i v) = 2 d_zbar p`` is the momentum balance). In the fiber's
axes the far field is ``E conj(z) + i W z``, ``E = D_11 + i D_12``; the fiber turns at ``w``. With

    z = c (q + m/q),   c = (a + b)/2,   m = (a - b)/(a + b),   surface q = exp(i s),

take ``f = c A/q``, so ``f' = -A/(q^2 - m)``. No slip on ``|q| = 1``, where ``conj(q) = 1/q``, gives

    g = c [ (conj(E) + conj(A) - i (W - w) m) q + (conj(E) m - i (W - w))/q
            + A (1 + m q^2)/(q (q^2 - m)) ],

analytic outside. It vanishes at infinity if ``A = -(E + i (W - w) m)``, and the torque is the
imaginary part of its ``1/z`` coefficient, ``-D_12 m - (W - w) + m Im A``: zero for
``w = W + xi D_12``, ``xi = 2 m/(1 + m^2) = (a^2 - b^2)/(a^2 + b^2)``, Jeffery's shape factor. Then

    p - p_inf = 4 mu Re[A/(q^2 - m)],   A = -(D_11 + i D_12 2 a b/(a^2 + b^2)).

``1/(q^2 - m)`` runs over a circle (centre ``m/(1 - m^2)``, radius ``1/(1 - m^2)``), so the extremes
over the surface are elementary too. References: Jeffery 1922, doi 10.1098/rspa.1922.0078; the
paper's Eq. 23-25 and 48-59, whose signs and halves are put right: ``D`` has its 1/2 throughout, the
``gamma_0`` under ``A`` in Eq. 58 is Jeffery's ``gamma_0''``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.checks import (
    checked_finite,
    checked_number,
    checked_positive,
    refuse_too_slender,
)
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.shape import Ellipse

__all__ = [
    "ellipse_extremes",
    "ellipse_pressure",
    "jeffery_angle",
    "jeffery_period",
    "surface_points",
    "unbounded_ellipse",
]

Array = NDArray[np.float64]

MOST_SLENDER = 1e4
"""Aspect ratio beyond any fiber's: a million surface points carry its harmonics. The table that
pressures along paths are read from ends before (`fibermelt.fiber.support`)."""

HARMONIC_TOLERANCE = 1e-16
"""Size of the first harmonic ``m^k`` that the surface points need not carry."""


def ellipse_pressure(
    aspect_ratio: float, strain_11: ArrayLike, strain_12: ArrayLike, surface: ArrayLike
) -> Array:
    """Return ``(p - p_inf)/mu`` [1/s] on a torque-free unbounded ellipse.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], at least one.
    strain_11, strain_12 : array
        Components of ``D`` in the fiber's axes [1/s].
    surface : array
        Eccentric angle ``s`` [rad] of the point ``(a cos s, b sin s)``; broadcast with the strain.

    Raises
    ------
    ConfigError
        If the aspect ratio is below one, or a number is not finite; so for `ellipse_extremes`.
    """
    r = Ellipse(1.0, aspect_ratio).aspect_ratio
    m = (r - 1.0) / (r + 1.0)
    first, second = checked_finite("strain_11", strain_11), checked_finite("strain_12", strain_12)
    amplitude = -(first + 1j * second * _shear_part(r))
    where = checked_finite("surface", surface)
    pressure: Array = 4.0 * np.real(amplitude / (np.exp(2j * where) - m))
    return pressure


def ellipse_extremes(
    aspect_ratio: float, strain_11: ArrayLike, strain_12: ArrayLike
) -> tuple[Array, Array]:
    """Return the lowest and highest ``(p - p_inf)/mu`` [1/s] over an unbounded ellipse's surface.

    ``-(r - 1/r) D_11 -+ (r + 2 + 1/r) |A|``, from the circle that ``1/(q^2 - m)`` runs over.

    Parameters
    ----------
    aspect_ratio : float
        ``r = r_e`` [-], at least one.
    strain_11, strain_12 : array
        Components of ``D`` in the fiber's axes [1/s].
    """
    r = Ellipse(1.0, aspect_ratio).aspect_ratio
    first, second = checked_finite("strain_11", strain_11), checked_finite("strain_12", strain_12)
    middle = -(r - 1.0 / r) * first
    radius = (r + 2.0 + 1.0 / r) * np.hypot(first, _shear_part(r) * second)
    return middle - radius, middle + radius


def unbounded_ellipse(fiber: Ellipse) -> FiberResponse:
    """Return the response of an ellipse in an unbounded melt, exact to rounding.

    Parameters
    ----------
    fiber : Ellipse
        The fiber; its size does not matter.

    Raises
    ------
    ConfigError
        If it is none, or more slender than `MOST_SLENDER`.
    """
    refuse_other("fiber", fiber, Ellipse)
    r = fiber.aspect_ratio
    surface = surface_points(r)
    half = surface[: surface.size // 2]
    one, none = np.ones_like(half), np.zeros_like(half)
    columns = [ellipse_pressure(r, one, none, half), ellipse_pressure(r, none, one, half)]
    basis = np.tile(np.stack(columns, axis=-1), (2, 1))
    return FiberResponse(r, fiber.jeffery_factor, surface, basis)


def surface_points(aspect_ratio: float) -> Array:
    """Return the eccentric angles ``2 pi j/m`` [rad] that carry the harmonics of the pressure.

    Those of an ellipse fall off like ``m^k``, ``m = (r_e - 1)/(r_e + 1)``, of a spheroid's section
    likewise: the normal's angle has the same singularities.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], at least one.

    Raises
    ------
    ConfigError
        If it is above `MOST_SLENDER`.
    """
    refuse_too_slender(aspect_ratio, MOST_SLENDER)
    m = (aspect_ratio - 1.0) / (aspect_ratio + 1.0)
    harmonics = math.log(HARMONIC_TOLERANCE) / math.log(m) if m > 0.0 else 1.0
    points = 1 << max(6, math.ceil(math.log2(4.0 * harmonics + 4.0)))
    return 2.0 * np.pi * np.arange(points) / points


def jeffery_period(aspect_ratio: float, shear_rate: float) -> float:
    """Return the time of a full turn in simple shear, ``2 pi (r_e + 1/r_e)/gamma_dot`` [s].

    Eq. 24 of the paper, ``4 pi/(gamma_dot sqrt(1 - xi^2))``, written without its cancellation.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], positive.
    shear_rate : float
        ``gamma_dot`` [1/s]; its sign does not matter.

    Raises
    ------
    ConfigError
        If the aspect ratio is not positive, or the shear rate zero or not finite.
    """
    r = checked_positive("fiber.aspect_ratio", aspect_ratio, "", "6")
    rate = checked_number("shear_rate", shear_rate)
    if rate == 0:
        msg = "shear_rate = 0 1/s: a fiber in a melt at rest has no period; give a positive rate"
        raise ConfigError(msg)
    return 2.0 * math.pi * (r + 1.0 / r) / abs(rate)


def jeffery_angle(
    time: ArrayLike, shear_rate: float, aspect_ratio: float, initial_angle: float = 0.0
) -> Array:
    """Return the angle from the flow direction in ``u_x = gamma_dot y`` [rad], continuous in time.

    ``tan theta = -tan(k t - arctan(r_e tan theta_0))/r_e`` with ``k = gamma_dot/(r_e + 1/r_e)``
    solves ``theta_dot = (gamma_dot/2)(xi cos 2 theta - 1)``: Eq. 23 of the paper, which counts its
    angle from the gradient axis and the other way round.

    Parameters
    ----------
    time : array
        Time since the start [s].
    shear_rate : float
        ``gamma_dot`` [1/s].
    aspect_ratio : float
        ``r_e`` [-].
    initial_angle : float
        Angle at time zero [rad].

    Raises
    ------
    ConfigError
        If the aspect ratio is not positive, or a number not finite.
    """
    r = checked_positive("fiber.aspect_ratio", aspect_ratio, "", "6")
    rate = checked_number("shear_rate", shear_rate)
    start = checked_number("initial_angle", initial_angle)
    phase = _stretch(start, r) - rate * checked_finite("time", time, duration=True) / (r + 1.0 / r)
    return np.asarray(_stretch(phase, 1.0 / r))


def _stretch(angle: Array | float, factor: float) -> Array:
    """Return ``arctan(factor tan angle)`` on the angle's own branch."""
    turns = np.round(np.asarray(angle) / np.pi)
    rest = np.asarray(angle) - turns * np.pi
    stretched = np.arctan2(factor * np.sin(rest), np.cos(rest))
    return np.asarray(stretched + turns * np.pi)


def _shear_part(aspect_ratio: float) -> float:
    """Return ``2 a b/(a^2 + b^2) = sqrt(1 - xi^2)``."""
    return 2.0 * aspect_ratio / (aspect_ratio * aspect_ratio + 1.0)
