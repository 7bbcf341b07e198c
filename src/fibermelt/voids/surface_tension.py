"""Surface tension of a melt against temperature, and how it wets a fiber.

Two angles are at a solid where a bubble sits. Young's contact angle is measured through the melt:
zero where the melt spreads. The angle of the barrier (the paper's Eq. 37) is measured through the
vapor: 180 degrees where the solid does not help. They add up to 180 degrees; the paper's Eq. 47
gives the first and its Eq. 37 needs the second.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError
from fibermelt.voids.checks import checked_range, checked_span, checked_value

__all__ = ["SUGDEN", "LinearTension", "Parachor", "Wetting", "girifalco_good", "tension_at_density"]

Array = NDArray[np.float64]

CGS_PARACHOR = 1e-6 * 1e-3**0.25
"""One parachor unit, cm3/mol (dyn/cm)^(1/4), in m3/mol (N/m)^(1/4)."""

SUGDEN: Mapping[str, float] = {
    "C": 4.8,
    "H": 17.1,
    "O": 20.0,
    "N": 12.5,
    "ester O2": 60.0,
    "double bond": 23.2,
    "triple bond": 46.4,
    "five-membered ring": 8.5,
    "six-membered ring": 6.1,
}
"""Sugden's contributions to the parachor [cm3/mol (dyn/cm)^(1/4)], as tabulated by Askadskii,
Computational Materials Science of Polymers, table 45; both oxygens of an ester count as one."""


@dataclass(frozen=True)
class LinearTension:
    """A surface tension that falls linearly, ``eta = eta_ref + k (T - T_ref)``.

    Parameters
    ----------
    tension : float
        ``eta_ref`` [N/m], > 0.
    reference_temperature : float
        ``T_ref`` [K], > 0.
    slope : float
        ``k`` [N/(m K)], at most 0; polymers about -0.06e-3 to -0.08e-3.
    temperatures : (float, float)
        Where the law is used [K]; the tension must be positive throughout.

    Raises
    ------
    ConfigError
        If a value is out of range, or the tension vanishes within the range.
    """

    source: ClassVar[str] = "Wu, Polymer Interface and Adhesion, 1982: linear for polymer melts"

    tension: float
    reference_temperature: float
    slope: float
    temperatures: tuple[float, float]

    def __post_init__(self) -> None:
        """Refuse what is no surface tension."""
        checked_value("surface.tension", self.tension, "N/m", above=0.0)
        checked_value("surface.reference_temperature", self.reference_temperature, "K", above=0.0)
        checked_value("surface.slope", self.slope, "N/(m K)", most=0.0)
        checked_span("surface.temperatures", self.temperatures)
        lowest = self.tension + self.slope * (self.temperatures[1] - self.reference_temperature)
        remedy = "give a flatter surface.slope or a narrower range of temperatures"
        checked_value("surface tension at the hot end", lowest, "N/m", above=0.0, remedy=remedy)

    def at(self, temperature: ArrayLike) -> Array:
        """Return ``eta`` [N/m] at a temperature [K], shape (...,).

        Raises
        ------
        ConfigError
            If a temperature is outside the law's range.
        """
        T = checked_range("temperature", temperature, self.temperatures, "K", "use another card")
        return self.tension + self.slope * (T - self.reference_temperature)


@dataclass(frozen=True)
class Parachor:
    """Sugden's relation, ``eta = (P_a/V)^4`` (the paper's Eq. 45).

    Parameters
    ----------
    value : float
        ``P_a`` [m3/mol (N/m)^(1/4)], > 0, of a molecule or of a polymer's repeat unit.

    Raises
    ------
    ConfigError
        If it is not positive.

    References
    ----------
    Sugden 1924, doi 10.1039/CT9242501177.
    """

    source: ClassVar[str] = "Sugden 1924, doi 10.1039/CT9242501177; the paper, Eq. 45"

    value: float

    def __post_init__(self) -> None:
        """Refuse what is no parachor."""
        checked_value("parachor", self.value, "m3/mol (N/m)^(1/4)", above=0.0)

    @classmethod
    def of_structure(cls, structure: Mapping[str, float]) -> Parachor:
        """Return the sum of Sugden's contributions.

        Parameters
        ----------
        structure : mapping
            How often each contribution of `SUGDEN` occurs, such as styrene's ``{"C": 8, "H": 8,
            "double bond": 3, "six-membered ring": 1}``.

        Raises
        ------
        ConfigError
            If a contribution is not known.
        """
        unknown = sorted(set(structure) - set(SUGDEN))
        if unknown:
            msg = f"parachor: no contribution is called {unknown[0]!r} (known: {', '.join(SUGDEN)})"
            raise ConfigError(msg)
        return cls(CGS_PARACHOR * sum(SUGDEN[name] * count for name, count in structure.items()))

    def tension(self, molar_volume: ArrayLike) -> Array:
        """Return ``eta`` [N/m] at a molar volume [m3/mol] of the same unit, > 0, shape (...,)."""
        V = checked_range("molar volume", molar_volume, (0.0, np.inf), "m3/mol", positive=True)
        return (self.value / V) ** 4


def tension_at_density(tension: float, density: ArrayLike, reference_density: float) -> Array:
    """Return ``eta(T_2) = eta(T_1) [rho(T_2)/rho(T_1)]^4`` [N/m] (the paper's Eq. 46).

    Parameters
    ----------
    tension : float
        ``eta(T_1)`` [N/m], > 0.
    density : (...,) array_like
        ``rho(T_2)`` [kg/m3], > 0.
    reference_density : float
        ``rho(T_1)`` [kg/m3], > 0, of the same liquid.

    Raises
    ------
    ConfigError
        If a value is not positive.
    """
    checked_value("tension", tension, "N/m", above=0.0)
    checked_value("reference density", reference_density, "kg/m3", above=0.0)
    rho = checked_range("density", density, (0.0, np.inf), "kg/m3", positive=True)
    return tension * (rho / reference_density) ** 4


@dataclass(frozen=True)
class Wetting:
    """How a melt wets a solid: the cosine that Young's equation asks for.

    Parameters
    ----------
    cosine : float
        ``cos(phi)`` [-] of the angle through the melt, at least -1. Above 1 the melt spreads.

    Raises
    ------
    ConfigError
        If it is below -1 or not finite.
    """

    cosine: float

    def __post_init__(self) -> None:
        """Refuse what no balance of tensions gives."""
        checked_value("cosine of the contact angle", self.cosine, least=-1.0)

    @property
    def spreads(self) -> bool:
        """Return whether the melt covers the solid by itself: there is no angle but zero."""
        return self.cosine >= 1.0

    @property
    def contact_angle(self) -> float:
        """Return Young's angle through the melt [rad], zero where the melt spreads."""
        return 0.0 if self.spreads else math.acos(self.cosine)

    @property
    def vapor_angle(self) -> float:
        """Return the angle through the vapor [rad], the paper's of Eq. 37."""
        return math.pi - self.contact_angle


def girifalco_good(
    solid_tension: float,
    liquid_tension: float,
    solid_volume: float = 1.0,
    liquid_volume: float = 1.0,
) -> Wetting:
    """Return how a liquid wets a solid, from their tensions (the paper's Eq. 47, corrected).

    ``cos(phi) = 2 Phi sqrt(eta_s/eta_l) - 1``,
    ``Phi = 4 (V_s V_l)^(1/3) / (V_s^(1/3) + V_l^(1/3))^2``, which equal volumes make one.

    Parameters
    ----------
    solid_tension, liquid_tension : float
        ``eta_s``, ``eta_l`` [N/m], at least 0 and > 0.
    solid_volume, liquid_volume : float
        Molar or molecular volumes [m3/mol] of the interacting units, > 0; their ratio matters.

    Raises
    ------
    ConfigError
        If a value is out of range.

    References
    ----------
    Girifalco and Good, J. Phys. Chem. 61 (1957) 904.
    """
    checked_value("solid tension", solid_tension, "N/m", least=0.0)
    checked_value("liquid tension", liquid_tension, "N/m", above=0.0)
    checked_value("solid volume", solid_volume, "m3/mol", above=0.0)
    checked_value("liquid volume", liquid_volume, "m3/mol", above=0.0)
    edges = solid_volume ** (1 / 3), liquid_volume ** (1 / 3)
    interaction = 4.0 * edges[0] * edges[1] / (edges[0] + edges[1]) ** 2
    return Wetting(2.0 * interaction * math.sqrt(solid_tension / liquid_tension) - 1.0)
