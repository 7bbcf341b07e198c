"""The classical rate of nucleation, and its inverses.

A margin is positive where nothing starts. The deficit is ``P_V - P_L``, vapor
pressure less local pressure, both absolute; where it is zero or negative there is no critical
bubble: the radius is infinite and the rate is zero, of logarithm minus infinity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.voids.checks import checked_range, checked_value
from fibermelt.voids.constants import AVOGADRO, BOLTZMANN, WATER_MOLAR_MASS, WATER_MOLECULE
from fibermelt.voids.wetting import vapor_angle

__all__ = [
    "ClassicalNucleation",
    "checked_deficit",
    "critical_radius",
    "log10_barrier",
    "molecules_per_volume",
]

Array = NDArray[np.float64]

LN10 = math.log(10.0)

ONE_EVENT = 0.0
"""Threshold of log10 J: one nucleus in a cubic meter and second (the paper's ``J >= 1``). What it
is counted in matters little: a factor of 1e6 moves the deficit it takes by less than 10 %."""


LEAST_BARRIER = 1e-9
"""Decades that a threshold stays below the prefactor: a barrier of none divides by zero."""


def checked_deficit(deficit: ArrayLike) -> Array:
    """Return pressure deficits [Pa] as an array; refuse what is not finite."""
    return checked_range("pressure deficit", deficit, (-np.inf, np.inf), "Pa")


def molecules_per_volume(
    moisture: ArrayLike, density: float, molar_mass: float = WATER_MOLAR_MASS
) -> Array:
    """Return the molecules of the volatile in a volume of melt, ``N_v = w rho N_A/M`` [1/m3].

    Parameters
    ----------
    moisture : (...,) array_like
        Mass fraction ``w`` [-], 0 to 1.
    density : float
        Density of the melt [kg/m3], > 0.
    molar_mass : float
        ``M`` of the volatile [kg/mol], > 0.

    Raises
    ------
    ConfigError
        If a value is out of range.
    """
    w = checked_range("moisture", moisture, (0.0, 1.0))
    checked_value("density", density, "kg/m3", above=0.0)
    checked_value("molar mass", molar_mass, "kg/mol", above=0.0)
    return w * (density * AVOGADRO / molar_mass)


def critical_radius(tension: float, deficit: ArrayLike) -> Array:
    """Return ``r_c = 2 eta/(P_V - P_L)`` [m] (the paper's Eq. 39).

    Parameters
    ----------
    tension : float
        Surface tension ``eta`` [N/m], > 0.
    deficit : (...,) array_like
        ``P_V - P_L`` [Pa].

    Returns
    -------
    (...,) array
        A smaller bubble dissolves, a larger one grows. Infinite without a deficit.

    Raises
    ------
    ConfigError
        If the tension is not positive or a deficit is not finite.
    """
    checked_value("surface tension", tension, "N/m", above=0.0)
    dP = checked_deficit(deficit)
    radius = np.full(dP.shape, np.inf)
    with np.errstate(over="ignore"):  # a deficit near the smallest float: infinite is its limit
        np.divide(2.0 * tension, dP, out=radius, where=dP > 0.0)
    return radius


def log10_barrier(tension: float, deficit: ArrayLike) -> Array:
    """Return log10 of the work of the critical bubble, ``W* = 16 pi eta^3/(3 (P_V - P_L)^2)`` [J].

    The exponent of the paper's Eq. 36 and the first term of its Eq. 43, with the division restored.

    Parameters
    ----------
    tension : float
        ``eta`` [N/m], > 0.
    deficit : (...,) array_like
        ``P_V - P_L`` [Pa]; the logarithm is infinite where it is not positive.

    Raises
    ------
    ConfigError
        If the tension is not positive or a deficit is not finite.
    """
    checked_value("surface tension", tension, "N/m", above=0.0)
    dP = checked_deficit(deficit)
    logarithm = np.full(dP.shape, -np.inf)
    np.log10(dP, out=logarithm, where=dP > 0.0)
    barrier: Array = math.log10(16.0 * math.pi / 3.0) + 3.0 * math.log10(tension) - 2.0 * logarithm
    return barrier


@dataclass(frozen=True)
class ClassicalNucleation:
    """The classical rate, homogeneous and heterogeneous (the paper's Eq. 36).

    ``J = N_v sqrt(2 eta/(pi m)) exp(-W* S(phi)/(k_B T))``, ``W* = 16 pi eta^3/(3 (P_V - P_L)^2)``.
    With the tension of a polymer melt the homogeneous barrier is thousands of ``k_B T``: the rate
    is zero at any pressure a bead sees, and what tells something is the inverse, the wetting
    factor or the deficit at which nucleation would start.

    Parameters
    ----------
    tension : float
        Surface tension ``eta`` of the melt at its temperature [N/m], > 0.
    temperature : float
        ``T`` [K], > 0.
    molecules : float
        Molecules of the volatile per volume ``N_v`` [1/m3], > 0; see `molecules_per_volume`.
    molecule_mass : float
        ``m`` [kg], > 0; water by default.
    wetting_factor : float
        ``S(phi)`` [-], above 0, at most 1: 1 is homogeneous; see `fibermelt.voids.wetting`.

    Raises
    ------
    ConfigError
        If a value is out of range.

    References
    ----------
    Blander and Katz 1975, doi 10.1002/aic.690210502; Colton and Suh 1987,
    doi 10.1002/pen.760270702.
    """

    source: ClassVar[str] = "the paper, Eq. 36-37; Blander and Katz 1975"

    tension: float
    temperature: float
    molecules: float
    molecule_mass: float = WATER_MOLECULE
    wetting_factor: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what has no rate."""
        checked_value("surface tension", self.tension, "N/m", above=0.0)
        checked_value("temperature", self.temperature, "K", above=0.0)
        remedy = "a dry melt does not nucleate: give some moisture"
        checked_value("molecules", self.molecules, "1/m3", above=0.0, remedy=remedy)
        checked_value("molecule mass", self.molecule_mass, "kg", above=0.0)
        checked_value("wetting factor", self.wetting_factor, above=0.0, most=1.0)

    @property
    def log10_prefactor(self) -> float:
        """Return log10 of ``N_v sqrt(2 eta/(pi m))`` [1/(m3 s)]: the rate without a barrier."""
        frequency = 0.5 * math.log10(2.0 * self.tension / (math.pi * self.molecule_mass))
        return math.log10(self.molecules) + frequency

    def log10_barrier_ratio(self, deficit: ArrayLike) -> Array:
        """Return log10 of ``W* S/(k_B T)`` [-] at deficits [Pa], shape (...,)."""
        thermal = math.log10(BOLTZMANN * self.temperature / self.wetting_factor)
        return log10_barrier(self.tension, deficit) - thermal

    def log10_rate(self, deficit: ArrayLike) -> Array:
        """Return log10 of the rate ``J`` [1/(m3 s)] at deficits [Pa], shape (...,).

        Minus infinity where there is no deficit, and where the logarithm itself overflows.
        """
        with np.errstate(over="ignore"):  # 10**400 of k_B T: minus infinity is the limit
            return self.log10_prefactor - 10.0 ** self.log10_barrier_ratio(deficit) / LN10

    def margin(self, deficit: ArrayLike, log10_threshold: float = ONE_EVENT) -> Array:
        """Return how far the rate is below a threshold [decades], shape (...,)."""
        return log10_threshold - self.log10_rate(deficit)

    def required_deficit(self, log10_threshold: float = ONE_EVENT) -> float:
        """Return the deficit [Pa] at which the rate reaches a threshold.

        ``sqrt(16 pi eta^3 S/(3 k_B T ln(J_0/J)))``, the inverse of Eq. 36; ``J_0`` the prefactor.

        Raises
        ------
        ConfigError
            If the threshold is not below the prefactor, which no pressure exceeds.
        """
        log10_height = math.log10(self._height(log10_threshold) * BOLTZMANN * self.temperature)
        work = float(log10_barrier(self.tension, 1.0)) + math.log10(self.wetting_factor)
        return math.sqrt(10.0 ** (work - log10_height))

    def required_wetting_factor(
        self, deficit: ArrayLike, log10_threshold: float = ONE_EVENT
    ) -> Array:
        """Return the wetting factor ``S`` [-] at which the rate reaches a threshold.

        ``S = 3 k_B T (P_V - P_L)^2 ln(J_0/J)/(16 pi eta^3)``.

        Parameters
        ----------
        deficit : (...,) array_like
            ``P_V - P_L`` [Pa].
        log10_threshold : float
            log10 of the rate [1/(m3 s)].

        Returns
        -------
        (...,) array
            A surface of a smaller factor nucleates. Above 1 the melt nucleates without any surface;
            zero where there is no deficit, so that no surface suffices.

        Raises
        ------
        ConfigError
            If the threshold is not below the prefactor.
        """
        height = math.log10(self._height(log10_threshold) * BOLTZMANN * self.temperature)
        with np.errstate(over="ignore"):  # a deficit of 1e154 Pa: infinite is its limit
            factor: Array = 10.0 ** (height - log10_barrier(self.tension, deficit))
        return factor

    def required_contact_angle(
        self, deficit: ArrayLike, log10_threshold: float = ONE_EVENT
    ) -> Array:
        """Return the contact angle through the melt [rad] at which the rate reaches a threshold.

        A surface that the melt wets less (of a larger angle) nucleates. Zero where the melt
        nucleates without a surface, pi where there is no deficit; otherwise as
        `required_wetting_factor`.
        """
        factor = self.required_wetting_factor(deficit, log10_threshold)
        alone = factor >= 1.0
        return np.where(alone, 0.0, np.pi - vapor_angle(np.where(alone, 1.0, factor)))

    def _height(self, log10_threshold: float) -> float:
        """Return ``ln(J_0/J)`` [-], the barrier in ``k_B T`` that leaves the threshold."""
        checked_value(
            "log10 of the threshold rate",
            log10_threshold,
            most=self.log10_prefactor - LEAST_BARRIER,
            remedy="the melt cannot nucleate faster than its molecules attempt to",
        )
        return (self.log10_prefactor - log10_threshold) * LN10
