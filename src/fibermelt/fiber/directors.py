"""How spheroids turn along a path in three dimensions, from any number of directions at once.

Jeffery's equation ``p_dot = W p + B (D p - (p.D p) p)`` is the direction of a linear system:
``F_dot = (W + B D) F``, ``p = F p_0/|F p_0|``. One map for each interval of the path serves all
fibers. They are carried from point to point and normalised there: nothing can overflow or vanish,
however long the shear, and a start at right angles to the plane stays there for good.

Between the path's points the gradient is the cubic of `fibermelt.interpolation`; inside an interval
the fourth-order Magnus series is halved until the map stands still.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, ConvergenceError, refuse_other
from fibermelt.fiber.checks import (
    checked_number,
    checked_positive,
    checked_unit,
)
from fibermelt.fiber.expansion import EXPONENT_BOUND, exponential3, magnus_generator
from fibermelt.fiber.magnus import GAUSS
from fibermelt.fiber.motion import ANGLE_TOLERANCE
from fibermelt.history import FlowHistory
from fibermelt.interpolation import PathInterpolant

__all__ = ["DirectorMotion", "follow_directors"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

MOST_HALVINGS = 16
"""Halvings of an interval, the last for comparison: more sub-steps than 65536 mean a gradient that
is no history."""

ROUNDING = 1e-14
"""Two maps over a sub-step differ by some roundings in any case."""

BLOCK = 1 << 12
"""Sub-steps taken at a time: their maps stay in the cache."""


@dataclass(frozen=True, eq=False)
class DirectorMotion:
    """The directions of fibers along a path.

    Parameters
    ----------
    initial_directions : (n_directions, 3) array
        Unit vectors at the start.
    direction : (..., n_directions, n, 3) array
        Unit vectors along the path. The sign goes on from the start: a fiber that has made half a
        turn points backwards.
    log_stretch : (..., n_directions, n) array
        ``ln |F p_0|`` [-]. Fibers that start isotropic have the density ``exp(3 log_stretch)``
        over that start's where they are (``det F = 1``).
    substeps : int
        Largest number of sub-steps that an interval took.
    """

    initial_directions: Array
    direction: Array
    log_stretch: Array
    substeps: int


def follow_directors(
    path: FlowHistory,
    shape_factor: float,
    directions: ArrayLike,
    tolerance: float = ANGLE_TOLERANCE,
) -> DirectorMotion:
    """Follow spheroids along a path from all initial directions at once.

    Parameters
    ----------
    path : FlowHistory
        One path (n points) or several (leading axes), in the plane or in space.
    shape_factor : float
        ``B`` [-]: Jeffery's ``xi`` when unbounded.
    directions : (n_directions, 3) array_like
        Unit vectors at the start.
    tolerance : float
        Angle error of the time integration over the whole path [rad], by halving: a bound on the
        sum of the local errors for the interpolated gradient.

    Raises
    ------
    ConfigError
        If the path is none, a direction not a unit vector, or the shape factor or tolerance not
        usable.
    ConvergenceError
        If an interval needs more than ``2**16`` sub-steps.
    """
    start = checked_unit(directions, "directions")
    if start.ndim != 2 or start.shape[0] == 0:
        msg = f"directions has shape {start.shape}, expected (n_directions, 3) with at least one"
        raise ConfigError(msg)
    shape_factor = checked_number("shape_factor", shape_factor)
    tolerance = checked_positive("tolerance", tolerance, "rad", "1e-8")
    refuse_other("path", path, FlowHistory)
    time, L = path.time, path.gradient
    maps, scale, substeps = _interval_maps(time, L, shape_factor, tolerance)
    direction, stretch = _carry(time, maps, scale, start)
    return DirectorMotion(start, direction, stretch, substeps)


def _carry(time: Array, maps: Array, scale: Array, start: Array) -> tuple[Array, Array]:
    """Return directions (..., n_directions, n, 3) and ``ln |F p_0|`` along the maps."""
    *lead, n = time.shape
    direction = np.empty((*lead, start.shape[0], n, 3))
    stretch = np.zeros((*lead, start.shape[0], n))
    here = np.broadcast_to(start, (*lead, *start.shape))
    direction[..., 0, :] = here
    for k in range(n - 1):
        image = here @ np.swapaxes(maps[..., k, :, :], -1, -2)
        largest = np.max(np.abs(image), axis=-1)
        if not np.all(largest > 0.0):
            msg = (
                f"fiber motion: the interval from t = {np.min(time[..., k]):.6g} s shrinks a "
                "director to nothing (by more than exp(700)): give the history more points there"
            )
            raise ConvergenceError(msg)
        here = image / largest[..., None]  # squares of what is small would underflow
        length = np.sqrt(np.einsum("...i,...i->...", here, here))
        here = here / length[..., None]
        direction[..., k + 1, :] = here
        rise = np.log(largest) + np.log(length) + scale[..., None, k]
        stretch[..., k + 1] = stretch[..., k] + rise
    return direction, stretch


def _interval_maps(
    time: Array, L: Array, shape_factor: float, tolerance: float
) -> tuple[Array, Array, int]:
    """Return the intervals' maps of norm one, the norms' logarithms, and the most sub-steps.

    Of shapes (..., n - 1, 3, 3) and (..., n - 1).
    """
    A = 0.5 * ((shape_factor + 1.0) * L + (shape_factor - 1.0) * np.swapaxes(L, -1, -2))
    field = PathInterpolant(time, A.reshape(*A.shape[:-2], 9))
    shape = field.step.shape[:-1]
    size = np.maximum(field.largest_change() / EXPONENT_BOUND, 1.0).ravel()
    level = np.ceil(np.log2(size)).astype(np.intp)
    maps, scale = np.empty((level.size, 3, 3)), np.empty(level.size)
    waiting = np.ones(level.size, dtype=bool)
    bound = tolerance / shape[-1]
    for halvings in range(int(np.min(level)), MOST_HALVINGS):
        here = np.flatnonzero(waiting & (level <= halvings))
        count = 1 << halvings
        for start in range(0, here.size, max(1, BLOCK // count)):
            part = here[start : start + max(1, BLOCK // count)]
            index = np.unravel_index(part, shape)
            coarse = _steps(field, index, count)
            fine = _steps(field, index, 2 * count)
            pairs = fine[:, 1::2] @ fine[:, 0::2]
            done = _difference(pairs, coarse) <= bound + ROUNDING * count
            maps[part[done]], scale[part[done]] = _product(pairs[done])
            waiting[part[done]] = False
        if not np.any(waiting):
            return maps.reshape(*shape, 3, 3), scale.reshape(shape), 2 * count
    where = np.unravel_index(int(np.flatnonzero(waiting)[0]), shape)
    msg = (
        f"fiber motion: the interval from t = {time[where]:.6g} s turns too fast or too "
        f"unevenly for {1 << MOST_HALVINGS} sub-steps: give the history more points there"
    )
    raise ConvergenceError(msg)


def _steps(field: PathInterpolant, index: tuple[Index, ...], count: int) -> Array:
    """Return the maps of ``count`` equal steps in the selected intervals, (k, count, 3, 3)."""
    select = tuple(axis[:, None] for axis in index)
    middle = (np.arange(count) + 0.5)[None, :, None] / count
    first, second = (
        field(select, middle + side * GAUSS / count).reshape(-1, count, 3, 3)
        for side in (-1.0, 1.0)
    )
    return exponential3(magnus_generator(first, second, field.step[select][..., 0] / count))


def _product(steps: Array) -> tuple[Array, Array]:
    """Return the steps' product over its norm, (k, 3, 3), and the norm's logarithm."""
    scale = np.zeros(steps.shape[:2])
    while True:
        norm = np.linalg.norm(steps, axis=(-2, -1))
        steps, scale = steps / norm[..., None, None], scale + np.log(norm)
        if steps.shape[1] == 1:
            return steps[:, 0], scale[:, 0]
        steps = steps[:, 1::2] @ steps[:, 0::2]
        scale = scale[:, 1::2] + scale[:, 0::2]


def _difference(fine: Array, coarse: Array) -> Array:
    """Return a bound on the angle [rad] between the images under two ways through an interval.

    The sum over the steps of ``|coarse fine^-1 - I|`` in Frobenius' norm, with the adjugate as the
    inverse (``det = 1``): each step is mild, so that nothing is lost however strong the whole.
    """
    first, second, third = fine[..., 0, :], fine[..., 1, :], fine[..., 2, :]
    columns = [np.cross(second, third), np.cross(third, first), np.cross(first, second)]
    change = coarse @ np.stack(columns, axis=-1) - np.eye(3)
    return np.asarray(np.sum(np.linalg.norm(change, axis=(-2, -1)), axis=-1))
