"""How near to voids paths come: the mechanical margin in time, and the rate at its worst.

A flow's pressure is zero in the surrounding air (gauge), a vapor pressure is absolute. The one
place where they meet is `assess`, which adds the air.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import HistoryError
from fibermelt.voids.checks import checked_range, checked_value, refuse_no_path
from fibermelt.voids.constants import ATMOSPHERE
from fibermelt.voids.criteria import ResidenceCondition
from fibermelt.voids.nucleation import (
    ONE_EVENT,
    ClassicalNucleation,
    critical_radius,
)

__all__ = ["Assessment", "Onset", "assess", "assess_onset"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Assessment:
    """The lowest pressure of paths against a vapor pressure, all of shape (...).

    Parameters
    ----------
    vapor_pressure : (...) array
        ``P_V`` [Pa, absolute].
    lowest_pressure : (...) array
        Lowest local pressure of the path ``P_L`` [Pa, absolute].
    lowest_index : (...) array of int
        At which point of the path.
    lowest_time : (...) array
        When [s].
    time_below : (...) array
        How long the local pressure was below the vapor pressure, in all [s].
    first_below : (...) array
        When it first was [s]; infinite if it never was.
    """

    vapor_pressure: Array
    lowest_pressure: Array
    lowest_index: NDArray[np.intp]
    lowest_time: Array
    time_below: Array
    first_below: Array

    @property
    def margin(self) -> Array:
        """Return ``P_L - P_V`` [Pa]: negative where a bubble can grow, the more the worse."""
        return self.lowest_pressure - self.vapor_pressure

    @property
    def deficit(self) -> Array:
        """Return ``P_V - P_L`` [Pa], what nucleation is driven by."""
        return -self.margin


def assess(
    time: ArrayLike,
    lowest_pressure: ArrayLike,
    vapor_pressure: ArrayLike,
    ambient: float = ATMOSPHERE,
) -> Assessment:
    """Return how near paths come to a vapor pressure, and how long they stay below it.

    The pressure is taken as linear in time between the points of a path.

    Parameters
    ----------
    time : (..., n) array_like
        Time [s], strictly increasing along the last axis; may have fewer or shorter (length one)
        leading axes than the pressure.
    lowest_pressure : (..., n) array_like
        Lowest local pressure on the fiber's surface [Pa, **gauge**: zero in the air].
    vapor_pressure : (...) array_like
        ``P_V`` [Pa, **absolute**], at least 0.
    ambient : float
        Pressure of the air [Pa, absolute], at least 0; one standard atmosphere.

    Returns
    -------
    Assessment
        Of shape (...); pressures in it are absolute.

    Raises
    ------
    HistoryError
        If shapes disagree, a value is not finite or time does not increase.
    ConfigError
        If the vapor pressure or the ambient one is negative.
    """
    t = real_array("time", time, error=HistoryError, duration=True)
    gauge = real_array("lowest_pressure", lowest_pressure, error=HistoryError)
    refuse_no_path(t, "lowest_pressure", gauge)
    checked_value("ambient", ambient, "Pa", least=0.0, remedy="it is absolute: 101325 Pa")
    wanted = checked_range("vapor_pressure", vapor_pressure, (0.0, np.inf), "Pa")
    try:
        leading = np.broadcast_shapes(t.shape[:-1], gauge.shape[:-1], wanted.shape)
    except ValueError as error:
        msg = (
            f"paths of shapes {t.shape[:-1]} (time) and {gauge.shape[:-1]} (lowest_pressure) do "
            f"not go with vapor_pressure of shape {wanted.shape}: give one for each path, or one"
        )
        raise HistoryError(msg) from error
    vapor = np.broadcast_to(wanted, leading)
    t, gauge = (np.broadcast_to(a, (*leading, t.shape[-1])) for a in (t, gauge))
    index = np.argmin(gauge, axis=-1)
    at_lowest = index[..., None]
    excess = gauge + (ambient - vapor)[..., None]
    time_below, first_below = _stay(t, excess)
    return Assessment(
        vapor_pressure=vapor,
        lowest_pressure=np.take_along_axis(gauge, at_lowest, axis=-1)[..., 0] + ambient,
        lowest_index=index,
        lowest_time=np.take_along_axis(t, at_lowest, axis=-1)[..., 0],
        time_below=time_below,
        first_below=first_below,
    )


def _stay(t: Array, excess: Array) -> tuple[Array, Array]:
    """Return how long a polyline is below zero, and when it first is, over the last axis."""
    leading = t.shape[:-1]
    t, excess = (a.reshape(-1, a.shape[-1]) for a in (t, excess))
    below = excess < 0.0
    step = np.diff(t, axis=-1)
    early, late = below[:, :-1], below[:, 1:]
    time_below = np.sum(step, axis=-1, where=early & late)
    first = np.where(below[:, 0], t[:, 0], np.inf)
    # The few intervals with a crossing, gathered: most paths have none or two.
    path, point = np.nonzero(early != late)
    before, after = excess[path, point], excess[path, point + 1]
    entered = after < 0.0
    fraction = before / (before - after)
    part = step[path, point] * np.where(entered, 1.0 - fraction, fraction)
    np.add.at(time_below, path, part)
    entry = np.where(entered, t[path, point] + fraction * step[path, point], np.inf)
    np.minimum.at(first, path, entry)
    return time_below.reshape(leading), first.reshape(leading)


@dataclass(frozen=True, eq=False)
class Onset:
    """What classical nucleation says at the lowest pressure of paths, all of shape (...).

    Parameters
    ----------
    critical_radius : (...) array
        ``r_c`` [m]; infinite where there is no deficit.
    critical_time : (...) array or None
        ``t_n`` [s]; None without a diffusivity.
    log10_rate : (...) array
        Of ``J`` [1/(m3 s)]; minus infinity where there is no deficit.
    required_wetting_factor : (...) array
        ``S`` [-] at which nucleation would start.
    required_contact_angle : (...) array
        Young's angle through the melt [rad] at which it would.
    rate_margin : (...) array
        Decades from the rate to the threshold; negative where nuclei form.
    residence_margin : (...) array or None
        Decades from the time below ``P_V`` to ``t_n``; negative where a nucleus has the time.
    """

    critical_radius: Array
    critical_time: Array | None
    log10_rate: Array
    required_wetting_factor: Array
    required_contact_angle: Array
    rate_margin: Array
    residence_margin: Array | None


def assess_onset(
    assessment: Assessment,
    nucleation: ClassicalNucleation,
    residence: ResidenceCondition | None = None,
    log10_threshold: float = ONE_EVENT,
) -> Onset:
    """Return what classical nucleation says at the lowest pressure of each path.

    Parameters
    ----------
    assessment : Assessment
        The paths.
    nucleation : ClassicalNucleation
        The melt at its temperature and moisture.
    residence : ResidenceCondition or None
        How fast vapor gathers, held against the time below the vapor pressure; None where the
        diffusivity is not known.
    log10_threshold : float
        log10 of the rate [1/(m3 s)] that counts as nucleation.

    Raises
    ------
    ConfigError
        If the threshold is not below what the melt can reach at all.
    """
    deficit = assessment.deficit
    radius = critical_radius(nucleation.tension, deficit)
    rate = nucleation.log10_rate(deficit)
    available = assessment.time_below
    return Onset(
        critical_radius=radius,
        critical_time=residence.time(radius) if residence else None,
        log10_rate=rate,
        required_wetting_factor=nucleation.required_wetting_factor(deficit, log10_threshold),
        required_contact_angle=nucleation.required_contact_angle(deficit, log10_threshold),
        rate_margin=log10_threshold - rate,
        residence_margin=residence.margin(radius, available) if residence else None,
    )
