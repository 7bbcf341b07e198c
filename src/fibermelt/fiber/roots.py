"""Roots of many functions of one variable at once, each kept between its brackets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["bracketed_roots"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

MOST_STEPS = 200
"""Steps of the search: bisection alone halves the widest bracket to rounding in 53, plus its own
detours."""


def bracketed_roots(
    function: Callable[[Array, Index], Array],
    low: Array,
    high: Array,
    ends: tuple[Array, Array],
    tolerance: float | Array,
    *,
    smooth: bool = False,
) -> Array:
    """Return where functions pass from negative to positive, (n,).

    Inverse quadratic interpolation where three points allow it, bisection elsewhere (Chandrupatla
    1997, doi 10.1016/S0965-9978(96)00051-8). A zero counts as negative: where a function vanishes
    over an interval, its upper end is found.

    Parameters
    ----------
    function : callable
        From values (m,) and which functions they are for (m,) to the functions' values (m,).
    low, high : (n,) array
        Brackets; where they coincide, that is the root.
    ends : pair of (n,) arrays
        Functions' values there. If both are positive the low end is found, if none is the high one.
    tolerance : float or (n,) array
        Largest width of the bracket at the end, positive.
    smooth : bool
        Whether a step of the interpolation below the tolerance ends the search, too, and a zero.
        Where a function has kinks, or vanishes over an interval, they tell nothing.
    """
    root = np.array(high, dtype=np.float64)
    at = np.arange(root.size)
    # x1 is the newest point, x2 the other end of the bracket, x3 what x1 replaced
    f1, f2 = np.array(ends[1]), np.array(ends[0])
    x1 = np.where(f2 > 0.0, low, high)
    x2 = np.where(f1 > 0.0, low, high)
    near = np.broadcast_to(np.asarray(tolerance, dtype=np.float64), root.shape)
    t = _regula_falsi(f1, f2)
    parabolic = np.zeros(root.shape, dtype=np.bool_)
    for _ in range(MOST_STEPS):
        wide = np.abs(x1 - x2)
        small = parabolic & (np.abs(t) * wide < near)
        found = f1 == 0.0 if smooth else small
        best = np.where(np.abs(f1) < np.abs(f2), x1, x2)
        root[at] = np.where(small, x1 + t * (x2 - x1), best)
        going = (wide > near) & ~(small | found)
        if not np.all(going):
            at, near, t, wide = at[going], near[going], t[going], wide[going]
            x1, x2, f1, f2 = x1[going], x2[going], f1[going], f2[going]
        if at.size == 0:
            break
        edge = 0.5 * near / wide
        x = x1 + np.clip(t, edge, 1.0 - edge) * (x2 - x1)
        f = np.asarray(function(x, at))
        same = (f > 0.0) == (f1 > 0.0)
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = x, f
        t, parabolic = _step(x1, x2, x3, f1, f2, f3)
        parabolic &= smooth
    return root


def _regula_falsi(f1: Array, f2: Array) -> Array:
    """Return the fraction of the way from the first end to the second, halves where it is flat."""
    usable = (f1 > 0.0) & (f2 < 0.0)
    return np.where(usable, f1 / np.where(usable, f1 - f2, 1.0), 0.5)


def _step(
    x1: Array, x2: Array, x3: Array, f1: Array, f2: Array, f3: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the fraction of the way from the newest point to the bracket's other end.

    And whether it is by a parabola. Where values coincide none goes through them, and the
    comparisons below fail.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        xi = (x1 - x2) / (x3 - x2)
        phi = (f1 - f2) / (f3 - f2)
        parabola = f1 / (f2 - f1) * (f3 / (f2 - f3))
        parabola += (x3 - x1) / (x2 - x1) * (f1 / (f3 - f1)) * (f2 / (f3 - f2))
        smooth = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi) & np.isfinite(parabola)
        # a parabola would creep along an end that is zero, where it may be so for a while
        smooth &= (f1 != 0.0) & (f2 != 0.0)
    return np.where(smooth, parabola, 0.5), smooth
