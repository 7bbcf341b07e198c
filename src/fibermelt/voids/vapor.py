"""Moisture in the melt and the vapor pressure that it makes, both ways.

Every law here is an isotherm: ``vapor_pressure(moisture, temperature)`` and its inverse
``moisture(vapor_pressure, temperature)``, which is the critical moisture where the vapor pressure
equals the local pressure. Pressures are absolute, moisture is a mass fraction of the wet polymer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.voids.checks import (
    checked_moisture,
    checked_range,
    checked_span,
    checked_value,
    checked_vapor,
)
from fibermelt.voids.constants import GAS_CONSTANT, WATER_CRITICAL, WATER_TRIPLE
from fibermelt.voids.saturation import saturation_pressure

__all__ = ["ActivityLaw", "Henry", "Isotherm", "critical_moisture", "van_t_hoff"]

Array = NDArray[np.float64]

WATER_LIQUID = (WATER_TRIPLE, WATER_CRITICAL)
"""Temperatures [K] at which water has a vapor pressure to speak of."""


class Isotherm(Protocol):
    """How much moisture a melt holds at a vapor pressure, and the other way round."""

    def saturation_content(self, temperature: ArrayLike) -> Array:
        """Return the moisture [-] in equilibrium with saturated vapor, shape (...,)."""

    def vapor_pressure(self, moisture: ArrayLike, temperature: ArrayLike) -> Array:
        """Return the vapor pressure [Pa, absolute], shape (...,)."""

    def moisture(self, vapor_pressure: ArrayLike, temperature: ArrayLike) -> Array:
        """Return the moisture [-], a mass fraction, shape (...,)."""


def van_t_hoff(heat: float, temperature: ArrayLike, reference_temperature: float) -> Array:
    """Return ``exp(-heat/R (1/T - 1/T_ref))`` [-], the change of an equilibrium constant.

    Parameters
    ----------
    heat : float
        Molar enthalpy [J/mol], negative where heat is set free, taken as constant.
    temperature : (...,) array_like
        Temperature ``T`` [K], > 0.
    reference_temperature : float
        ``T_ref`` [K], > 0, at which the factor is one.
    """
    T = real_array("temperature", temperature)
    factor: Array = np.exp(-heat / GAS_CONSTANT * (1.0 / T - 1.0 / reference_temperature))
    return factor


def critical_moisture(isotherm: Isotherm, pressure: ArrayLike, temperature: ArrayLike) -> Array:
    """Return the moisture [-] at which the vapor pressure equals a local pressure, ``P_V = P_L``.

    Parameters
    ----------
    isotherm : Isotherm
        The melt's law.
    pressure : (...,) array_like
        Lowest local pressure ``P_L`` [Pa, absolute]; negative is tension.
    temperature : (...,) array_like
        Temperature of the melt [K].

    Returns
    -------
    (...,) array
        Below it no bubble can grow there. Zero where the melt is under tension: any trace of
        moisture suffices. Infinite where ``P_L`` is above the saturation pressure: no moisture
        that the melt can hold suffices.

    Raises
    ------
    ConfigError
        If a pressure is not finite, or the temperature is outside the law's range.
    """
    local = checked_range("pressure", pressure, (-np.inf, np.inf), "Pa")
    local, T = np.broadcast_arrays(local, real_array("temperature", temperature))
    isotherm.saturation_content(T)  # refuses temperatures that the law is not for, at any pressure
    saturated = saturation_pressure(T)
    inside = (local > 0.0) & (local <= saturated)
    found = np.where(local > 0.0, np.inf, 0.0)
    found[inside] = isotherm.moisture(local[inside], T[inside])
    return found


@dataclass(frozen=True)
class Henry:
    """Henry's law, ``P_V = w / H_V(T)``: moisture in proportion to its vapor pressure.

    The paper's Appendix I, ``P_V = c/H_V``, with the concentration as a mass fraction and
    ``H_V(T) = H_V(T_ref) exp(-dH/R (1/T - 1/T_ref))``.

    Parameters
    ----------
    constant : float
        ``H_V`` at the reference temperature [1/Pa], > 0: mass fraction for each pascal.
    reference_temperature : float
        ``T_ref`` [K], > 0.
    heat_of_solution : float
        ``dH`` from vapor to dissolved [J/mol], about -43e3 for water in polyetherimide.
    temperatures : (float, float)
        Where the law holds [K]; by default where water has a saturation pressure.

    Raises
    ------
    ConfigError
        If a value is out of range.
    """

    source: ClassVar[str] = "the paper, Appendix I (after Colton and Suh 1987)"

    constant: float
    reference_temperature: float
    heat_of_solution: float
    temperatures: tuple[float, float] = WATER_LIQUID

    def __post_init__(self) -> None:
        """Refuse what is no solubility."""
        checked_value("henry.constant", self.constant, "1/Pa", above=0.0)
        checked_value("henry.reference_temperature", self.reference_temperature, "K", above=0.0)
        checked_value("henry.heat_of_solution", self.heat_of_solution, "J/mol")
        checked_span("henry.temperatures", self.temperatures)

    def solubility(self, temperature: ArrayLike) -> Array:
        """Return ``H_V`` [1/Pa] at a temperature [K], shape (...,)."""
        T = checked_range("temperature", temperature, self.temperatures, "K", "use another card")
        return self.constant * van_t_hoff(self.heat_of_solution, T, self.reference_temperature)

    def saturation_content(self, temperature: ArrayLike) -> Array:
        """Return the moisture [-] in equilibrium with saturated vapor, shape (...,)."""
        return self.solubility(temperature) * saturation_pressure(temperature)

    def vapor_pressure(self, moisture: ArrayLike, temperature: ArrayLike) -> Array:
        """Return ``P_V`` [Pa, absolute].

        Parameters
        ----------
        moisture : (...,) array_like
            Mass fraction ``w`` [-], from zero to saturation.
        temperature : (...,) array_like
            Temperature [K].

        Raises
        ------
        ConfigError
            If the moisture is above saturation, or the temperature outside the law's range.
        """
        T = real_array("temperature", temperature)
        return checked_moisture(moisture, self.saturation_content(T), T) / self.solubility(T)

    def moisture(self, vapor_pressure: ArrayLike, temperature: ArrayLike) -> Array:
        """Return the moisture [-] that has a vapor pressure [Pa, absolute], shape (...,).

        Raises
        ------
        ConfigError
            If the pressure is above that of saturation, or the temperature outside the range.
        """
        solubility = self.solubility(temperature)
        return checked_vapor(vapor_pressure, saturation_pressure(temperature)) * solubility


@dataclass(frozen=True)
class ActivityLaw:
    """Moisture in proportion to the activity of water, ``w = w_s(T) P_V / P_sat(T)``.

    What a sorption isotherm over relative humidity gives, carried to the temperature of the melt:
    ``w_s(T) = w_s(T_ref) exp(-dH_m/R (1/T - 1/T_ref))``. With ``dH_m = 0`` the heat of solution is
    that of condensation and the isotherm over humidity is the same at every temperature.

    Parameters
    ----------
    content : float
        ``w_s`` at the reference temperature [-], between 0 and 1: moisture at 100 % humidity.
    reference_temperature : float
        ``T_ref`` [K], > 0.
    mixing_heat : float
        ``dH_m`` from liquid to dissolved [J/mol], zero unless the isotherm shifts.
    temperatures : (float, float)
        Where the law holds [K].

    Raises
    ------
    ConfigError
        If a value is out of range.
    """

    source: ClassVar[str] = "dilute limit of Flory and Huggins: activity in proportion to content"

    content: float
    reference_temperature: float
    mixing_heat: float = 0.0
    temperatures: tuple[float, float] = WATER_LIQUID

    def __post_init__(self) -> None:
        """Refuse what is no isotherm."""
        checked_value("moisture.content", self.content, above=0.0, most=1.0)
        checked_value("moisture.reference_temperature", self.reference_temperature, "K", above=0.0)
        checked_value("moisture.mixing_heat", self.mixing_heat, "J/mol")
        checked_span("moisture.temperatures", self.temperatures)

    def saturation_content(self, temperature: ArrayLike) -> Array:
        """Return ``w_s`` [-] at a temperature [K], shape (...,)."""
        T = checked_range("temperature", temperature, self.temperatures, "K", "use another card")
        return self.content * van_t_hoff(self.mixing_heat, T, self.reference_temperature)

    def vapor_pressure(self, moisture: ArrayLike, temperature: ArrayLike) -> Array:
        """Return ``P_V`` [Pa, absolute]; parameters and refusals as of `Henry.vapor_pressure`."""
        T = real_array("temperature", temperature)
        content = self.saturation_content(T)
        return checked_moisture(moisture, content, T) / content * saturation_pressure(T)

    def moisture(self, vapor_pressure: ArrayLike, temperature: ArrayLike) -> Array:
        """Return the moisture [-]; parameters and refusals as of `Henry.moisture`."""
        saturated = saturation_pressure(temperature)
        return (
            checked_vapor(vapor_pressure, saturated)
            / saturated
            * self.saturation_content(temperature)
        )
