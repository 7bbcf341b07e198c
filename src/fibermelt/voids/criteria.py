"""The mechanical criterion and the residence condition of a void.

Their margins are positive where nothing starts: the first in pascals, the second in decades.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.voids.checks import checked_range, checked_value

__all__ = ["MechanicalCriterion", "ResidenceCondition"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MechanicalCriterion:
    """A bubble can grow where the local pressure is below the vapor pressure, ``P_L < P_V``.

    Necessary for nucleation and, where gas sits in crevices of a fiber already, sufficient.

    Parameters
    ----------
    vapor_pressure : float
        ``P_V`` [Pa, absolute], at least 0.

    Raises
    ------
    ConfigError
        If it is negative.
    """

    source: ClassVar[str] = "the paper, Appendix I (after Roychowdhury et al. 2001)"

    vapor_pressure: float

    def __post_init__(self) -> None:
        """Refuse what is no vapor pressure."""
        checked_value("vapor pressure", self.vapor_pressure, "Pa", least=0.0)

    def margin(self, pressure: ArrayLike) -> Array:
        """Return ``P_L - P_V`` [Pa] of local pressures [Pa, absolute], shape (...,)."""
        P = checked_range("pressure", pressure, (-np.inf, np.inf), "Pa")
        return P - self.vapor_pressure

    def is_met(self, pressure: ArrayLike) -> NDArray[np.bool_]:
        """Return where a bubble can grow, shape (...,)."""
        met: NDArray[np.bool_] = self.margin(pressure) < 0.0
        return met


@dataclass(frozen=True)
class ResidenceCondition:
    """A nucleus must gather its vapor in the time there is, ``t_n = r_c^2/D < t_d`` (Eq. 38).

    Parameters
    ----------
    diffusivity : float
        ``D`` of the volatile in the melt [m2/s], > 0.

    Raises
    ------
    ConfigError
        If it is not positive.
    """

    source: ClassVar[str] = "the paper, Eq. 38 and the text below Eq. 39"

    diffusivity: float

    def __post_init__(self) -> None:
        """Refuse what is no diffusivity."""
        checked_value("diffusivity", self.diffusivity, "m2/s", above=0.0)

    def time(self, radius: ArrayLike) -> Array:
        """Return ``t_n`` [s] of critical radii [m], shape (...,); infinite with the radius.

        Raises
        ------
        ConfigError
            If a radius is not positive.
        """
        r = real_array("critical radius", radius)
        if not np.all(r > 0.0):
            checked_value("critical radius", float(r[~(r > 0.0)].flat[0]), "m", above=0.0)
        return r**2 / self.diffusivity

    def margin(self, radius: ArrayLike, available: ArrayLike) -> Array:
        """Return ``log10(t_n/t_d)`` [decades].

        Parameters
        ----------
        radius : (...,) array_like
            Critical radius [m], > 0, may be infinite.
        available : (...,) array_like
            The time there is ``t_d`` [s], at least 0: on the streamline, or below ``P_V``.

        Returns
        -------
        (...,) array
            Positive infinity where there is no critical bubble or no time.

        Raises
        ------
        ConfigError
            If a radius is not positive, or a time negative or not finite.
        """
        time = checked_range("available time", available, (0.0, np.inf), "s", duration=True)
        t_n, t_d = np.broadcast_arrays(self.time(radius), time)
        margin = np.full(t_n.shape, np.inf)
        possible = np.isfinite(t_n) & (t_d > 0.0)
        margin[possible] = np.log10(t_n[possible]) - np.log10(t_d[possible])
        return margin
