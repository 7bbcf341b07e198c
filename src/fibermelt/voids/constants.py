"""Constants of nature and of water, in SI."""

from __future__ import annotations

__all__ = [
    "ATMOSPHERE",
    "AVOGADRO",
    "BOLTZMANN",
    "GAS_CONSTANT",
    "ICE_POINT",
    "WATER_CRITICAL",
    "WATER_MOLAR_MASS",
    "WATER_MOLECULE",
    "WATER_TRIPLE",
]

BOLTZMANN = 1.380649e-23
"""Boltzmann's constant [J/K], exact (SI 2019)."""

AVOGADRO = 6.02214076e23
"""Avogadro's constant [1/mol], exact (SI 2019)."""

GAS_CONSTANT = BOLTZMANN * AVOGADRO
"""Molar gas constant [J/(mol K)], exact."""

ATMOSPHERE = 101325.0
"""Standard atmosphere [Pa]: what a flow's zero of pressure is, absolute."""

WATER_MOLAR_MASS = 0.018015268
"""Molar mass of water [kg/mol] (IAPWS R6-95)."""

WATER_MOLECULE = WATER_MOLAR_MASS / AVOGADRO
"""Mass of a molecule of water [kg]."""

ICE_POINT = 273.15
"""Zero of the Celsius scale [K], exact."""

WATER_TRIPLE = 273.16
"""Triple point of water [K]: below, ice and not water is in equilibrium with the vapor."""

WATER_CRITICAL = 647.096
"""Critical temperature of water [K] (IAPWS): above, there is no saturation pressure."""
