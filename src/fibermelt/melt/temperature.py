"""How a viscosity follows the temperature: one factor, by which a whole law is shifted.

A melt is thermorheologically simple: ``eta(gamma_dot, T) = a_T eta(a_T gamma_dot, T_0)``, so that
`ViscosityLaw.scaled` by ``a_T`` in viscosity and time is the law at another temperature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from fibermelt.errors import ConfigError

__all__ = ["WLF", "ArrheniusShift", "Shift"]


class Shift(Protocol):
    """A rule for ``a_T``."""

    reference_temperature: float

    def factor(self, temperature: float) -> float:
        """Return ``a_T`` [-]: 1 at the reference temperature, less above."""


@dataclass(frozen=True)
class ArrheniusShift:
    """``a_T = exp(E/R (1/T - 1/T_0))``: far above the glass transition, as a rule by 100 K.

    Parameters
    ----------
    activation_temperature : float
        ``E/R`` [K], at least 0.
    reference_temperature : float
        ``T_0`` [K], > 0.
    """

    activation_temperature: float
    reference_temperature: float

    def factor(self, temperature: float) -> float:
        """Return ``a_T`` [-] at a temperature [K]."""
        inverse = 1.0 / temperature - 1.0 / self.reference_temperature
        return math.exp(self.activation_temperature * inverse)


@dataclass(frozen=True)
class WLF:
    """``a_T = exp(-A1 (T - T_0) / (A2 + T - T_0))``, from the glass transition to 100 K above.

    Parameters
    ----------
    a1, a2 : float
        ``A1`` [-], ``A2`` [K], for the natural logarithm.
    reference_temperature : float
        ``T_0`` [K].

    References
    ----------
    Williams, Landel and Ferry, J. Am. Chem. Soc. 77 (1955) 3701.
    """

    a1: float
    a2: float
    reference_temperature: float

    def factor(self, temperature: float) -> float:
        """Return ``a_T`` [-] at a temperature [K].

        Raises
        ------
        ConfigError
            If it is so low that the law has no viscosity there.
        """
        above = temperature - self.reference_temperature
        if not self.a2 + above > 0:
            msg = (
                f"melt.temperature = {temperature:g} K must lie above "
                f"{self.reference_temperature - self.a2:g} K, where the viscosity of the WLF law "
                "becomes infinite"
            )
            raise ConfigError(msg)
        return math.exp(-self.a1 * above / (self.a2 + above))
