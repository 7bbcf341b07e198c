"""A melt as a study has it: one law of viscosity, at one temperature, and what is known of it."""

from __future__ import annotations

from dataclasses import dataclass

from fibermelt.melt.law import ViscosityLaw

__all__ = ["Melt"]


@dataclass(frozen=True)
class Melt:
    """A melt at its temperature.

    Parameters
    ----------
    name : str
        What it is called.
    law : ViscosityLaw
        Its law of viscosity at its temperature.
    temperature : float
        Of the melt [K].
    measured_at : float or None
        Temperature [K] at which the law was measured and from which nothing tells how to come to
        the melt's; None where the law knows the temperature, or was measured at it.
    rates : (float, float) or None
        Rates of deformation [1/s] that were measured; None where nobody says.
    temperatures : (float, float)
        Temperatures [K] at which it may be used.
    density : float
        Of the melt with its fibers [kg/m3].
    sources : tuple of str
        Where the law comes from.
    """

    name: str
    law: ViscosityLaw
    temperature: float
    measured_at: float | None
    rates: tuple[float, float] | None
    temperatures: tuple[float, float]
    density: float
    sources: tuple[str, ...]
