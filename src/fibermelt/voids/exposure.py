"""How long and how deep a nucleus is below the vapor pressure: its growth exponent.

A bubble without surface tension in a Newtonian melt, with vapor to spare, grows by
``R'/R = (P_V - p)/(4 eta)`` (`fibermelt.voids.growth`): the integral of that, where it is positive,
is the logarithm of the growth. It needs neither the nucleus' size nor the number of nuclei.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import HistoryError
from fibermelt.voids.checks import checked_range, refuse_no_path

__all__ = ["GrowthExponent", "growth_exponent"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GrowthExponent:
    """The growth exponent of paths, both of shape (...).

    Parameters
    ----------
    value : (...) array
        ``G`` [-], at least 0.
    error : (...) array
        By how much every second point would have it otherwise [-].
    """

    value: Array
    error: Array


def growth_exponent(
    time: ArrayLike,
    pressure: ArrayLike,
    vapor_pressure: ArrayLike,
    viscosity: ArrayLike,
    until: ArrayLike = np.inf,
) -> GrowthExponent:
    """Return ``G = integral max(0, (P_V - p)/(4 eta)) dt`` of paths.

    The integrand before its cut at zero is taken as linear in time between the points of a path;
    where it changes its sign follows exactly.

    Parameters
    ----------
    time : (..., n) array_like
        Time [s], strictly increasing along the last axis; leading axes of all go by broadcasting.
    pressure : (..., n) array_like
        Lowest local pressure ``p`` [Pa, **absolute**].
    vapor_pressure : (...) array_like
        ``P_V`` [Pa, absolute], at least 0.
    viscosity : (..., n) array_like
        Of the melt ``eta`` [Pa s], > 0.
    until : (...) array_like
        When to end [s]; beyond the last point there is nothing.

    Raises
    ------
    HistoryError
        If shapes disagree, a value is not finite or time does not increase.
    ConfigError
        If a vapor pressure is negative, a viscosity not positive, or an end no number.
    """
    t = real_array("time", time, error=HistoryError, duration=True)
    p = real_array("pressure", pressure, error=HistoryError)
    refuse_no_path(t, "pressure", p)
    vapor = checked_range("vapor_pressure", vapor_pressure, (0.0, np.inf), "Pa")
    eta = checked_range("viscosity", viscosity, (0.0, np.inf), "Pa s", positive=True)
    end = real_array("until", until, error=HistoryError, duration=True)
    if np.any(np.isnan(end)):
        msg = "until is no number: leave it away where a path has no end but its last point"
        raise HistoryError(msg)
    try:
        rate = (vapor[..., None] - p) / (4.0 * eta)
        t, rate, end = np.broadcast_arrays(t, rate, end[..., None])
    except ValueError as error:
        msg = (
            f"time {t.shape}, pressure {p.shape}, viscosity {eta.shape}, vapor_pressure "
            f"{vapor.shape} and until {end.shape} do not go together: paths are along the last "
            "axis of the first three, the others have one value for each path, or one"
        )
        raise HistoryError(msg) from error
    end = end[..., 0]
    value = _positive_part(t, rate, end)
    n = t.shape[-1]
    every_second = np.unique([*range(0, n, 2), n - 1])
    coarse = _positive_part(t[..., every_second], rate[..., every_second], end)
    return GrowthExponent(value, np.abs(value - coarse))


def _positive_part(time: Array, rate: Array, end: Array) -> Array:
    """Return the integral of what is positive of a polyline (..., n), up to an end (...)."""
    step = np.diff(time, axis=-1)
    share = np.clip((end[..., None] - time[..., :-1]) / step, 0.0, 1.0)
    first = rate[..., :-1]
    last = first + share * (rate[..., 1:] - first)
    high = np.maximum(first, last)
    # Of an interval with a crossing a triangle is positive, whose base is high/(high - low) of it.
    spread = high - np.minimum(first, last)
    crosses = (first < 0.0) != (last < 0.0)
    base = np.divide(high, spread, out=np.ones_like(high), where=crosses & (spread > 0.0))
    mean = np.where(crosses, 0.5 * high * base, np.maximum(0.5 * (first + last), 0.0))
    whole: Array = np.sum(mean * share * step, axis=-1)
    return whole
