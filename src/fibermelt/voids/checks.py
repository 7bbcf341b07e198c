"""What the void laws ask of their input; a refusal names the value, the bound and the way out."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, HistoryError, refuse_no_number

__all__ = [
    "checked_moisture",
    "checked_range",
    "checked_span",
    "checked_value",
    "checked_vapor",
    "refuse_no_path",
]

Array = NDArray[np.float64]

SATURATION_TOLERANCE = 1e-9
"""Largest part by which a moisture may exceed saturation: rounding of the way there and back."""

DRY_IT = "dry the material, or give a moisture that it can hold at this temperature"


def checked_value(
    name: str,
    value: float,
    unit: str = "",
    *,
    above: float = -math.inf,
    least: float = -math.inf,
    most: float = math.inf,
    remedy: str = "",
) -> None:
    """Refuse a constant of a law that is not finite or lies outside its range.

    Parameters
    ----------
    name : str
        What it is called.
    value : float
        The value [unit].
    unit : str
        Its unit, for the message.
    above, least, most : float
        Bounds [unit]: the first is excluded, the others belong to the range.
    remedy : str
        What to do about it.

    Raises
    ------
    ConfigError
        If the value is not finite or outside.
    """
    refuse_no_number(name, value)
    if math.isfinite(value) and value > above and least <= value <= most:
        return
    wanted = _wanted(above, least, most, unit)
    msg = f"{name} = {value:g} {unit}".rstrip() + f": must be {wanted}"
    raise ConfigError(msg + (f"; {remedy}" if remedy else ""))


def checked_range(
    name: str,
    values: ArrayLike,
    bounds: tuple[float, float],
    unit: str = "",
    remedy: str = "",
    *,
    positive: bool = False,
    duration: bool = False,
) -> Array:
    """Return values as an array, or refuse the first that is not finite or outside its range.

    Parameters
    ----------
    name : str
        What they are called.
    values : (...,) array_like
        The values [unit].
    bounds : (float, float)
        The range [unit], both ends included; infinite where there is no bound.
    unit : str
        Their unit, for the message.
    remedy : str
        What to do about it.
    positive : bool
        Whether zero is excluded, besides.
    duration : bool
        As in `fibermelt.arrays.real_array`.

    Raises
    ------
    ConfigError
        If a value is not finite or outside.
    """
    array = real_array(name, values, duration=duration)
    low, high = bounds
    fine = np.isfinite(array) & (array >= low) & (array <= high)
    if positive:
        fine &= array > 0.0
    if not np.all(fine):
        bad = float(array[~fine].flat[0])
        above, least = (0.0, -math.inf) if positive and low <= 0.0 else (-math.inf, low)
        if math.isfinite(least) and math.isfinite(high):
            wanted = f"from {low:.6g} to {high:.6g} {unit}".rstrip()
        else:
            wanted = _wanted(above, least, high, unit)
        msg = f"{name} = {bad:.6g} {unit}".rstrip() + f": must be {wanted}"
        raise ConfigError(msg + (f"; {remedy}" if remedy else ""))
    return array


def _wanted(above: float, least: float, most: float, unit: str) -> str:
    """Return the bounds there are in words, or that a value must be finite."""
    bounds = [
        f"{word} {bound:g} {unit}".rstrip()
        for word, bound in (("above", above), ("at least", least), ("at most", most))
        if math.isfinite(bound)
    ]
    return " and ".join(bounds) if bounds else "finite"


def checked_span(name: str, span: tuple[float, float]) -> None:
    """Refuse temperatures between which a law holds that are not positive or not in order.

    Parameters
    ----------
    name : str
        What they are called.
    span : (float, float)
        The lowest and the highest [K]; may be equal.

    Raises
    ------
    ConfigError
        If they are no such pair.
    """
    cold, hot = span
    checked_value(f"{name}[1]", hot, "K", above=0.0)
    checked_value(f"{name}[0]", cold, "K", above=0.0, most=hot, remedy="the lowest comes first")


def checked_moisture(moisture: ArrayLike, saturation: Array, temperature: Array) -> Array:
    """Return moistures as an array, or refuse the first that is negative or above saturation.

    Parameters
    ----------
    moisture : (...,) array_like
        Mass fraction [-].
    saturation : (...,) array
        What the melt can hold [-].
    temperature : (...,) array
        At which temperature [K], for the message.

    Raises
    ------
    ConfigError
        If a moisture is not a mass fraction or above saturation.
    """
    w = checked_range("moisture", moisture, (0.0, 1.0), "", "write a percentage as 0.17 %")
    w, limit, T = np.broadcast_arrays(w, saturation, temperature)
    beyond = w > limit * (1.0 + SATURATION_TOLERANCE)
    if np.any(beyond):
        worst = np.argmax(beyond)
        msg = (
            f"moisture = {100 * w.flat[worst]:.4g} %: must be at most "
            f"{100 * limit.flat[worst]:.4g} %, saturation at {T.flat[worst]:.5g} K; {DRY_IT}"
        )
        raise ConfigError(msg)
    return w


def checked_vapor(vapor_pressure: ArrayLike, saturation: Array) -> Array:
    """Return vapor pressures as an array, or refuse the first that saturated vapor does not reach.

    Parameters
    ----------
    vapor_pressure : (...,) array_like
        ``P_V`` [Pa, absolute].
    saturation : (...,) array
        The saturation pressure [Pa].

    Raises
    ------
    ConfigError
        If a pressure is negative or above saturation.
    """
    vapor = checked_range("vapor_pressure", vapor_pressure, (0.0, np.inf), "Pa")
    vapor, limit = np.broadcast_arrays(vapor, saturation)
    beyond = vapor > limit * (1.0 + SATURATION_TOLERANCE)
    if np.any(beyond):
        worst = np.argmax(beyond)
        msg = (
            f"vapor_pressure = {vapor.flat[worst]:.6g} Pa: must be at most "
            f"{limit.flat[worst]:.6g} Pa, the saturation pressure of water; no moisture gives more"
        )
        raise ConfigError(msg)
    return vapor


def refuse_no_path(time: Array, name: str, values: Array) -> None:
    """Refuse times and values that are no paths.

    Parameters
    ----------
    time : (..., n) array
        Time [s].
    name : str
        What the values are called, for messages.
    values : (..., n) array
        A value at each time.

    Raises
    ------
    HistoryError
        If there are not as many of one as of the other, at least two, one is not finite, or time
        does not increase.
    """
    n = time.shape[-1] if time.ndim else 0
    if n < 2 or values.ndim == 0 or values.shape[-1] != n:
        msg = (
            f"time has shape {time.shape} and {name} {values.shape}: both need the same number of "
            "points on the last axis, at least 2"
        )
        raise HistoryError(msg)
    for key, array in (("time", time), (name, values)):
        if not np.all(np.isfinite(array)):
            where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
            msg = f"{key}{list(where)} = {array[where]} is not finite"
            raise HistoryError(msg)
    steps = np.diff(time, axis=-1)
    if np.any(steps <= 0.0):
        where = tuple(int(i) for i in np.argwhere(steps <= 0.0)[0])
        msg = f"time must increase strictly: the step after time{list(where)} is {steps[where]:g} s"
        raise HistoryError(msg)
