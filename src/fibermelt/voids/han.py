"""Nucleation in a polymer solution after Han and Han (the paper's Eq. 40-44)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.voids.checks import checked_range, checked_value
from fibermelt.voids.constants import BOLTZMANN
from fibermelt.voids.nucleation import LN10, ONE_EVENT, critical_radius, log10_barrier
from fibermelt.voids.solution import log_activity

__all__ = ["HanConstants", "HanHan", "bubble_pressure"]

Array = NDArray[np.float64]


def bubble_pressure(
    pressure: ArrayLike,
    radius: ArrayLike,
    tension: float,
    growth_rate: float = 0.0,
    density: float = 0.0,
    viscosity: float = 0.0,
) -> Array:
    """Return the pressure inside a bubble that grows [Pa, absolute] (the paper's Eq. 44).

    ``P_G = (3/2) rho v^2 + 2 eta/r_c + 4 mu_0 v/r_c + P_L``, ``v = dr_c/dt``.

    Parameters
    ----------
    pressure : (...,) array_like
        Local pressure of the melt ``P_L`` [Pa, absolute].
    radius : (...,) array_like
        ``r_c`` [m], > 0, may be infinite.
    tension : float
        ``eta`` [N/m], at least 0.
    growth_rate : float
        ``v`` [m/s], at least 0; at rest ``P_G`` at the critical radius is the vapor pressure.
    density, viscosity : float
        ``rho`` [kg/m3] and ``mu_0`` at zero shear [Pa s] of the melt, at least 0; only a bubble
        that grows needs them.

    Raises
    ------
    ConfigError
        If a value is out of range.
    """
    P = checked_range("pressure", pressure, (-np.inf, np.inf), "Pa")
    r = real_array("radius", radius)
    if not np.all(r > 0.0):
        checked_value("bubble radius", float(r[~(r > 0.0)].flat[0]), "m", above=0.0)
    for name, value, unit in (
        ("surface tension", tension, "N/m"),
        ("growth rate", growth_rate, "m/s"),
        ("density", density, "kg/m3"),
        ("viscosity", viscosity, "Pa s"),
    ):
        checked_value(name, value, unit, least=0.0)
    return P + 1.5 * density * growth_rate**2 + (2.0 * tension + 4.0 * viscosity * growth_rate) / r


@dataclass(frozen=True)
class HanConstants:
    """What Han and Han's rate needs of a polymer and its volatile, and nobody can derive.

    Parameters
    ----------
    prefactor : float
        ``B_1`` [-], > 0.
    prefactor_temperature : float
        ``B_2`` [K].
    interaction : float
        ``chi`` [-].
    """

    prefactor: float
    prefactor_temperature: float
    interaction: float


@dataclass(frozen=True)
class HanHan:
    """The rate of nucleation in a polymer solution (the paper's Eq. 40, 41 and 43).

    ``J = N_v B_F exp(-F*/(n k_B T))``, ``B_F = B_1 D/(4 pi r_c^2) exp(-B_2/T)``,
    ``F* = 16 pi eta^3/(3 (P_V - P_L)^2) - n k_B T {ln(phi_1 P_G/P_V) + phi_2 (1 - V_1/V_2) +
    chi phi_2^2}``, with the division of Eq. 43 restored.

    Parameters
    ----------
    tension : float
        ``eta`` [N/m], > 0.
    temperature : float
        ``T`` [K], > 0.
    molecules : float
        ``N_v`` of the volatile [1/m3], > 0.
    diffusivity : float
        ``D`` of the volatile [m2/s], > 0; see `fibermelt.voids.diffusion`.
    solvent_fraction : float
        Volume fraction of the volatile ``phi_1`` [-], above 0, at most 1.
    interaction : float
        ``chi`` [-].
    prefactor, prefactor_temperature : float
        ``B_1`` [-], > 0, and ``B_2`` [K]: empirical, of the polymer and the volatile; no published
        pair for water in a printed polymer is known here.
    nucleus : float
        ``n`` [-], > 0, which the paper leaves undefined: over how many molecules of the nucleus the
        work is spread. One gives the classical barrier, the reading that promises least.
    molar_volume_ratio : float
        ``V_1/V_2`` [-], from 0 to 1, much below one in a polymer.

    Raises
    ------
    ConfigError
        If a value is out of range.

    Notes
    -----
    For a bubble at rest ``P_G = P_V`` and the braces are ``ln a_1``, the activity: the solution
    nucleates ``a_1`` times as often as the pure volatile of the same barrier. Without a deficit
    there is no critical bubble, and the rate is zero.

    References
    ----------
    Han and Han, J. Polym. Sci. B 28 (1990) 743.
    """

    source: ClassVar[str] = "Han and Han 1990; the paper, Eq. 40-44 with Eq. 43 corrected"

    tension: float
    temperature: float
    molecules: float
    diffusivity: float
    solvent_fraction: float
    interaction: float
    prefactor: float
    prefactor_temperature: float
    nucleus: float = 1.0
    molar_volume_ratio: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what has no rate."""
        checked_value("surface tension", self.tension, "N/m", above=0.0)
        checked_value("temperature", self.temperature, "K", above=0.0)
        checked_value("molecules", self.molecules, "1/m3", above=0.0)
        checked_value("diffusivity", self.diffusivity, "m2/s", above=0.0)
        checked_value("solvent fraction", self.solvent_fraction, above=0.0, most=1.0)
        checked_value("interaction", self.interaction)
        checked_value("prefactor", self.prefactor, above=0.0)
        checked_value("prefactor temperature", self.prefactor_temperature, "K")
        checked_value("nucleus", self.nucleus, above=0.0)
        checked_value("molar volume ratio", self.molar_volume_ratio, least=0.0, most=1.0)

    def log10_frequency(self, deficit: ArrayLike) -> Array:
        """Return log10 of ``B_F`` [1/s] (Eq. 41) at deficits [Pa], shape (...,)."""
        constant = math.log10(self.prefactor * self.diffusivity / (4.0 * math.pi))
        radius = critical_radius(self.tension, deficit)
        arrhenius = self.prefactor_temperature / self.temperature / LN10
        frequency: Array = constant - 2.0 * np.log10(radius) - arrhenius
        return frequency

    def log10_rate(self, deficit: ArrayLike, saturation: ArrayLike = 1.0) -> Array:
        """Return log10 of ``J`` [1/(m3 s)].

        Parameters
        ----------
        deficit : (...,) array_like
            ``P_V - P_L`` [Pa].
        saturation : (...,) array_like
            ``P_G/P_V`` [-], > 0, of the bubble; see `bubble_pressure`.

        Returns
        -------
        (...,) array
            Minus infinity where there is no deficit.
        """
        degree = checked_range("saturation", saturation, (0.0, np.inf), positive=True)
        thermal = math.log10(self.nucleus * BOLTZMANN * self.temperature)
        with np.errstate(over="ignore"):  # 10**400 of k_B T: minus infinity is the limit
            barrier = 10.0 ** (log10_barrier(self.tension, deficit) - thermal)
        activity = log_activity(self.solvent_fraction, self.interaction, self.molar_volume_ratio)
        exponent = barrier - activity - np.log(degree)
        return math.log10(self.molecules) + self.log10_frequency(deficit) - exponent / LN10

    def margin(self, deficit: ArrayLike, log10_threshold: float = ONE_EVENT) -> Array:
        """Return how far the rate is below a threshold [decades], shape (...,)."""
        return log10_threshold - self.log10_rate(deficit)
