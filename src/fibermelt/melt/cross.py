"""Cross' law, and with the temperature by Williams, Landel and Ferry: what mould-filling uses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from fibermelt.errors import ConfigError
from fibermelt.melt.law import ViscosityLaw
from fibermelt.melt.temperature import WLF

__all__ = ["Cross", "CrossWLF"]

LEVEL = 1e-6
"""Rate times time constant below which the law is level: within 1e-6^(1-n) of its limit, 1.3e-4 of
it for n = 0.35."""


@dataclass(frozen=True)
class Cross(ViscosityLaw):
    """``eta = eta_inf + (eta_0 - eta_inf) / (1 + (eta_0 gamma_dot / tau*)^(1 - n))``.

    Parameters
    ----------
    viscosity : float
        ``eta_0`` [Pa s], at rest, > 0.
    index : float
        ``n`` [-], above 0 and at most 1.
    critical_stress : float
        ``tau*`` [Pa], > 0: the stress at which half of ``eta_0`` is left. ``eta_0 / tau*`` is the
        time constant of the law's other form.
    infinite_viscosity : float
        ``eta_inf`` [Pa s], at least 0, below ``eta_0``.

    Raises
    ------
    ConfigError
        If a constant is out of its range.

    References
    ----------
    Cross, J. Colloid Sci. 20 (1965) 417.
    """

    called: ClassVar[str] = "Cross' law"

    viscosity: float
    index: float
    critical_stress: float
    infinite_viscosity: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a melt that cannot be."""
        self._require("viscosity", "critical_stress")
        self._require_index(self.index)
        if self.index > 1.0:
            msg = f"melt.index = {self.index:g} must be at most 1: Cross' law thins"
            raise ConfigError(msg)
        self._require_below_rest(self.infinite_viscosity, self.viscosity)

    @property
    def time_constant(self) -> float:
        """Return ``eta_0 / tau*`` [s]."""
        return self.viscosity / self.critical_stress

    @property
    def lowest_rate(self) -> float:
        """Return the rate below which nothing changes any more [1/s]."""
        return LEVEL / self.time_constant

    @property
    def is_newtonian(self) -> bool:
        """Return whether the index is 1: half of ``eta_0`` at every rate."""
        return self.index == 1.0

    def of_square(self, s: Any) -> Any:
        """Return the law at ``s = gamma_dot^2``."""
        thinning = self.viscosity - self.infinite_viscosity
        begun = 1.0 + (self.time_constant**2 * s) ** (0.5 * (1.0 - self.index))
        return self.infinite_viscosity + thinning * begun**-1.0

    def scaled(self, viscosity: float = 1.0, time: float = 1.0) -> Cross:
        """Return the law ``viscosity * eta(time * gamma_dot)``."""
        return Cross(
            viscosity=viscosity * self.viscosity,
            index=self.index,
            critical_stress=self.critical_stress * viscosity / time,
            infinite_viscosity=viscosity * self.infinite_viscosity,
        )


@dataclass(frozen=True)
class CrossWLF(ViscosityLaw):
    """Cross' law whose viscosity at rest follows the temperature.

    ``eta_0(T) = D1 exp(-A1 (T - D2) / (A2 + T - D2))``; ``tau*`` stays, so that the curves of all
    temperatures are one curve shifted (time-temperature superposition).

    Parameters
    ----------
    index, critical_stress : float
        As in `Cross`.
    reference_viscosity, reference_temperature : float
        ``D1`` [Pa s] at ``D2`` [K].
    wlf_a1, wlf_a2 : float
        ``A1`` [-] and ``A2`` [K], > 0.
    temperature : float
        ``T`` [K], above ``D2 - A2``, where the viscosity becomes infinite.

    Raises
    ------
    ConfigError
        If a constant is out of its range, or the temperature too low.

    References
    ----------
    Williams, Landel and Ferry, J. Am. Chem. Soc. 77 (1955) 3701. D3, the shift of D2 with
    pressure, is taken as zero: an extruder's pressures are low.
    """

    called: ClassVar[str] = "Cross' law with WLF"

    index: float
    critical_stress: float
    reference_viscosity: float
    reference_temperature: float
    wlf_a1: float
    wlf_a2: float
    temperature: float

    def __post_init__(self) -> None:
        """Refuse a melt that cannot be."""
        self._require("reference_viscosity", "reference_temperature", "wlf_a1", "wlf_a2")
        self._require("temperature")
        _ = self.at_rest

    @cached_property
    def at_rest(self) -> Cross:
        """Return Cross' law at the temperature."""
        shift = WLF(self.wlf_a1, self.wlf_a2, self.reference_temperature)
        viscosity = self.reference_viscosity * shift.factor(self.temperature)
        return Cross(viscosity, self.index, self.critical_stress)

    @property
    def lowest_rate(self) -> float:
        """Return the rate below which nothing changes any more [1/s]."""
        return self.at_rest.lowest_rate

    @property
    def is_newtonian(self) -> bool:
        """Return whether the index is 1."""
        return self.index == 1.0

    def of_square(self, s: Any) -> Any:
        """Return the law at ``s = gamma_dot^2``."""
        return self.at_rest.of_square(s)

    def scaled(self, viscosity: float = 1.0, time: float = 1.0) -> Cross:
        """Return the law ``viscosity * eta(time * gamma_dot)``, at the temperature of this one."""
        return self.at_rest.scaled(viscosity, time)
