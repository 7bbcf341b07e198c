"""Where voids can start as a part of studies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, cast

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage, always
from fibermelt.parts.melt.melt import CARD, LAW
from fibermelt.parts.voids.config import Voids

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value

__all__ = ["PART", "with_orientation"]

HERE = "fibermelt.parts.voids"

NUCLEI = (
    "fiber.half_length",
    "fiber.aspect_ratio",
    "fiber.thickness_ratio",
    "fiber.model",
    "interaction.volume_fraction",
)
"""What nuclei at the tips of fibers follow from, besides ``[voids]``."""


def with_orientation(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return the stage that voids are fed besides, in a study with orientation tensors."""
    return ("orientation",) if "orientation" in cast("Sequence[str]", values["study.parts"]) else ()


PART = Part(
    "voids",
    ("voids",),
    f"{HERE}.summary:summarize_voids",
    f"{HERE}.summary:voids_in_words",
    meaning="where in the bead voids can start",
    tables={"voids": Voids},
    refuse=f"{HERE}.melt:refuse_moisture",
    brings=(
        Stage(
            "voids",
            7,
            ("voids", CARD, "melt.temperature", "melt.density", "fiber.melt", LAW, *NUCLEI),
            ("streamlines", "cell", "motion"),
            f"{HERE}.stages:voids_stage",
            inputs_if=with_orientation,
            light_if=always,
        ),
    ),
)
