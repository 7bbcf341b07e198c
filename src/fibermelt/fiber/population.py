"""How likely the pressures are: fibers that start in every direction alike.

The bounds over every orientation say what can happen; the quantiles of an isotropic start say how
often it does. In the plane they are exact (`fibermelt.fiber.shares`, `fibermelt.fiber.unions`): the
share of fibers in an arc of phases has a closed form. In space, directions are sampled.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.extremes import before_middle, extreme_values
from fibermelt.fiber.level_sets import LevelSets
from fibermelt.fiber.motion import (
    ANGLE_TOLERANCE,
    deformation_along,
    follow,
    isotropic_angles,
)
from fibermelt.fiber.paths import checked_path, strain_polar
from fibermelt.fiber.pressure import Viscosity, pressure_amplitude, surface_pressure
from fibermelt.fiber.propagator import Propagator
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.shares import alignment, height_quantiles
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.fiber.unions import Problems, extreme_quantiles, turning_points
from fibermelt.history import FlowHistory

__all__ = ["QUANTILE_LEVELS", "IsotropicPressure", "isotropic_pressure", "population_quantiles"]

Array = NDArray[np.float64]

QUANTILE_LEVELS = (0.05, 0.5, 0.95)
"""Levels of the quantiles: the middle nine tenths and the median."""

ISOTROPIC_COUNT = 200
"""Initial directions in space: the 5 % quantile then has ten fibers below it."""

PLANAR_COUNT = 200
"""Fibers in the plane of a thinning melt: a quantile's level is then off by 1/400."""

BLOCK = 1 << 13
"""Points of paths taken at a time: their arrays then stay in the cache."""

KIND_OPPOSITE = np.array([True, False])
KIND_SIGN = np.array([-1.0, 1.0])
"""Whether the phase of a kind (min, max) is the opposite one, and the pressure's sign."""


@dataclass(frozen=True, eq=False)
class IsotropicPressure:
    """Quantiles over fibers that start isotropic, relative to the streamline's pressure [Pa].

    Parameters
    ----------
    levels : (k,) array
        Levels [-], in [0, 1].
    lowest, highest : (..., n, k) array
        Of the surface's lowest and highest pressure at every point.
    extremes : (..., 2, 2, k) array
        Of each fiber's extremes, axes location (1, 2) and kind (min, max).
    """

    levels: Array
    lowest: Array
    highest: Array
    extremes: Array


def isotropic_pressure(
    path: FlowHistory,
    response: FiberResponse | ThinningResponse,
    viscosity: Viscosity,
    middle_time: ArrayLike,
    levels: tuple[float, ...] = QUANTILE_LEVELS,
    tolerance: float = ANGLE_TOLERANCE,
) -> IsotropicPressure:
    """Return quantiles of pressures and extremes for an isotropic start in the plane.

    Exact for the points of the path, but for `fibermelt.fiber.level_sets.LEVEL_TOLERANCE`: no
    fiber is sampled. In a melt that thins there is no closed form: `PLANAR_COUNT` fibers of equal
    weight are followed, between whose values quantiles are linear.

    Parameters
    ----------
    path : FlowHistory
        One path or several; a few are taken at a time, so memory does not grow with them.
    response : FiberResponse or ThinningResponse
        The fibers' response.
    viscosity : float, ViscosityLaw or LocalViscosity
        The melt, as in `surface_pressure`.
    middle_time : float or (...) array
        Time at the middle of the capillary [s], as in `extremes`.
    levels : tuple of float
        Levels in [0, 1].
    tolerance : float
        Of the angles [rad], as in `follow`; with the one that the same path was followed with
        nothing is integrated again.

    Raises
    ------
    ConfigError
        If a level lies outside [0, 1], or as in `follow`, `surface_pressure` and `extremes`.
    ConvergenceError
        As in `follow` and `fibermelt.fiber.level_sets.level_sets`.
    """
    _refuse_levels(levels)
    checked_path(path)
    if isinstance(response, ThinningResponse):
        return _followed_quantiles(path, response, viscosity, middle_time, levels, tolerance)
    refuse_other("response", response, FiberResponse)
    size, double = strain_polar(path.gradient)
    amplitude = pressure_amplitude(response, viscosity, size)
    deformation, _ = deformation_along(path, response.shape_factor, tolerance)
    lead, n = path.time.shape[:-1], path.time.shape[-1]
    before = before_middle(path, middle_time).reshape(-1, n)
    amplitude, double = amplitude.reshape(-1, n), double.reshape(-1, n)
    step = max(1, BLOCK // n)
    parts = []
    for first in range(0, len(before), step):
        some = slice(first, first + step)
        line = _Lines(amplitude[some], double[some], deformation.lines(some), before[some])
        parts.append(_line_quantiles(line, response.level_sets, levels))
    stacked = [np.concatenate(part) for part in zip(*parts, strict=True)]
    return IsotropicPressure(
        np.array(levels), *(values.reshape(*lead, *values.shape[1:]) for values in stacked)
    )


def _followed_quantiles(
    path: FlowHistory,
    response: ThinningResponse,
    viscosity: Viscosity,
    middle_time: ArrayLike,
    levels: tuple[float, ...],
    tolerance: float,
) -> IsotropicPressure:
    """Return quantiles over fibers that are followed; the map of their angles is one-to-one."""
    start = isotropic_angles(PLANAR_COUNT)
    motion = follow(path, response, start, tolerance)
    found = surface_pressure(path, response, viscosity, motion)
    before = before_middle(path, middle_time)
    n = path.time.shape[-1]
    shape = (-1, PLANAR_COUNT, n)
    lines = zip(
        found.lowest.reshape(shape),
        found.highest.reshape(shape),
        before.reshape(-1, n),
        strict=True,
    )
    parts = [
        [_quantiles(one, levels) for one in (low, high, extreme_values(low, high, here))]
        for low, high, here in lines
    ]
    lead = path.time.shape[:-1]
    stacked = [np.stack(part).reshape(*lead, *part[0].shape) for part in zip(*parts, strict=True)]
    return IsotropicPressure(np.array(levels), *stacked)


@dataclass(frozen=True, eq=False)
class _Lines:
    """Some paths of n points: ``mu d`` [Pa], ``2 beta`` [rad], ``F``, and who is at location 1."""

    amplitude: Array
    double: Array
    deformation: Propagator
    before: NDArray[np.bool_]


def _line_quantiles(
    lines: _Lines, sets: LevelSets, levels: tuple[float, ...]
) -> tuple[Array, Array, Array]:
    """Return quantiles (m, n, k) of lowest and highest pressure, (m, 2, 2, k) of extremes [Pa].

    The lowest pressure is ``-mu d h(phi + pi)``: its quantiles are those of the opposite share.
    """
    share = np.array([[1.0 - level for level in levels], levels])
    found = alignment(lines.deformation, lines.double)
    height = height_quantiles(sets, found, share)
    pressure = lines.amplitude[..., None, None] * height
    # of the extreme over some points, no quantile is below the points' own
    sides = (lines.before, ~lines.before)
    low = np.stack([np.max(pressure, axis=1, where=s[..., None, None], initial=0.0) for s in sides])
    bound = np.moveaxis(low, 0, -1)  # (m, kind, k, location)
    there = np.where(lines.before[:, None, None], bound[..., :1], bound[..., 1:])
    able = lines.amplitude[:, None, None, :] * sets.highest > there
    n = lines.amplitude.shape[-1]
    line, kind, level, point = np.nonzero(able)
    location = np.where(lines.before[line, point], 0, 1)
    asked = Problems(
        share=np.broadcast_to(share[None, ..., None], bound.shape).ravel(),
        opposite=np.broadcast_to(KIND_OPPOSITE[:, None, None], bound.shape).ravel(),
        low=bound.ravel(),
        point=line * n + point,
        problem=((line * 2 + kind) * len(levels) + level) * 2 + location,
    )
    points = turning_points(lines.amplitude, 0.5 * lines.double, lines.deformation)
    extreme = extreme_quantiles(sets, points, asked).reshape(bound.shape)
    extreme = np.moveaxis(extreme, -1, 1)  # (m, location, kind, k)
    return -pressure[..., 0, :], pressure[..., 1, :], KIND_SIGN[:, None] * extreme


def population_quantiles(
    path: FlowHistory,
    middle_time: ArrayLike,
    levels: tuple[float, ...],
    pressures: Callable[[FlowHistory, float], tuple[Array, Array, Array]],
) -> IsotropicPressure:
    """Return quantiles over a population of fibers, whatever follows them, path by path.

    Parameters
    ----------
    path, middle_time, levels
        As in `isotropic_pressure`.
    pressures : callable
        From one path and its middle time to the population's lowest and highest pressures
        (n_fibers, n) and extremes (n_fibers, 2, 2), relative to the streamline's [Pa].

    Raises
    ------
    ConfigError
        If a level lies outside [0, 1], or there are more or fewer middle times than paths.
    """
    _refuse_levels(levels)
    paths = path.lines
    middles = np.ravel(real_array("middle_time", middle_time, duration=True))
    if middles.size not in (1, len(paths)):
        msg = f"middle_time has {middles.size} values for {len(paths)} paths: give one, or one each"
        raise ConfigError(msg)
    parts = [
        [_quantiles(values, levels) for values in pressures(one, float(middle))]
        for one, middle in zip(paths, np.broadcast_to(middles, len(paths)), strict=True)
    ]
    lead = path.time.shape[:-1]
    stacked = [
        np.stack(values).reshape(*lead, *values[0].shape) for values in zip(*parts, strict=True)
    ]
    return IsotropicPressure(np.array(levels), *stacked)


def _refuse_levels(levels: tuple[float, ...]) -> None:
    """Refuse levels that are none."""
    array = real_array("levels", levels)
    if array.ndim != 1 or not np.all((array >= 0.0) & (array <= 1.0)):
        msg = f"levels = {levels}: quantile levels lie between 0 and 1"
        raise ConfigError(msg)


def _quantiles(values: Array, levels: tuple[float, ...]) -> Array:
    """Return quantiles over the first axis, levels last."""
    last = np.ascontiguousarray(np.moveaxis(values, 0, -1))
    return np.moveaxis(np.quantile(last, levels, axis=-1), 0, -1)
