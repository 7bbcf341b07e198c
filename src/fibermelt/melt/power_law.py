"""The power law: what every melt is between two limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from fibermelt.errors import ConfigError
from fibermelt.melt.law import ViscosityLaw

__all__ = ["PowerLaw"]


@dataclass(frozen=True)
class PowerLaw(ViscosityLaw):
    """Ostwald and de Waele's law, ``eta = K gamma_dot^(n - 1)``, level below a lowest rate.

    Parameters
    ----------
    consistency : float
        ``K`` [Pa s^n], > 0: the stress in shear at 1/s.
    index : float
        ``n`` [-], above 0 and at most 2; below 1 the melt thins.
    lowest_rate : float
        Rate [1/s] below which the viscosity stays what it is there, > 0. A power law alone has no
        finite viscosity at rest; a melt does.

    Raises
    ------
    ConfigError
        If a constant is out of its range.

    References
    ----------
    Bird, Armstrong and Hassager, Dynamics of Polymeric Liquids 1 (1987), Eq. 4.1-10.
    """

    called: ClassVar[str] = "a power law"

    consistency: float
    index: float
    lowest_rate: float = 1e-2

    def __post_init__(self) -> None:
        """Refuse a melt that cannot be."""
        self._require("consistency", "lowest_rate")
        self._require_index(self.index)
        self._require_finite()

    def _require_finite(self) -> None:
        highest = self.consistency * self.lowest_rate ** (self.index - 1.0)
        if not 0 < highest < 1e300:
            msg = (
                f"melt.lowest_rate = {self.lowest_rate:g} 1/s gives a viscosity at rest of "
                f"{highest:g} Pa s: raise it"
            )
            raise ConfigError(msg)

    @property
    def is_newtonian(self) -> bool:
        """Return whether the index is 1."""
        return self.index == 1.0

    def of_square(self, s: Any) -> Any:
        """Return ``K s^((n - 1)/2)``."""
        return self.consistency * s ** (0.5 * (self.index - 1.0))

    def scaled(self, viscosity: float = 1.0, time: float = 1.0) -> PowerLaw:
        """Return the power law ``viscosity * eta(time * gamma_dot)``."""
        consistency = viscosity * self.consistency * time ** (self.index - 1.0)
        return PowerLaw(consistency, self.index, self.lowest_rate / time)
