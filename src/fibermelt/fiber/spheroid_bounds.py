"""The worst pressure over every direction of a spheroid, in closed form.

The surface pressure at normal ``n`` of a spheroid of director ``p`` is linear in the strain rate,
``(p - p_inf)/mu = G : D``. With ``n = cos(alpha) p + sin(alpha) m``, ``m`` a unit vector across,

    G = (c_o - c_a cos^2) p p - c_s sin cos (p m + m p) - c_t sin^2 m m,

whose eigenvalues are ``M + R``, ``M - R`` and 0, functions of ``x = cos 2 alpha`` in [-1, 1] alone:

    2 M = c_o - (c_a + c_t)/2 - (c_a - c_t) x/2,
    4 R^2 = (c_o - (c_a - c_t)/2 - (c_a + c_t) x/2)^2 + c_s^2 (1 - x^2).

Turning ``p`` and ``m`` turns ``G``; by von Neumann's trace inequality the largest ``G : D`` over
all turns pairs the eigenvalues of ``G`` and ``D`` in order. With those of ``D``, ``d_1 >= d_2 >=
d_3`` of sum zero, the bound is therefore the maximum of

    -d_k M(x) + (d_i - d_j) R(x),    d_i >= d_j,

over ``x`` and over the eigenvalue ``d_k`` that meets the 0. A straight line plus the root of a
quadratic: its maximum lies at an end or where the derivative vanishes, a quadratic in ``x``. Every
candidate is a pressure that occurs, so one too many does no harm.

Reference: von Neumann 1937; Mirsky 1975, doi 10.1007/BF01647331 (the inequality).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["orientation_bound"]

Array = NDArray[np.float64]


def orientation_bound(
    constants: tuple[float, float, float, float], low: Array, high: Array
) -> Array:
    """Return the highest ``(p - p_inf)/mu`` [1/s] over all directions and the whole surface.

    The lowest one is minus that of the reversed flow.

    Parameters
    ----------
    constants : four floats
        ``c_a, c_s, c_t, c_o`` of the spheroid.
    low, high : (...) array
        Lowest and highest eigenvalue of ``D`` [1/s]; the third makes the sum zero.
    """
    axial, shear, transverse, offset = constants
    line = 0.5 * (offset - 0.5 * (axial + transverse)), -0.25 * (axial - transverse)
    base = offset - 0.5 * (axial - transverse), -0.5 * (axial + transverse)
    # 4 R^2 = q0 + 2 h x + q2 x^2
    root = base[0] ** 2 + shear**2, base[0] * base[1], base[1] ** 2 - shear**2
    middle = -low - high
    best = np.full(np.shape(low), -np.inf)
    for meets, gap in ((high, middle - low), (middle, high - low), (low, high - middle)):
        ends = np.ones_like(best)
        for x in (-ends, ends, *_stationary(-meets * line[1], 0.5 * gap, root)):
            square = root[0] + x * (2.0 * root[1] + x * root[2])
            radius = 0.5 * np.sqrt(np.maximum(square, 0.0))
            best = np.maximum(best, gap * radius - meets * (line[0] + line[1] * x))
    return best


def _stationary(slope: Array, weight: Array, root: tuple[float, float, float]) -> list[Array]:
    """Return where ``slope x + weight sqrt(Q(x))`` may be stationary, moved into [-1, 1].

    ``Q = q0 + 2 h x + q2 x^2``: squaring ``slope sqrt(Q) = -weight (q2 x + h)`` gives
    ``q2 t x^2 + 2 h t x + weight^2 h^2 - slope^2 q0 = 0``, ``t = weight^2 q2 - slope^2``. Where it
    has no root, or the root lies outside, an end or another admissible point is returned.
    """
    q0, h, q2 = root
    t = weight * weight * q2 - slope * slope
    a, b, c = q2 * t, h * t, weight * weight * h * h - slope * slope * q0
    combined = -(b + np.where(b >= 0.0, 1.0, -1.0) * np.sqrt(np.maximum(b * b - a * c, 0.0)))
    candidates = []
    for above, below in ((combined, a), (c, combined)):
        safe = np.abs(above) < np.abs(below)
        x = np.where(safe, above / np.where(safe, below, 1.0), 1.0)
        candidates.append(x)
    return candidates
