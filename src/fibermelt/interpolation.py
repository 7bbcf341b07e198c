"""What lies between the points of a flow history: the one cubic that fibers and tensors follow.

Hermite's, with the slopes of the parabola through a point and its two neighbours (at the ends, that
of the last three). It is local, exact for quadratics, and on smooth data its error cancels over an
interval to fourth order in the spacing. Reference: de Boor 2001, A Practical Guide to Splines,
chapter 4 (Bessel's slopes).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SLOPE_PART", "PathInterpolant"]

Array = NDArray[np.float64]

SLOPE_PART = 0.25
"""Of an end's slope times the step, what the cubic adds at most: 4/27, and a margin."""


class PathInterpolant:
    """Quantities between the points of a path (see the module's docstring).

    ``left``, ``rise``, ``start`` and ``end`` are the cubic's value, increase and end slopes over
    each interval, ``step`` its length [s]: shapes (..., n - 1, k), and (..., n - 1, 1).

    Parameters
    ----------
    time : (..., n) array
        Times [s].
    values : (..., n, k) array
        What is interpolated, one column each.
    """

    def __init__(self, time: Array, values: Array) -> None:
        step = np.diff(time, axis=-1)[..., None]
        rise = np.diff(values, axis=-2)
        slope = rise / step
        inner = (step[..., 1:, :] * slope[..., :-1, :] + step[..., :-1, :] * slope[..., 1:, :]) / (
            step[..., 1:, :] + step[..., :-1, :]
        )
        if slope.shape[-2] > 1:
            first = 2.0 * slope[..., :1, :] - inner[..., :1, :]
            last = 2.0 * slope[..., -1:, :] - inner[..., -1:, :]
        else:
            first = last = slope
        slopes = np.concatenate([first, inner, last], axis=-2)
        self.step = step
        self.left, self.rise = values[..., :-1, :], rise
        self.start, self.end = slopes[..., :-1, :] * step, slopes[..., 1:, :] * step

    def __call__(self, interval: Any, fraction: float | Array) -> Array:
        """Return the values at a fraction of the selected intervals.

        Parameters
        ----------
        interval
            Any numpy index into the axes ``(..., n - 1)``.
        fraction
            Position in the interval [0, 1], broadcast with the selection (component axis last).
        """
        u = fraction
        left, rise = self.left[interval], self.rise[interval]
        start, end = self.start[interval], self.end[interval]
        bend = 3.0 * rise - 2.0 * start - end
        twist = start + end - 2.0 * rise
        value: Array = left + u * (start + u * (bend + u * twist))
        return value

    def largest_change(self) -> Array:
        """Return a bound of ``|values| dt`` over each interval, (..., n - 1), in Euclid's norm.

        From both ends, and the slopes: a cubic Hermite's part of a slope is at most 4/27 of it.
        """
        ends = np.maximum(
            np.linalg.norm(self.left, axis=-1), np.linalg.norm(self((...,), 1.0), axis=-1)
        )
        slopes = np.linalg.norm(self.start, axis=-1) + np.linalg.norm(self.end, axis=-1)
        return np.asarray((ends + SLOPE_PART * slopes) * self.step[..., 0])
