"""Melts: laws of viscosity, their temperature, and the flow in a slit that follows from them."""

from fibermelt.melt.carreau import CarreauYasuda
from fibermelt.melt.cross import Cross, CrossWLF
from fibermelt.melt.law import ViscosityLaw
from fibermelt.melt.newtonian import Newtonian
from fibermelt.melt.power_law import PowerLaw

__all__ = ["LAWS", "CarreauYasuda", "Cross", "CrossWLF", "Newtonian", "PowerLaw", "ViscosityLaw"]

LAWS: dict[str, type[ViscosityLaw]] = {
    "newtonian": Newtonian,
    "power-law": PowerLaw,
    "carreau": CarreauYasuda,
    "cross": Cross,
    "cross-wlf": CrossWLF,
}
"""The laws by the names that a study has for them."""
