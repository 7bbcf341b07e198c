"""Where the nodes go along a curve: short edges where the flow is singular, long ones elsewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

__all__ = ["graded_spacing", "resample"]

Array = NDArray[np.float64]


def graded_spacing(
    length: float,
    largest: float,
    growth: float,
    start: float | None = None,
    end: float | None = None,
) -> Array:
    """Return arclengths from 0 to ``length`` whose spacing grows away from the ends named.

    Parameters
    ----------
    length : float
        Length of the curve.
    largest : float
        Largest spacing.
    growth : float
        Added spacing per distance from an end.
    start, end : float or None
        Spacing at the ends; None leaves that end as coarse as ``largest``.
    """

    def spacing(s: float) -> float:
        wanted = [largest]
        if start is not None:
            wanted.append(start + growth * s)
        if end is not None:
            wanted.append(end + growth * max(length - s, 0.0))
        return min(wanted)

    nodes = [0.0]
    while nodes[-1] < length:
        guess = spacing(nodes[-1])
        nodes.append(nodes[-1] + spacing(nodes[-1] + 0.5 * guess))
    return np.asarray(nodes) * (length / nodes[-1])


def resample(
    curve: Array,
    largest: float,
    growth: float,
    start: float,
    end: float | None,
) -> Array:
    """Return points (m, 2) on the cubic spline through ``curve`` (n, 2), spaced as asked.

    The spline is parametrised by chord length; its ends are kept exactly.
    """
    chord = np.r_[0.0, np.cumsum(np.hypot(*np.diff(curve, axis=0).T))]
    points = CubicSpline(chord, curve)(graded_spacing(chord[-1], largest, growth, start, end))
    points[0], points[-1] = curve[0], curve[-1]
    return np.asarray(points)
