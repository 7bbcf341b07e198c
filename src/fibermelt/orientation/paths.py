"""Velocity gradients along flow histories, and between their points."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import HistoryError
from fibermelt.orientation.flows import checked_gradient

__all__ = ["FlowPath", "GradientPath", "checked_history"]

Array = NDArray[np.float64]


class FlowPath(Protocol):
    """What is needed of a path, or of many: a `fibermelt.FlowHistory`, or a bundle of them."""

    @property
    def time(self) -> Array:
        """Time [s], (..., n), strictly increasing."""

    @property
    def gradient(self) -> Array:
        """Velocity gradient [1/s], (..., n, 2, 2) or (..., n, 3, 3)."""


class GradientPath:
    """Velocity gradient between the points: the cubic that the fibers are followed with.

    Hermite's with the slopes of the parabola through a point and its neighbours: exact for
    quadratics, fourth order over an interval.
    """

    def __init__(self, time: Array, L: Array) -> None:
        step = np.diff(time, axis=-1)[..., None, None]
        rise = np.diff(L, axis=-3)
        slope = rise / step
        before, after = step[..., :-1, :, :], step[..., 1:, :, :]
        inner = (after * slope[..., :-1, :, :] + before * slope[..., 1:, :, :]) / (before + after)
        first = last = slope[..., :1, :, :]
        if slope.shape[-3] > 1:
            first = 2.0 * first - inner[..., :1, :, :]
            last = 2.0 * slope[..., -1:, :, :] - inner[..., -1:, :, :]
        slopes = np.concatenate([first, inner, last], axis=-3)
        self.left = L[..., :-1, :, :]
        self.start = slopes[..., :-1, :, :] * step
        end = slopes[..., 1:, :, :] * step
        self.bend = 3.0 * rise - 2.0 * self.start - end
        self.twist = self.start + end - 2.0 * rise
        points = np.linalg.norm(L, axis=(-2, -1))
        slack = 0.25 * np.linalg.norm(np.abs(self.start) + np.abs(end), axis=(-2, -1))
        size = (np.maximum(points[..., :-1], points[..., 1:]) + slack) * step[..., 0, 0]
        self.strain: Array = size.reshape(-1, size.shape[-1]).max(axis=0)
        """Bound of ``|L| dt`` over each interval, the largest of all histories, (n - 1,)."""

    def at(self, interval: int, u: float) -> Array:
        """Return ``L`` [1/s] at the fraction ``u`` of an interval, (..., 3, 3)."""
        k = (..., interval, slice(None), slice(None))
        value: Array = self.left[k] + u * (self.start[k] + u * (self.bend[k] + u * self.twist[k]))
        return value


def checked_history(history: FlowPath | tuple[ArrayLike, ArrayLike]) -> tuple[Array, Array]:
    """Return times (..., n) and gradients (..., n, 3, 3) of equal leading axes."""
    pair = history if isinstance(history, tuple) else (history.time, history.gradient)
    time, L = np.asarray(pair[0], dtype=np.float64), checked_gradient(pair[1])
    if time.ndim == 0 or time.shape[-1] < 2 or time.shape != L.shape[:-2]:
        msg = (
            f"orientation: time has shape {time.shape}, the gradient {L.shape}: expected (..., n) "
            "and (..., n, d, d) with n at least 2"
        )
        raise HistoryError(msg)
    if not np.all(np.isfinite(time)) or np.any(np.diff(time, axis=-1) <= 0.0):
        msg = "orientation: time must be finite and increase strictly along every history"
        raise HistoryError(msg)
    return time, L
