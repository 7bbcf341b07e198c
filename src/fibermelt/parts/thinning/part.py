"""What thinning does as a part of studies."""

from __future__ import annotations

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.parts.bead.part import from_content
from fibermelt.parts.flow.checks import OF_DEPOSITION
from fibermelt.parts.flow.config import FLOW_NUMERICS
from fibermelt.parts.melt.checks import NEWTONIAN
from fibermelt.parts.melt.melt import LAW
from fibermelt.parts.thinning.config import Thinning

__all__ = ["PART"]

HERE = "fibermelt.parts.thinning"

PART = Part(
    "thinning",
    ("thinning",),
    f"{HERE}.summary:summarize_thinning",
    f"{HERE}.summary:thinning_in_words",
    meaning="what melts that thin do to bead and fibers",
    tables={"thinning": Thinning},
    traits=frozenset({NEWTONIAN, OF_DEPOSITION}),
    brings=(
        Stage(
            "thinning",
            3,
            (
                "thinning",
                "flow",
                LAW,
                "streamlines.count",
                "streamlines.points",
                "fiber.half_length",
                "fiber.aspect_ratio",
                "fiber.thickness_ratio",
                "fiber.domain_size",
                "fiber.pressure_reference",
                "fiber.initial_angles",
                "numerics.thinning_order",
                "numerics.cell_order",
                "numerics.angle_tolerance",
                *FLOW_NUMERICS,
            ),
            ("flow", "streamlines", "cell"),
            f"{HERE}.stages:effect_stage",
            inputs_if=from_content,
        ),
    ),
)
