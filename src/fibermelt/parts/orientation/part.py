"""Orientation tensors along the paths of a flow as a part of studies."""

from __future__ import annotations

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage

__all__ = ["PART"]

HERE = "fibermelt.parts.orientation"

PART = Part(
    "orientation",
    ("orientation",),
    f"{HERE}.summary:summarize_orientation",
    f"{HERE}.summary:orientation_in_words",
    meaning="orientation tensors along them",
    brings=(
        Stage(
            "orientation",
            4,
            ("fiber.aspect_ratio", "interaction"),
            ("streamlines",),
            f"{HERE}.stages:orientation_stage",
            estimates=f"{HERE}.stages:orientation_estimates",
        ),
    ),
)
