"""Water as the solvent of a polymer: the isotherm of Flory and Huggins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError
from fibermelt.voids.checks import (
    checked_moisture,
    checked_range,
    checked_span,
    checked_value,
    checked_vapor,
)
from fibermelt.voids.saturation import saturation_pressure
from fibermelt.voids.vapor import WATER_LIQUID

__all__ = ["FloryHuggins", "log_activity"]

Array = NDArray[np.float64]

HALVINGS = 60
"""Bisections of the logarithm of a fraction: an interval of a few tens ends below rounding."""

SPINODAL_ROUNDING = 1e-7
"""Distance from the pure solvent below which a spinodal is none: a double root, to rounding."""


def log_activity(fraction: ArrayLike, interaction: float, molar_volume_ratio: float = 0.0) -> Array:
    """Return ``ln a_1`` of a solvent in a polymer [-].

    ``ln a_1 = ln phi_1 + phi_2 (1 - V_1/V_2) + chi phi_2^2``, ``phi_2 = 1 - phi_1``: the terms in
    the braces of the paper's Eq. 43.

    Parameters
    ----------
    fraction : (...,) array_like
        Volume fraction of the solvent ``phi_1`` [-], above 0, at most 1.
    interaction : float
        Flory and Huggins' ``chi`` [-].
    molar_volume_ratio : float
        ``V_1/V_2`` of solvent and polymer [-], zero for long chains.

    References
    ----------
    Flory 1942, doi 10.1063/1.1723621; Huggins 1942, doi 10.1021/j150415a018.
    """
    solvent = checked_range("solvent fraction", fraction, (0.0, 1.0), positive=True)
    polymer = 1.0 - solvent
    activity: Array = (
        np.log(solvent) + polymer * (1.0 - molar_volume_ratio) + interaction * polymer**2
    )
    return activity


@dataclass(frozen=True)
class FloryHuggins:
    """The isotherm of a polymer solution, ``P_V = P_sat a_1(phi_1)``, dilute branch.

    Parameters
    ----------
    interaction : float
        ``chi`` [-], of any sign; about 4 for water in ABS.
    polymer_density, solvent_density : float
        Densities [kg/m3], > 0, that turn mass into volume fractions; water at 25 degC by default.
    molar_volume_ratio : float
        ``V_1/V_2`` [-], from 0 to 1.
    temperatures : (float, float)
        Where ``chi`` holds [K].

    Raises
    ------
    ConfigError
        If a value is out of range.
    """

    source: ClassVar[str] = "Flory 1942, doi 10.1063/1.1723621; the paper, Eq. 43"

    interaction: float
    polymer_density: float
    solvent_density: float = 997.0
    molar_volume_ratio: float = 0.0
    temperatures: tuple[float, float] = WATER_LIQUID

    def __post_init__(self) -> None:
        """Refuse what is no solution."""
        checked_value("solution.interaction", self.interaction)
        checked_value("solution.polymer_density", self.polymer_density, "kg/m3", above=0.0)
        checked_value("solution.solvent_density", self.solvent_density, "kg/m3", above=0.0)
        checked_value("solution.molar_volume_ratio", self.molar_volume_ratio, least=0.0, most=1.0)
        checked_span("solution.temperatures", self.temperatures)

    @classmethod
    def of_saturation(
        cls, content: float, polymer_density: float, solvent_density: float = 997.0
    ) -> FloryHuggins:
        """Return the solution that holds a given moisture at saturation, ``a_1 = 1``.

        ``chi = -(ln phi_1 + phi_2)/phi_2^2``, with ``V_1/V_2 = 0``.

        Parameters
        ----------
        content : float
            Mass fraction at saturation [-], between 0 and 1, both excluded.
        polymer_density, solvent_density : float
            Densities [kg/m3], > 0.

        Raises
        ------
        ConfigError
            If the content or a density is out of range.
        """
        checked_value("saturation content", content, above=0.0, most=0.999)
        fraction = float(cls(0.0, polymer_density, solvent_density).volume_fraction(content))
        interaction = -(math.log(fraction) + 1.0 - fraction) / (1.0 - fraction) ** 2
        return cls(interaction, polymer_density, solvent_density)

    def volume_fraction(self, moisture: ArrayLike) -> Array:
        """Return ``phi_1 = (w/rho_1)/(w/rho_1 + (1 - w)/rho_2)`` [-], shape (...,)."""
        w = real_array("moisture", moisture)
        volume = w / self.solvent_density
        return volume / (volume + (1.0 - w) / self.polymer_density)

    def mass_fraction(self, fraction: ArrayLike) -> Array:
        """Return the moisture ``w`` [-] of a volume fraction [-], shape (...,)."""
        solvent = real_array("fraction", fraction)
        mass = solvent * self.solvent_density
        return mass / (mass + (1.0 - solvent) * self.polymer_density)

    def saturation_content(self, temperature: ArrayLike) -> Array:
        """Return the moisture [-] at which ``a_1 = 1``, shape (...,)."""
        T = checked_range("temperature", temperature, self.temperatures, "K", "use another card")
        return np.full(T.shape, self.mass_fraction(self._dilute_end()))

    def vapor_pressure(self, moisture: ArrayLike, temperature: ArrayLike) -> Array:
        """Return ``P_V`` [Pa, absolute]; parameters and refusals as of `Henry.vapor_pressure`."""
        T = real_array("temperature", temperature)
        w = checked_moisture(moisture, self.saturation_content(T), T)
        fraction = self.volume_fraction(w)
        wet = fraction > 0.0
        activity = np.zeros(fraction.shape)
        activity[wet] = np.exp(
            log_activity(fraction[wet], self.interaction, self.molar_volume_ratio)
        )
        return activity * saturation_pressure(T)

    def moisture(self, vapor_pressure: ArrayLike, temperature: ArrayLike) -> Array:
        """Return the moisture [-] on the dilute branch; refusals as of `Henry.moisture`."""
        checked_range("temperature", temperature, self.temperatures, "K", "use another card")
        saturated = saturation_pressure(temperature)
        P = checked_vapor(vapor_pressure, saturated)
        wet = P > 0.0
        found = np.zeros(P.shape)
        activity = np.broadcast_to(np.log(np.where(wet, P, saturated) / saturated), P.shape)
        found[wet] = self.mass_fraction(self._fraction(np.minimum(activity[wet], 0.0)))
        return found

    def _dilute_end(self) -> float:
        """Return the volume fraction up to which the activity rises from zero to one.

        Beyond ``chi`` about 1/2 it has a maximum, the spinodal, at the smaller root of
        ``2 chi phi^2 - (1 - V_1/V_2 + 2 chi) phi + 1``; saturation lies before that.
        """
        chi, ratio = self.interaction, self.molar_volume_ratio
        middle = 1.0 - ratio + 2.0 * chi
        discriminant = middle**2 - 8.0 * chi
        if chi <= 0.0 or discriminant <= 0.0:
            return 1.0
        spinodal = 2.0 / (middle + math.sqrt(discriminant))
        if not 0.0 < spinodal < 1.0 - SPINODAL_ROUNDING:
            return 1.0
        if log_activity(spinodal, chi, ratio) < 0.0:
            msg = (
                f"solution.interaction = {chi:g} with molar_volume_ratio = {ratio:g}: the solution "
                "splits into two liquids below saturation, which this isotherm cannot follow; "
                "give a smaller ratio"
            )
            raise ConfigError(msg)
        return float(self._bisected(np.zeros(1), spinodal)[0])

    def _fraction(self, log_activities: Array) -> Array:
        return self._bisected(log_activities, self._dilute_end())

    def _bisected(self, log_activities: Array, end: float) -> Array:
        """Return volume fractions below ``end`` of given ``ln a_1 <= ln a_1(end)``, shape (n,)."""
        slack = 1.0 + abs(self.interaction)
        low = np.minimum(log_activities, math.log(end)) - slack
        high = np.full(low.shape, math.log(end))
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            below = (
                log_activity(np.exp(middle), self.interaction, self.molar_volume_ratio)
                < log_activities
            )
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        fraction: Array = np.exp(high)
        return fraction
