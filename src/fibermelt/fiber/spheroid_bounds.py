"""The worst pressure over every direction of a spheroid, in closed form.

The surface pressure at normal ``n`` of a spheroid of director ``p`` is linear in the strain rate,
``(p - p_inf)/mu = G : D``. With ``n = cos(alpha) p + sin(alpha) m``, ``m`` a unit vector across,

    G = (c_o - c_a cos^2) p p - c_s sin cos (p m + m p) - c_t sin^2 m m,

whose eigenvalues are ``M + R``, ``M - R`` and 0, functions of ``x = cos 2 alpha`` in [-1, 1] alone:

    2 M = c_o - (c_a + c_t)/2 - (c_a - c_t) x/2,
    4 R^2 = (c_o - (c_a - c_t)/2 - (c_a + c_t) x/2)^2 + c_s^2 (1 - x^2).

Turning ``p`` and ``m`` turns ``G``; by von Neumann's trace inequality the largest ``G : D`` over
all turns pairs the eigenvalues of ``G`` and ``D`` in order. With those of ``D``, ``d_1 >= d_2 >=
d_3`` of sum zero, the bound is therefore the maximum of ``-d_k M(x) + (d_i - d_j) R(x)``, ``d_i >=
d_j``, over ``x`` and over the eigenvalue ``d_k`` that meets the 0. The discriminant of ``4 R^2`` is
``4 c_s^2 (c_s^2 - (c_a - c_o)(c_t + c_o))``, never positive for a spheroid (zero for the sphere):
``R`` is convex, and the maximum lies at an end. Fibers that see the worst lie along a principal
axis of the strain, and see it at the tips (``x = 1``) or on the equator (``x = -1``):

    tips:     -(c_a - c_o) d_3,
    equator:  c_o, 0 and -c_t, in order, times d_1, d_2 and d_3.

The direction that suffers least lies in the plane of the strongest stretching and compression (so
the tests find among all directions; there is no proof here). There, at an angle ``theta`` from the
first, ``y = cos 2 theta``, ``h = (d_1 - d_3)/2`` and ``m = (d_1 + d_3)/2``, the highest pressure is
the larger of ``c_o s - c_t d_2`` and

    c_o s - (c_a s + c_t (d_1 + d_3 - s))/2 + R(y),     s = m + h y,
    R^2 = ((c_a - c_t) m + (c_a + c_t) h y)^2/4 + c_s^2 h^2 (1 - y^2),

``s = p.D p``. The discriminant of ``R^2`` is ``c_s^2 h^2 ((c_a - c_t)^2 m^2 - ((c_a + c_t)^2 - 4
c_s^2) h^2)``, never positive as ``|m| <= h/3`` and ``c_s^2 <= c_a c_t``: both are convex in ``y``,
and the least of the larger is found by the golden section.

Reference: Mirsky 1975, doi 10.1007/BF01647331 (von Neumann's inequality).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["mildest_pressure", "orientation_bound"]

Array = NDArray[np.float64]

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)

NARROWINGS = 50
"""Of the interval [-1, 1] to 1e-10: a smooth minimum is then exact to rounding, the kink between
two branches to 1e-10 of the pressure."""


def orientation_bound(constants: tuple[float, float, float], low: Array, high: Array) -> Array:
    """Return the highest ``(p - p_inf)/mu`` [1/s] over all directions and the whole surface.

    The lowest one is minus that of the reversed flow.

    Parameters
    ----------
    constants : three floats
        ``c_a, c_t, c_o`` of an unbounded spheroid: the module's inequality is not asked again.
    low, high : (...) array
        Lowest and highest eigenvalue of ``D`` [1/s]; the third makes the sum zero.
    """
    axial, transverse, offset = constants
    least, middle, most = sorted((offset, 0.0, -transverse))
    tips = (offset - axial) * low
    equator = most * high - middle * (low + high) + least * low
    return np.asarray(np.maximum(tips, equator))


def mildest_pressure(
    constants: tuple[float, float, float, float], low: Array, high: Array
) -> Array:
    """Return the highest ``(p - p_inf)/mu`` [1/s] over the surface in the mildest direction.

    The lowest one is minus that of the reversed flow.

    Parameters
    ----------
    constants : four floats
        ``c_a, c_s, c_t, c_o`` of an unbounded spheroid.
    low, high : (...) array
        Lowest and highest eigenvalue of ``D`` [1/s]; the third makes the sum zero.
    """
    axial, shear, transverse, offset = constants
    middle, half = 0.5 * (high + low), 0.5 * (high - low)

    def highest(y: Array) -> Array:
        stretch = middle + half * y
        across = 2.0 * middle - stretch
        difference = 0.5 * (axial * stretch - transverse * across)
        root = np.sqrt(difference**2 + (shear * half) ** 2 * np.maximum(1.0 - y * y, 0.0))
        pair = root - 0.5 * (axial * stretch + transverse * across)
        return np.asarray(offset * stretch + np.maximum(pair, 2.0 * transverse * middle))

    left, right = -np.ones_like(middle), np.ones_like(middle)
    for _ in range(NARROWINGS):
        first, second = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
        falls = highest(first) > highest(second)
        left, right = np.where(falls, first, left), np.where(falls, right, second)
    return highest(0.5 * (left + right))
