"""How likely the pressures are: fibers that start in every direction alike.

The bounds over every orientation say what can happen; the quantiles of an isotropic start say how
often it does. Hundreds of initial angles go through the same linear system as the paper's thirteen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.fiber.extremes import extremes
from fibermelt.fiber.motion import deformation_along, isotropic_angles, turned
from fibermelt.fiber.paths import Path, single_paths
from fibermelt.fiber.pressure import surface_pressure
from fibermelt.fiber.response import FiberResponse

__all__ = ["QUANTILE_LEVELS", "IsotropicPressure", "isotropic_pressure", "population_quantiles"]

Array = NDArray[np.float64]

QUANTILE_LEVELS = (0.05, 0.5, 0.95)
"""Levels of the quantiles: the middle nine tenths and the median."""

ISOTROPIC_COUNT = 200
"""Initial directions: the 5 % quantile then has ten fibers below it."""


@dataclass(frozen=True, eq=False)
class IsotropicPressure:
    """Quantiles over fibers that start isotropic, relative to the streamline's pressure [Pa].

    Parameters
    ----------
    levels : (k,) array
        Levels [-], in (0, 1).
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
    path: Path,
    response: FiberResponse,
    viscosity: float,
    middle_time: float | Array,
    count: int = ISOTROPIC_COUNT,
    levels: tuple[float, ...] = QUANTILE_LEVELS,
) -> IsotropicPressure:
    """Return quantiles of pressures and extremes for an isotropic start.

    Parameters
    ----------
    path : FlowHistory or PathBundle
        One path or several; they are taken one by one, so memory does not grow with them.
    response : FiberResponse
        The fibers' response.
    viscosity : float
        ``mu`` [Pa s].
    middle_time : float or (...) array
        Time at the middle of the capillary [s], as in `extremes`.
    count : int
        Number of initial directions, equally spaced; quantiles are linear between their fibers.
    levels : tuple of float
        Levels in [0, 1].

    Raises
    ------
    ConfigError
        If a level lies outside [0, 1], or as in `follow`, `surface_pressure` and `extremes`.
    """
    initial, factor = isotropic_angles(count), response.shape_factor
    whole, substeps = deformation_along(path, factor)
    lines = iter(whole.lines())

    def pressures(one: Path, middle: float) -> tuple[Array, Array, Array]:
        motion = turned(one, factor, initial, next(lines), substeps)
        pressure = surface_pressure(one, response, viscosity, motion)
        return pressure.lowest, pressure.highest, extremes(one, pressure, motion, middle).value

    return population_quantiles(path, middle_time, levels, pressures)


def population_quantiles(
    path: Path,
    middle_time: float | Array,
    levels: tuple[float, ...],
    pressures: Callable[[Path, float], tuple[Array, Array, Array]],
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
        If a level lies outside [0, 1].
    """
    if not all(0 <= level <= 1 for level in levels):
        msg = f"levels = {levels}: quantile levels lie between 0 and 1"
        raise ConfigError(msg)
    middles = np.ravel(np.asarray(middle_time, dtype=np.float64))
    parts = [
        [_quantiles(values, levels) for values in pressures(one, float(middle))]
        for one, middle in zip(single_paths(path), middles, strict=True)
    ]
    lead = path.time.shape[:-1]
    stacked = [
        np.stack(values).reshape(*lead, *values[0].shape) for values in zip(*parts, strict=True)
    ]
    return IsotropicPressure(np.array(levels), *stacked)


def _quantiles(values: Array, levels: tuple[float, ...]) -> Array:
    """Return quantiles over the first axis, levels last."""
    last = np.ascontiguousarray(np.moveaxis(values, 0, -1))
    return np.moveaxis(np.quantile(last, levels, axis=-1), 0, -1)
