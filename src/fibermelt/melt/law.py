"""What a law of viscosity is: one formula, from which arrays and finite elements take all.

A law gives its viscosity ``eta`` as a function of the squared rate of deformation
``s = gamma_dot^2 = 2 D:D`` by arithmetic alone. That one formula is evaluated on numbers, on
arrays, on the expressions of the finite elements, and, for the derivative that Newton's method
needs, on dual numbers of any of these.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, refuse_no_number

__all__ = ["Dual", "ViscosityLaw"]

Array = NDArray[np.float64]

HIGHEST_INDEX = 2.0
"""Largest power-law index: melts thin, and a suspension that thickens stays well below."""

SHARPNESS = 2
"""How sharply a law levels off below its lowest rate: ``s -> (s^2 + low^4)^(1/2)``, so that three
times above it the rate is off by 0.3 %, and there is no kink for Newton to stumble over."""


@dataclass(frozen=True)
class Dual:
    """A value and its derivative, carried through arithmetic (forward differentiation).

    Both may be numbers, arrays, or expressions of the finite elements. Powers have constant
    exponents.
    """

    value: Any
    slope: Any

    def __add__(self, other: Any) -> Dual:
        """Return the sum with another, or with a constant."""
        if isinstance(other, Dual):
            return Dual(self.value + other.value, self.slope + other.slope)
        return Dual(self.value + other, self.slope)

    __radd__ = __add__

    def __mul__(self, other: Any) -> Dual:
        """Return the product with another, or with a constant."""
        if isinstance(other, Dual):
            slope = self.slope * other.value + self.value * other.slope
            return Dual(self.value * other.value, slope)
        return Dual(self.value * other, self.slope * other)

    __rmul__ = __mul__

    def __pow__(self, exponent: float) -> Dual:
        """Return a power with a constant exponent."""
        lower = self.value ** (exponent - 1.0)
        return Dual(lower * self.value, self.slope * (exponent * lower))

    def __truediv__(self, other: Any) -> Dual:
        """Return the quotient by another, or by a constant."""
        return self.__mul__(other**-1.0)

    def __rtruediv__(self, other: Any) -> Dual:
        """Return a constant over this."""
        return self.__pow__(-1.0).__mul__(other)


class ViscosityLaw(ABC):
    """A generalised Newtonian melt, ``tau = 2 eta(gamma_dot) D``; each law is a frozen dataclass.

    A law says what it is `called`, its formula (`of_square`), the rate below which it is level
    (`lowest_rate`), and how it scales (`scaled`). All else follows.

    Raises
    ------
    ConfigError
        If a constant is no number, not finite, or out of its range.
    """

    called: ClassVar[str]
    """What it is called in a sentence."""

    @property
    @abstractmethod
    def lowest_rate(self) -> float:
        """Return the rate [1/s] below which the viscosity is constant; 0 where it is so anyway."""

    @abstractmethod
    def of_square(self, s: Any) -> Any:
        """Return the viscosity [Pa s] at ``s = gamma_dot^2`` [1/s2] > 0, by ``+ * / **`` alone."""

    @abstractmethod
    def scaled(self, viscosity: float = 1.0, time: float = 1.0) -> ViscosityLaw:
        """Return the law ``viscosity * eta(time * gamma_dot)``.

        By ``a, a`` it is that at another temperature (time-temperature superposition); by
        ``1/eta_0, V/W`` the law of a flow in units of ``eta_0``, width ``W`` and speed ``V``.
        """

    @property
    def is_newtonian(self) -> bool:
        """Return whether the viscosity is the same at every rate."""
        return False

    def constants(self) -> dict[str, float]:
        """Return the law's constants, in SI, by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]

    def level(self, s: Any) -> Any:
        """Return the squared rate with what lies below the lowest rate lifted to it."""
        low = self.lowest_rate
        return s if low == 0.0 else (s**SHARPNESS + low ** (2 * SHARPNESS)) ** (1 / SHARPNESS)

    def expression(self, s: Any) -> tuple[Any, Any]:
        """Return ``eta`` and ``d eta/ds`` at ``s = gamma_dot^2``: of numbers or expressions."""
        found = self.of_square(self.level(Dual(s, 1.0)))
        return (found.value, found.slope) if isinstance(found, Dual) else (found + 0.0 * s, 0.0 * s)

    def viscosity_at(self, rate: ArrayLike) -> Array:
        """Return ``eta`` [Pa s] at rates of deformation [1/s] of any shape, at least 0."""
        return np.asarray(self.of_square(self.level(_squared(rate))) + np.zeros(np.shape(rate)))

    def slope_at(self, rate: ArrayLike) -> Array:
        """Return ``d eta / d gamma_dot`` [Pa s2] at rates of deformation [1/s]."""
        s = _squared(rate)
        return np.asarray(2 * np.sqrt(s) * self.expression(s)[1])

    def index_at(self, rate: ArrayLike) -> Array:
        """Return the index of the power law that touches, ``1 + d ln eta / d ln gamma_dot``."""
        s = _squared(rate)
        viscosity, slope = self.expression(s)
        return np.asarray(1 + 2 * s * slope / viscosity)

    def stress_at(self, rate: ArrayLike) -> Array:
        """Return the shear stress ``eta gamma_dot`` [Pa] in simple shear at rates [1/s]."""
        return self.viscosity_at(rate) * np.asarray(rate, dtype=np.float64)

    def _require(self, *names: str, above: float = 0.0) -> None:
        """Refuse constants that are not finite, or not above a bound."""
        for name in names:
            value = getattr(self, name)
            refuse_no_number(f"melt.{name}", value)
            if not (math.isfinite(value) and value > above):
                what = "positive and finite" if above == 0 else f"finite and above {above:g}"
                msg = f"melt.{name} = {value:g} must be {what}"
                raise ConfigError(msg)

    def _require_below_rest(self, infinite_viscosity: float, viscosity: float) -> None:
        """Refuse a viscosity at infinite rate that is not below the one at rest."""
        if not 0.0 <= infinite_viscosity < viscosity:
            msg = (
                f"melt.infinite_viscosity = {infinite_viscosity:g} Pa s must be at least 0 "
                f"and below melt.viscosity = {viscosity:g} Pa s, that at rest"
            )
            raise ConfigError(msg)

    def _require_index(self, index: float) -> None:
        """Refuse an index of no melt."""
        self._require("index")
        if index > HIGHEST_INDEX:
            msg = (
                f"melt.index = {index:g} must lie above 0 and at most {HIGHEST_INDEX:g}: "
                "1 is Newtonian, printed melts have 0.2 to 0.8"
            )
            raise ConfigError(msg)


def _squared(rate: ArrayLike) -> Array:
    given = np.asarray(rate, dtype=np.float64)
    if not np.all(given >= 0):
        msg = f"rate = {float(np.nanmin(given)):g} 1/s: rates of deformation are at least 0"
        raise ConfigError(msg)
    return np.asarray(given * given)
