"""How likely the pressures are: fibers that start in every direction alike.

The bounds over every orientation say what can happen; the quantiles of an isotropic start say how
often it does. Hundreds of initial angles go through the same linear system as the paper's thirteen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.fiber.extremes import extremes
from fibermelt.fiber.motion import follow, isotropic_angles
from fibermelt.fiber.paths import Path, single_paths
from fibermelt.fiber.pressure import surface_pressure
from fibermelt.fiber.response import FiberResponse

__all__ = ["QUANTILE_LEVELS", "IsotropicPressure", "isotropic_pressure"]

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
    if not all(0 <= level <= 1 for level in levels):
        msg = f"levels = {levels}: quantile levels lie between 0 and 1"
        raise ConfigError(msg)
    initial = isotropic_angles(count)
    middles = np.ravel(np.asarray(middle_time, dtype=np.float64))
    lowest, highest, extreme = [], [], []
    for one, middle in zip(single_paths(path), middles, strict=True):
        motion = follow(one, response.shape_factor, initial)
        pressure = surface_pressure(one, response, viscosity, motion)
        found = extremes(one, pressure, motion, float(middle))
        lowest.append(_quantiles(pressure.lowest.T, levels))
        highest.append(_quantiles(pressure.highest.T, levels))
        extreme.append(_quantiles(np.moveaxis(found.value, 0, -1), levels))
    lead = path.time.shape[:-1]
    stacked = [
        np.stack(values).reshape(*lead, *values[0].shape) for values in (lowest, highest, extreme)
    ]
    return IsotropicPressure(np.array(levels), *stacked)


def _quantiles(values: Array, levels: tuple[float, ...]) -> Array:
    """Return quantiles over the last axis, levels last."""
    contiguous = np.ascontiguousarray(values)
    return np.moveaxis(np.quantile(contiguous, levels, axis=-1), 0, -1)
