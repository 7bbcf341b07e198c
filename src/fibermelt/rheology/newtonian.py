"""The melt whose stress is proportional to its rate of deformation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fibermelt.errors import ConfigError, refuse_no_number

__all__ = ["Newtonian"]


@dataclass(frozen=True)
class Newtonian:
    """A Newtonian melt, ``tau = 2 mu D`` (the paper's Eq. 4).

    Parameters
    ----------
    viscosity : float
        Dynamic viscosity ``mu`` [Pa s], > 0. The paper calls its 817 Pa s "kinematic"; the unit
        says what is meant: 13 wt% CF/ABS at 230 degC and 100 1/s (section 2).
    density : float
        Density [kg/m3], > 0. Creeping flow does not need it; void nucleation does.

    Raises
    ------
    ConfigError
        If a value is not positive and finite.
    """

    viscosity: float
    density: float = 1154.0

    def __post_init__(self) -> None:
        """Refuse a melt that cannot be."""
        for name in ("viscosity", "density"):
            value = getattr(self, name)
            refuse_no_number(f"melt.{name}", value)
            if not (math.isfinite(value) and value > 0):
                msg = f"melt.{name} = {value:g} must be positive and finite"
                raise ConfigError(msg)
