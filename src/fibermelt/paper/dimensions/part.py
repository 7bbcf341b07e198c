"""What the plane ellipse costs against a spheroid as a part of studies."""

from __future__ import annotations

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.parts.bead.part import from_content
from fibermelt.parts.flow.checks import OF_DEPOSITION
from fibermelt.parts.melt.checks import NEWTONIAN
from fibermelt.parts.melt.melt import LAW

__all__ = ["PART"]

HERE = "fibermelt.paper.dimensions"

PART = Part(
    "dimensions",
    ("dimensions",),
    f"{HERE}.summary:summarize_dimensions",
    f"{HERE}.summary:dimensions_in_words",
    meaning="what the plane ellipse costs against a spheroid",
    traits=frozenset({NEWTONIAN, OF_DEPOSITION}),
    brings=(
        Stage(
            "dimensions",
            2,
            (
                "sensitivity.aspect_ratios",
                LAW,
                "fiber.half_length",
                "fiber.aspect_ratio",
                "fiber.domain_size",
                "fiber.initial_angles",
                "numerics.cell_order",
                "numerics.angle_tolerance",
                "streamlines.features",
            ),
            ("streamlines", "cell"),
            f"{HERE}.stages:dimensions_stage",
            inputs_if=from_content,
        ),
    ),
)
