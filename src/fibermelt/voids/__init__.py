"""Voids: the vapor pressure of moisture in a melt, and where and whether a bubble starts.

Pressures are absolute here, except that `assess` takes a flow's, which are zero in the air. A
margin is positive where nothing starts.
"""

from __future__ import annotations

from fibermelt.voids.constants import ATMOSPHERE
from fibermelt.voids.criteria import MechanicalCriterion, ResidenceCondition
from fibermelt.voids.diffusion import Arrhenius, FreeVolume
from fibermelt.voids.exposure import GrowthExponent, growth_exponent
from fibermelt.voids.growth import BubbleMelt, Growth, Surroundings, Tip, grow, viscous_resistance
from fibermelt.voids.margin import Assessment, Onset, assess, assess_onset
from fibermelt.voids.melt import VolatileMelt
from fibermelt.voids.nucleation import (
    ClassicalNucleation,
    critical_radius,
    molecules_per_volume,
)
from fibermelt.voids.saturation import saturation_pressure
from fibermelt.voids.surface_tension import (
    LinearTension,
    Parachor,
    Wetting,
    girifalco_good,
    tension_at_density,
)
from fibermelt.voids.vapor import ActivityLaw, Henry, Isotherm, critical_moisture
from fibermelt.voids.wetting import vapor_angle, wetting_factor

__all__ = [
    "ATMOSPHERE",
    "ActivityLaw",
    "Arrhenius",
    "Assessment",
    "BubbleMelt",
    "ClassicalNucleation",
    "FreeVolume",
    "Growth",
    "GrowthExponent",
    "Henry",
    "Isotherm",
    "LinearTension",
    "MechanicalCriterion",
    "Onset",
    "Parachor",
    "ResidenceCondition",
    "Surroundings",
    "Tip",
    "VolatileMelt",
    "Wetting",
    "assess",
    "assess_onset",
    "critical_moisture",
    "critical_radius",
    "girifalco_good",
    "grow",
    "growth_exponent",
    "molecules_per_volume",
    "saturation_pressure",
    "tension_at_density",
    "vapor_angle",
    "viscous_resistance",
    "wetting_factor",
]
