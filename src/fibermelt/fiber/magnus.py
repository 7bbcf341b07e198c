"""The propagator over each interval of a path, to a given accuracy.

Between the points of a path the velocity gradient is the cubic of `fibermelt.interpolation`. Inside
an interval the fourth-order Magnus series with two Gauss points is used, halved until the map
stands still: for a constant gradient one step is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConvergenceError
from fibermelt.fiber.propagator import Propagator, compose, exponential
from fibermelt.history import FlowHistory
from fibermelt.interpolation import PathInterpolant

__all__ = ["GAUSS", "interval_propagators"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

LARGEST_TURN = 1.0
"""Bound of ``|A| dt`` in a sub-step [rad]: below half a turn, the lift is the arctangent's."""

MOST_HALVINGS = 16
"""Halvings of an interval: more than 65536 sub-steps mean a gradient that is no history."""

ROUNDING = 1e-14
"""Two maps of stretch ``e^s`` differ by rounding of about ``1e-16 e^2s`` at any sub-step."""

LARGEST_EXPONENT = 600.0
"""Bound of the logarithm of a stretch squared, so that comparing two maps cannot overflow."""

BLOCK = 1 << 20
"""Sub-steps taken at a time: tens of megabytes."""

GAUSS = 0.5 / np.sqrt(3.0)
"""Distance of the two Gauss points from the middle, over the step."""


def interval_propagators(
    path: FlowHistory, shape_factor: float, tolerance: float
) -> tuple[Propagator, int]:
    """Return the map of ``F_dot = (W + B D) F`` over each interval, and the sub-steps it took.

    Parameters
    ----------
    path : FlowHistory
        Paths of n points.
    shape_factor : float
        ``B`` [-].
    tolerance : float
        Sum over a path of the changes at the last halving, as angles [rad]. The maps returned are
        the finer ones, whose error is a fifteenth of it.

    Returns
    -------
    maps : Propagator
        Leading shape (..., n - 1).
    substeps : int
        Largest number of sub-steps in an interval.

    Raises
    ------
    ConvergenceError
        If an interval needs more than ``2**16`` sub-steps.
    """
    L = path.plane_gradient
    spin = 0.5 * (L[..., 1, 0] - L[..., 0, 1])
    normal = 0.5 * shape_factor * (L[..., 0, 0] - L[..., 1, 1])
    shear = 0.5 * shape_factor * (L[..., 0, 1] + L[..., 1, 0])
    gradient = PathInterpolant(path.time, np.stack([normal, shear - spin, shear + spin], axis=-1))
    shape = gradient.step.shape[:-1]
    turning = np.maximum(gradient.largest_change() / LARGEST_TURN, 1.0).ravel()
    level = np.ceil(np.log2(turning)).astype(np.intp)
    result, latest = _empty(level.size), _empty(level.size)
    waiting = np.ones(level.size, dtype=bool)
    bound = tolerance / shape[-1]
    for halvings in range(int(np.min(level)), MOST_HALVINGS + 1):
        here = np.flatnonzero(waiting & (level <= halvings))
        maps = _in_blocks(gradient, here, shape, 1 << halvings)
        change = _difference(maps, _take(latest, here))
        change[level[here] == halvings] = np.inf  # nothing coarser to compare with yet
        done = change <= bound + ROUNDING * _stretch(2.0 * maps.scale)
        _put(result, here[done], _take(maps, done))
        _put(latest, here, maps)
        waiting[here[done]] = False
        if not np.any(waiting):
            break
    else:
        _refuse(path, np.unravel_index(int(np.flatnonzero(waiting)[0]), shape))
    whole = Propagator(
        result.matrix.reshape(*shape, 2, 2), result.scale.reshape(shape), result.turn.reshape(shape)
    )
    return whole, 1 << halvings


def _in_blocks(
    gradient: PathInterpolant, here: Index, shape: tuple[int, ...], count: int
) -> Propagator:
    """Return the maps over the intervals ``here``, some at a time to bound the memory."""
    maps = _empty(here.size)
    block = max(1, BLOCK // count)
    for start in range(0, here.size, block):
        part = slice(start, min(start + block, here.size))
        _put(
            maps,
            np.arange(part.start, part.stop),
            _steps(gradient, np.unravel_index(here[part], shape), count),
        )
    return maps


def _refuse(path: FlowHistory, where: tuple[np.intp, ...]) -> None:
    msg = (
        f"fiber motion: the interval from t = {path.time[where]:.6g} s turns too fast or too "
        f"unevenly for {1 << MOST_HALVINGS} sub-steps: give the history more points there"
    )
    raise ConvergenceError(msg)


def _empty(count: int) -> Propagator:
    """Return places for maps; the identity's scale keeps what is not yet set out of overflow."""
    return Propagator(np.zeros((count, 2, 2)), np.zeros(count), np.zeros(count))


def _steps(gradient: PathInterpolant, interval: tuple[Index, ...], count: int) -> Propagator:
    """Return the maps over the selected intervals by ``count`` equal Magnus steps.

    ``Omega = h (A_1 + A_2)/2 + (sqrt 3/12) h^2 [A_2, A_1]`` (Blanes, Casas, Oteo and Ros 2009,
    doi 10.1016/j.physrep.2008.11.001, section 5.4): traceless when ``A`` is.
    """
    select = tuple(axis[:, None] for axis in interval)
    middle = (np.arange(count) + 0.5)[None, :, None] / count
    first = gradient(select, middle - GAUSS / count)
    second = gradient(select, middle + GAUSS / count)
    h = gradient.step[select] / count
    a1, b1, c1 = np.moveaxis(first, -1, 0)
    a2, b2, c2 = np.moveaxis(second, -1, 0)
    h = h[..., 0]
    weight = np.sqrt(3.0) / 12.0 * h * h
    generator = np.empty((*a1.shape, 2, 2))
    generator[..., 0, 0] = 0.5 * h * (a1 + a2) + weight * (b2 * c1 - b1 * c2)
    generator[..., 0, 1] = 0.5 * h * (b1 + b2) + 2.0 * weight * (a2 * b1 - a1 * b2)
    generator[..., 1, 0] = 0.5 * h * (c1 + c2) + 2.0 * weight * (c2 * a1 - c1 * a2)
    generator[..., 1, 1] = -generator[..., 0, 0]
    maps = exponential(generator)
    while maps.turn.shape[-1] > 1:
        maps = compose(maps.part(slice(1, None, 2)), maps.part(slice(0, None, 2)))
    return Propagator(maps.matrix[:, 0], maps.scale[:, 0], maps.turn[:, 0])


def _difference(fine: Propagator, coarse: Propagator) -> Array:
    """Return a bound on the angle [rad] between the images of any direction under two maps.

    ``|coarse fine^-1 - I|`` in Frobenius' norm, with the adjugate as the inverse.
    """
    f, c = fine.matrix, coarse.matrix
    lift = _stretch(fine.scale + coarse.scale)
    e11 = lift * (c[:, 0, 0] * f[:, 1, 1] - c[:, 0, 1] * f[:, 1, 0]) - 1.0
    e12 = lift * (c[:, 0, 1] * f[:, 0, 0] - c[:, 0, 0] * f[:, 0, 1])
    e21 = lift * (c[:, 1, 0] * f[:, 1, 1] - c[:, 1, 1] * f[:, 1, 0])
    e22 = lift * (c[:, 1, 1] * f[:, 0, 0] - c[:, 1, 0] * f[:, 0, 1]) - 1.0
    size: Array = np.sqrt(e11**2 + e12**2 + e21**2 + e22**2)
    return size


def _stretch(exponent: Array) -> Array:
    return np.asarray(np.exp(np.minimum(exponent, LARGEST_EXPONENT)))


def _take(maps: Propagator, index: NDArray[np.generic]) -> Propagator:
    return Propagator(maps.matrix[index], maps.scale[index], maps.turn[index])


def _put(target: Propagator, index: NDArray[np.generic], maps: Propagator) -> None:
    target.matrix[index], target.scale[index], target.turn[index] = (
        maps.matrix,
        maps.scale,
        maps.turn,
    )
