"""How fast the volatile diffuses to a nucleus: Arrhenius, and the free volume of a solution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError
from fibermelt.voids.checks import checked_range, checked_span, checked_value
from fibermelt.voids.constants import GAS_CONSTANT

__all__ = ["Arrhenius", "FreeVolume"]

Array = NDArray[np.float64]

ANY_TEMPERATURE = (1.0, 2000.0)
"""Temperatures [K] of a law whose range nobody gave: wide, so that only nonsense is refused."""


@dataclass(frozen=True)
class Arrhenius:
    """A diffusivity that grows with temperature, ``D = D_0 exp(-A_E/T)`` (below Eq. 38).

    Parameters
    ----------
    prefactor : float
        ``D_0`` [m2/s], > 0.
    activation_temperature : float
        ``A_E`` [K], at least 0: the activation energy over the gas constant.
    temperatures : (float, float)
        Where the law is used [K].

    Raises
    ------
    ConfigError
        If a value is out of range.
    """

    source: ClassVar[str] = "the paper, Appendix I, below Eq. 38"

    prefactor: float
    activation_temperature: float
    temperatures: tuple[float, float] = ANY_TEMPERATURE

    def __post_init__(self) -> None:
        """Refuse what is no diffusivity."""
        checked_value("diffusion.prefactor", self.prefactor, "m2/s", above=0.0)
        checked_value(
            "diffusion.activation_temperature", self.activation_temperature, "K", least=0.0
        )
        checked_span("diffusion.temperatures", self.temperatures)

    @classmethod
    def of_energy(
        cls,
        prefactor: float,
        energy: float,
        temperatures: tuple[float, float] = ANY_TEMPERATURE,
    ) -> Arrhenius:
        """Return the law of an activation energy [J/mol], ``A_E = E/R``.

        Parameters
        ----------
        prefactor : float
            ``D_0`` [m2/s], > 0.
        energy : float
            ``E`` [J/mol], at least 0.
        temperatures : (float, float)
            Where the law is used [K].
        """
        return cls(prefactor, energy / GAS_CONSTANT, temperatures)

    def diffusivity(self, temperature: ArrayLike) -> Array:
        """Return ``D`` [m2/s] at a temperature [K], shape (...,).

        Raises
        ------
        ConfigError
            If a temperature is outside the law's range.
        """
        T = checked_range("temperature", temperature, self.temperatures, "K", "use another card")
        D: Array = self.prefactor * np.exp(-self.activation_temperature / T)
        return D


@dataclass(frozen=True)
class FreeVolume:
    """Diffusion in a polymer solution by its free volume, after Vrentas and Duda.

    The self-diffusivity of the solvent (1) in the polymer (2) is
    ``D_1 = D_0 exp(-E/RT) exp[-(w_1 V_1* + xi w_2 V_2*)/V_F]`` with
    ``V_F = w_1 K_11 (K_21 - T_g1 + T) + w_2 K_12 (K_22 - T_g2 + T)``, both over the overlap factor
    ``gamma`` (the paper's zeta), and the mutual one ``D = D_1 (1 - phi_1)^2 (1 - 2 chi phi_1)``.
    That is the paper's Eq. 42 with the minus sign that its second exponential has lost.

    Parameters
    ----------
    prefactor : float
        ``D_0`` [m2/s], > 0.
    energy : float
        ``E`` [J/mol], at least 0: what a molecule needs to leave its neighbors.
    jump_volumes : (float, float)
        ``V_1*``, ``V_2*`` [m3/kg], > 0: specific hole volumes for a jump.
    jump_ratio : float
        ``xi`` [-] (the paper's q), > 0: molar volume of a jumping unit, solvent over polymer.
    hole_growth : (float, float)
        ``K_11/gamma``, ``K_12/gamma`` [m3/(kg K)], > 0.
    offsets : (float, float)
        ``K_21 - T_g1``, ``K_22 - T_g2`` [K].
    interaction : float
        Flory and Huggins' ``chi`` [-].
    specific_volumes : (float, float)
        Of solvent and polymer [m3/kg], > 0, for ``phi_1``; equal ones make it ``w_1``.

    Raises
    ------
    ConfigError
        If a value is out of range.

    References
    ----------
    Vrentas and Duda 1977, doi 10.1002/pol.1977.180150302 and following.
    """

    source: ClassVar[str] = "Vrentas and Duda 1977; the paper, Eq. 42 with the sign corrected"

    prefactor: float
    energy: float
    jump_volumes: tuple[float, float]
    jump_ratio: float
    hole_growth: tuple[float, float]
    offsets: tuple[float, float]
    interaction: float
    specific_volumes: tuple[float, float] = (1e-3, 1e-3)

    def __post_init__(self) -> None:
        """Refuse what is no solution."""
        checked_value("free_volume.prefactor", self.prefactor, "m2/s", above=0.0)
        checked_value("free_volume.energy", self.energy, "J/mol", least=0.0)
        checked_value("free_volume.jump_ratio", self.jump_ratio, above=0.0)
        checked_value("free_volume.interaction", self.interaction)
        for name, unit in (
            ("jump_volumes", "m3/kg"),
            ("hole_growth", "m3/(kg K)"),
            ("specific_volumes", "m3/kg"),
        ):
            for value in getattr(self, name):
                checked_value(f"free_volume.{name}", value, unit, above=0.0)
        for value in self.offsets:
            checked_value("free_volume.offsets", value, "K")

    def volume_fraction(self, solvent: ArrayLike) -> Array:
        """Return ``phi_1`` [-] of a mass fraction ``w_1`` [-], shape (...,)."""
        w1 = checked_range("solvent mass fraction", solvent, (0.0, 1.0))
        volume = w1 * self.specific_volumes[0]
        return volume / (volume + (1.0 - w1) * self.specific_volumes[1])

    def self_diffusivity(self, solvent: ArrayLike, temperature: ArrayLike) -> Array:
        """Return ``D_1`` [m2/s].

        Parameters
        ----------
        solvent : (...,) array_like
            Mass fraction of the solvent ``w_1`` [-], from 0 to 1.
        temperature : (...,) array_like
            Temperature [K], above that at which the free volume vanishes.

        Raises
        ------
        ConfigError
            If a fraction is out of range, or the solution has no free volume: it is a glass.
        """
        w1 = checked_range("solvent mass fraction", solvent, (0.0, 1.0))
        T = checked_range("temperature", temperature, ANY_TEMPERATURE, "K")
        w2 = 1.0 - w1
        free = w1 * self.hole_growth[0] * (self.offsets[0] + T) + w2 * self.hole_growth[1] * (
            self.offsets[1] + T
        )
        if np.any(free <= 0.0):
            coldest = float(np.broadcast_to(T, free.shape)[free <= 0.0].flat[0])
            msg = (
                f"temperature = {coldest:.5g} K: the solution has no free volume there, it is a "
                "glass; the law holds for melts and rubbers"
            )
            raise ConfigError(msg)
        needed = w1 * self.jump_volumes[0] + self.jump_ratio * w2 * self.jump_volumes[1]
        D1: Array = self.prefactor * np.exp(-self.energy / (GAS_CONSTANT * T) - needed / free)
        return D1

    def diffusivity(self, solvent: ArrayLike, temperature: ArrayLike) -> Array:
        """Return the mutual ``D`` [m2/s]; parameters and refusals as of `self_diffusivity`.

        Raises
        ------
        ConfigError
            Also if ``2 chi phi_1 > 1``: a solution that is about to demix does not diffuse.
        """
        solved = self.volume_fraction(solvent)
        ideality = 1.0 - 2.0 * self.interaction * solved
        if np.any(ideality < 0.0):
            bound = 0.5 / self.interaction
            msg = (
                f"solvent volume fraction = {float(np.max(solved)):.4g}: must be at most "
                f"{bound:.4g}, where 2 chi phi_1 = 1 and the solution demixes"
            )
            raise ConfigError(msg)
        return self.self_diffusivity(solvent, temperature) * (1.0 - solved) ** 2 * ideality
