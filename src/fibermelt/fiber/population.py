"""How likely the pressures are: fibers that start in every direction alike.

The bounds over every orientation say what can happen; the quantiles of an isotropic start say how
often it does. They are those of fibers that are followed, evenly spread at the start: by angle in
the plane, by area in space. Between two fibers' values quantiles are linear; one of them is off by
what lies between the next fibers, so its error falls as one over their count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, refuse_no_count, refuse_other
from fibermelt.fiber.extremes import extreme_values, locations
from fibermelt.fiber.motion import (
    ANGLE_TOLERANCE,
    deformation_along,
    follow,
    isotropic_angles,
)
from fibermelt.fiber.paths import checked_path, strain_polar
from fibermelt.fiber.pressure import Viscosity, pressure_amplitude, surface_pressure
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.history import FlowHistory

__all__ = ["QUANTILE_LEVELS", "IsotropicPressure", "isotropic_pressure", "population_quantiles"]

Array = NDArray[np.float64]

QUANTILE_LEVELS = (0.05, 0.5, 0.95)
"""Levels of the quantiles: the middle nine tenths and the median."""

ISOTROPIC_COUNT = 200
"""Fibers: the 5 % quantile then has ten below it."""


@dataclass(frozen=True, eq=False)
class IsotropicPressure:
    """Quantiles over fibers that start isotropic, relative to the streamline's pressure [Pa].

    Parameters
    ----------
    levels : (k,) array
        Levels [-], in [0, 1].
    lowest, highest : (..., n, k) array
        Of the surface's lowest and highest pressure at every point.
    extremes : (..., location, 2, k) array
        Of each fiber's extremes, axes location and kind (min, max).
    extremes_error : (..., location, 2, k) array
        What every second fiber alone would give, off ``extremes``: about its error.
    """

    levels: Array
    lowest: Array
    highest: Array
    extremes: Array
    extremes_error: Array


def isotropic_pressure(
    path: FlowHistory,
    response: FiberResponse | ThinningResponse,
    viscosity: Viscosity,
    zone_time: ArrayLike | None,
    count: int = ISOTROPIC_COUNT,
    levels: tuple[float, ...] = QUANTILE_LEVELS,
    tolerance: float = ANGLE_TOLERANCE,
) -> IsotropicPressure:
    """Return quantiles of pressures and extremes for an isotropic start in the plane.

    Parameters
    ----------
    path : FlowHistory
        One path or several.
    response : FiberResponse or ThinningResponse
        The fibers' response.
    viscosity : float, ViscosityLaw or LocalViscosity
        The melt, as in `surface_pressure`.
    zone_time : (3,) or (..., 3) array, or None
        Times at zones 1 to 3 [s], as in `extremes`.
    count : int
        Fibers (`isotropic_angles`).
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
        As in `follow`.
    """
    refuse_no_count("count", count)
    checked_path(path)
    angles = isotropic_angles(count)
    each: Iterator[tuple[Array, Array]]
    if isinstance(response, ThinningResponse):
        found = surface_pressure(
            path, response, viscosity, follow(path, response, angles, tolerance)
        )
        shape = (-1, count, path.time.shape[-1])
        each = zip(found.lowest.reshape(shape), found.highest.reshape(shape), strict=True)
    else:
        refuse_other("response", response, FiberResponse)
        each = _turned_pressures(path, response, viscosity, angles, tolerance)
    return population_quantiles(path, zone_time, levels, lambda _: next(each))


def _turned_pressures(
    path: FlowHistory,
    response: FiberResponse,
    viscosity: Viscosity,
    angles: Array,
    tolerance: float,
) -> Iterator[tuple[Array, Array]]:
    """Yield lowest and highest pressures (n_angles, n) [Pa] path by path.

    The phases alone are asked for, so the motion itself, its spin and its whole turns, is not made.
    """
    size, double = strain_polar(path.plane_gradient)
    n = path.time.shape[-1]
    amplitude = pressure_amplitude(response, viscosity, size).reshape(-1, n)
    double = double.reshape(-1, n)
    deformation, _ = deformation_along(path, response.shape_factor, tolerance)
    start = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    for k in range(len(double)):
        turned = np.einsum("nij,kj->ikn", deformation.line(k).matrix, start)
        phase = double[k] - 2.0 * np.arctan2(turned[1], turned[0])
        lowest, highest = response.support.near(phase)
        yield amplitude[k] * lowest, amplitude[k] * highest


def population_quantiles(
    path: FlowHistory,
    zone_time: ArrayLike | None,
    levels: tuple[float, ...],
    pressures: Callable[[FlowHistory], tuple[Array, Array]],
) -> IsotropicPressure:
    """Return quantiles over a population of fibers, whatever follows them, path by path.

    Parameters
    ----------
    path, zone_time, levels
        As in `isotropic_pressure`.
    pressures : callable
        From one path to the population's lowest and highest pressures (n_fibers, n), relative to
        the streamline's [Pa]; asked in the order of the paths.

    Raises
    ------
    ConfigError
        If a level lies outside [0, 1], or as in `fibermelt.fiber.extremes.locations`.
    """
    _refuse_levels(levels)
    places = {
        place: here.reshape(-1, here.shape[-1])
        for place, here in locations(path, zone_time).items()
    }
    parts = []
    for k, one in enumerate(path.lines):
        lowest, highest = pressures(one)
        found = extreme_values(lowest, highest, {place: here[k] for place, here in places.items()})
        extremes = _quantiles(found, levels)
        error = np.abs(_quantiles(found[::2], levels) - extremes)
        parts.append((_quantiles(lowest, levels), _quantiles(highest, levels), extremes, error))
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
    """Return quantiles over the first axis, levels last: linear between the values in order.

    As `numpy.quantile` has it, which takes three times as long for a choice of the values.
    """
    ordered = np.sort(np.ascontiguousarray(np.moveaxis(values, 0, -1)), axis=-1)
    place = np.array(levels) * (len(values) - 1)
    below = place.astype(np.intp)
    above = np.minimum(below + 1, len(values) - 1)
    part = place - below
    return np.asarray(ordered[..., below] * (1.0 - part) + ordered[..., above] * part)
