"""The melt whose stress is proportional to its rate of deformation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from fibermelt.melt.law import ViscosityLaw

__all__ = ["Newtonian"]


@dataclass(frozen=True)
class Newtonian(ViscosityLaw):
    """A Newtonian melt, ``tau = 2 mu D`` (the paper's Eq. 4).

    Parameters
    ----------
    viscosity : float
        Dynamic viscosity ``mu`` [Pa s], > 0. The paper calls its 817 Pa s "kinematic"; the unit
        says what is meant: 13 wt% CF/ABS at 230 degC and 100 1/s (section 2).

    Raises
    ------
    ConfigError
        If it is not positive and finite.
    """

    called: ClassVar[str] = "a Newtonian melt"

    viscosity: float

    def __post_init__(self) -> None:
        """Refuse a melt that cannot be."""
        self._require("viscosity")

    @property
    def lowest_rate(self) -> float:
        """Return 0: the viscosity is constant anyway."""
        return 0.0

    @property
    def is_newtonian(self) -> bool:
        """Return True."""
        return True

    def of_square(self, s: Any) -> Any:
        """Return ``mu``."""
        return self.viscosity

    def scaled(self, viscosity: float = 1.0, time: float = 1.0) -> Newtonian:
        """Return the melt ``viscosity`` times as viscous."""
        return Newtonian(viscosity * self.viscosity)
