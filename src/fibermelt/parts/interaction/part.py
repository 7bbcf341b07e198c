"""Fiber content as a part of studies: from it to the interaction and to the size of the cell."""

from __future__ import annotations

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.parts.interaction.config import Interaction, interacting
from fibermelt.parts.melt.checks import WITHOUT_VISCOSITY

__all__ = ["PART"]

HERE = "fibermelt.parts.interaction"

PART = Part(
    "interaction",
    ("content", "interaction"),
    f"{HERE}.summary:summarize_interaction",
    f"{HERE}.summary:interaction_in_words",
    meaning="from fiber content to the size of the cell",
    tables={"interaction": Interaction},
    renew={"interaction": interacting},
    traits=frozenset({WITHOUT_VISCOSITY}),
    brings=(
        Stage(
            "stall",
            2,
            ("fiber.aspect_ratio",),
            (),
            f"{HERE}.stages:stall_stage",
            estimates=f"{HERE}.stages:stall_estimates",
        ),
        Stage(
            "content",
            1,
            (
                "fiber.aspect_ratio",
                "interaction.volume_fraction",
                "interaction.law",
                "interaction.coefficient",
                "interaction.closure",
                "interaction.convention",
            ),
            ("stall",),
            f"{HERE}.stages:content_stage",
        ),
        Stage(
            "interaction",
            1,
            ("fiber.aspect_ratio", "interaction.closure"),
            ("stall",),
            f"{HERE}.stages:interaction_stage",
        ),
    ),
)
