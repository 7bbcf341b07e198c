"""One fiber in simple shear, the paper's section 2.3, as a part of studies."""

from __future__ import annotations

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.paper.config import Sensitivity
from fibermelt.parts.melt.checks import NEWTONIAN
from fibermelt.parts.melt.melt import LAW

__all__ = ["PART"]

HERE = "fibermelt.paper.orbits"

PART = Part(
    "orbits",
    ("orbits",),
    f"{HERE}.summary:summarize_orbits",
    f"{HERE}.summary:orbits_in_words",
    meaning="one fiber in simple shear",
    tables={"sensitivity": Sensitivity},
    traits=frozenset({NEWTONIAN}),
    brings=(
        Stage(
            "orbits",
            2,
            (
                "sensitivity.aspect_ratios",
                "sensitivity.shear_rates",
                "sensitivity.viscosities",
                "sensitivity.shear_rate",
                "sensitivity.domain_size",
                "fiber.half_length",
                "fiber.aspect_ratio",
                LAW,
                "numerics.cell_order",
            ),
            (),
            f"{HERE}.stages:orbits_stage",
        ),
    ),
)
