"""Carreau and Yasuda's law: level at rest, a power law beyond, level again at the end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from fibermelt.errors import ConfigError
from fibermelt.melt.law import ViscosityLaw

__all__ = ["CarreauYasuda"]

LEVEL = 1e-6
"""Rate times time constant below which the law is level: with a transition of 0.1 at the least, it
is within 3 % of its limit there, with Carreau's 2 within 1e-12."""


@dataclass(frozen=True)
class CarreauYasuda(ViscosityLaw):
    """``eta = eta_inf + (eta_0 - eta_inf) (1 + (lambda gamma_dot)^a)^((n - 1)/a)``.

    Parameters
    ----------
    viscosity : float
        ``eta_0`` [Pa s], at rest, > 0.
    index : float
        ``n`` [-], above 0 and at most 2.
    time_constant : float
        ``lambda`` [s], > 0: its inverse is the rate at which the melt begins to thin.
    infinite_viscosity : float
        ``eta_inf`` [Pa s], at least 0, below ``eta_0``.
    transition : float
        Yasuda's ``a`` [-], 0.1 to 10: how sharply it begins; 2 is Carreau's law.

    Raises
    ------
    ConfigError
        If a constant is out of its range.

    References
    ----------
    Carreau, Trans. Soc. Rheol. 16 (1972) 99; Yasuda, Armstrong and Cohen, Rheol. Acta 20 (1981)
    163.
    """

    called: ClassVar[str] = "the law of Carreau and Yasuda"

    viscosity: float
    index: float
    time_constant: float
    infinite_viscosity: float = 0.0
    transition: float = 2.0

    def __post_init__(self) -> None:
        """Refuse a melt that cannot be."""
        self._require("viscosity", "time_constant", "transition")
        self._require_index(self.index)
        self._require_below_rest(self.infinite_viscosity, self.viscosity)
        if not 0.1 <= self.transition <= 10.0:
            msg = f"melt.transition = {self.transition:g} must lie in 0.1 to 10; 2 is Carreau's law"
            raise ConfigError(msg)

    @property
    def lowest_rate(self) -> float:
        """Return the rate below which nothing changes any more [1/s]."""
        return LEVEL / self.time_constant

    @property
    def is_newtonian(self) -> bool:
        """Return whether the index is 1."""
        return self.index == 1.0

    def of_square(self, s: Any) -> Any:
        """Return the law at ``s = gamma_dot^2``."""
        a, thinning = self.transition, self.viscosity - self.infinite_viscosity
        begun = 1.0 + (self.time_constant**2 * s) ** (0.5 * a)
        return self.infinite_viscosity + thinning * begun ** ((self.index - 1.0) / a)

    def scaled(self, viscosity: float = 1.0, time: float = 1.0) -> CarreauYasuda:
        """Return the law ``viscosity * eta(time * gamma_dot)``."""
        return CarreauYasuda(
            viscosity=viscosity * self.viscosity,
            index=self.index,
            time_constant=time * self.time_constant,
            infinite_viscosity=viscosity * self.infinite_viscosity,
            transition=self.transition,
        )
