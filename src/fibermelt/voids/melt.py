"""A melt with a volatile in it: the laws of one material together, and what it lacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError
from fibermelt.voids.checks import checked_range, checked_span, checked_value
from fibermelt.voids.criteria import ResidenceCondition
from fibermelt.voids.diffusion import Arrhenius
from fibermelt.voids.nucleation import (
    ClassicalNucleation,
    molecules_per_volume,
)
from fibermelt.voids.surface_tension import LinearTension
from fibermelt.voids.vapor import Isotherm, critical_moisture
from fibermelt.voids.wetting import wetting_factor

__all__ = ["RESULTS", "VolatileMelt"]

Array = NDArray[np.float64]
Law = TypeVar("Law")

RESULTS: Mapping[str, str] = {
    "isotherm": "vapor pressure, margin, critical moisture, and whatever follows from them",
    "diffusion": "critical time, no residence condition, no growth of bubbles",
    "surface": "critical radius, nucleation rate and the wetting that would start it, no growth of "
    "bubbles",
    "contact_angle": "heterogeneous rate: the rate is the homogeneous one, a lower bound",
}
"""What a melt without a law cannot give."""


LARGEST_ANGLE = 3.14
"""Largest contact angle [rad], 0.09 degrees below pi: at pi the wetting factor is zero, and with it
the barrier."""


@dataclass(frozen=True)
class VolatileMelt:
    """A melt with moisture in it.

    Parameters
    ----------
    name : str
        What it is called, for messages.
    density : float
        Of the melt with its fibers [kg/m3], > 0.
    temperatures : (float, float)
        Temperatures at which it is printed, and its laws are used [K].
    isotherm : Isotherm or None
        Moisture against vapor pressure.
    diffusion : Arrhenius or None
        Of the moisture in the melt.
    surface : LinearTension or None
        Of the melt against its vapor.
    contact_angle : float or None
        Young's angle of the melt on its fibers, through the melt [rad], 0 to 3.14.
    polymer_fraction : float
        Mass fraction of the melt that is polymer and holds the moisture [-], above 0, at most 1:
        moisture is counted over the polymer's own mass, fibers hold none.
    missing : mapping
        Which keys of its card are empty, by the name of the law that needs them.

    Raises
    ------
    ConfigError
        If a value is out of range.
    """

    name: str
    density: float
    temperatures: tuple[float, float]
    isotherm: Isotherm | None = None
    diffusion: Arrhenius | None = None
    surface: LinearTension | None = None
    contact_angle: float | None = None
    polymer_fraction: float = 1.0
    missing: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what is no melt."""
        checked_value("melt.density", self.density, "kg/m3", above=0.0)
        checked_value("melt.polymer_fraction", self.polymer_fraction, above=0.0, most=1.0)
        checked_span("melt.temperatures", self.temperatures)
        if self.contact_angle is not None:
            checked_value("contact_angle", self.contact_angle, "rad", least=0.0, most=LARGEST_ANGLE)

    @property
    def gaps(self) -> dict[str, str]:
        """Return one sentence for each law that is missing: which keys, and what it costs."""
        return {law: self._gap(law) for law in RESULTS if getattr(self, law) is None}

    def vapor_pressure(self, moisture: ArrayLike, temperature: ArrayLike) -> Array:
        """Return ``P_V`` [Pa, absolute] of moistures [-] at temperatures [K], shape (...,).

        Raises
        ------
        ConfigError
            If the moisture is above saturation, the temperature outside the card's range, or the
            card has no isotherm.
        """
        law = self._required("isotherm", self.isotherm)
        return law.vapor_pressure(moisture, self._heated(temperature))

    def saturation_content(self, temperature: ArrayLike) -> Array:
        """Return the most moisture [-] that the melt can hold, shape (...,)."""
        law = self._required("isotherm", self.isotherm)
        return law.saturation_content(self._heated(temperature))

    def critical_moisture(self, pressure: ArrayLike, temperature: ArrayLike) -> Array:
        """Return the moisture [-] at which voids can start, as `critical_moisture` of the vapor.

        Parameters
        ----------
        pressure : (...,) array_like
            Lowest local pressure [Pa, absolute].
        temperature : (...,) array_like
            Temperature [K].
        """
        law = self._required("isotherm", self.isotherm)
        return critical_moisture(law, pressure, self._heated(temperature))

    def tension(self, temperature: float) -> float:
        """Return the surface tension [N/m] at a temperature [K]."""
        return float(self._required("surface", self.surface).at(self._heated(temperature)))

    def diffusivity(self, temperature: float) -> float:
        """Return the diffusivity of moisture [m2/s] at a temperature [K]."""
        law = self._required("diffusion", self.diffusion)
        return float(law.diffusivity(self._heated(temperature)))

    def nucleation(self, moisture: float, temperature: float) -> ClassicalNucleation:
        """Return the classical rate of the melt at a moisture [-] and a temperature [K].

        On its fibers where the contact angle is known, without them otherwise.

        Raises
        ------
        ConfigError
            If the melt is dry, a value is out of range, or the card has no surface tension.
        """
        angle = self.contact_angle
        held = self.density * self.polymer_fraction
        return ClassicalNucleation(
            tension=self.tension(temperature),
            temperature=temperature,
            molecules=float(molecules_per_volume(moisture, held)),
            wetting_factor=1.0 if angle is None else float(wetting_factor(np.pi - angle)),
        )

    def residence(self, temperature: float) -> ResidenceCondition:
        """Return the residence condition of the melt at a temperature [K]."""
        return ResidenceCondition(self.diffusivity(temperature))

    def _heated(self, temperature: ArrayLike) -> Array:
        remedy = f"that is the range of the material {self.name}: use another card"
        return checked_range("temperature", temperature, self.temperatures, "K", remedy)

    def _required(self, name: str, law: Law | None) -> Law:
        if law is None:
            msg = f"material {self.name}: {self._gap(name)}"
            raise ConfigError(msg)
        return law

    def _gap(self, law: str) -> str:
        keys = ", ".join(self.missing.get(law, (law,)))
        return f"{keys}: no value in the card, so no {RESULTS[law]}; give it in a card of your own"
