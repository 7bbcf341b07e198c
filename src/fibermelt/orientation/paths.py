"""Velocity gradients along flow histories, and between their points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import HistoryError
from fibermelt.history import FlowHistory
from fibermelt.interpolation import SLOPE_PART, PathInterpolant
from fibermelt.orientation.flows import checked_gradient

__all__ = ["GradientAlong", "checked_history"]

Array = NDArray[np.float64]


class GradientAlong:
    """Velocity gradient along paths, between their points as fibers are followed."""

    def __init__(self, time: Array, L: Array) -> None:
        self._between = PathInterpolant(time, L.reshape(*L.shape[:-2], 9))
        self._shape = L.shape[:-3]
        points = np.linalg.norm(L, axis=(-2, -1))
        slopes = np.abs(self._between.start) + np.abs(self._between.end)
        slack = SLOPE_PART * np.linalg.norm(slopes.reshape(*slopes.shape[:-1], 3, 3), axis=(-2, -1))
        size = (np.maximum(points[..., :-1], points[..., 1:]) + slack) * self._between.step[..., 0]
        self.strain: Array = size.reshape(-1, size.shape[-1]).max(axis=0)
        """Bound of ``|L| dt`` over each interval, the largest of all histories, (n - 1,)."""

    def at(self, interval: int, u: float) -> Array:
        """Return ``L`` [1/s] at the fraction ``u`` of an interval, (..., 3, 3)."""
        value = self._between((..., interval, slice(None)), u)
        return value.reshape(*self._shape, 3, 3)


def checked_history(history: FlowHistory | tuple[ArrayLike, ArrayLike]) -> tuple[Array, Array]:
    """Return times (..., n) and gradients (..., n, 3, 3) of equal leading axes."""
    if isinstance(history, FlowHistory):
        return history.time, history.gradient
    given: object = history
    if not (isinstance(given, tuple) and len(given) == 2):
        kind = type(given).__name__
        msg = f"history is of the type {kind}: must be a FlowHistory, or a pair (time, gradient)"
        raise HistoryError(msg)
    time = real_array("time", history[0], error=HistoryError, duration=True)
    L = checked_gradient(history[1])
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
