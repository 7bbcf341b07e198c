"""The planar answer for the equivalent slot, as a part of studies of a bead in space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, cast

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.parts.flow.config import FLOW_NUMERICS
from fibermelt.parts.melt.melt import LAW

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value

__all__ = ["PART"]

HERE = "fibermelt.parts.plane"


def _with_voids(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return the stage that knows the vapor's pressure, in a study with voids."""
    return ("voids",) if "voids" in cast("Sequence[str]", values["study.parts"]) else ()


PART = Part(
    "plane",
    ("plane",),
    f"{HERE}.summary:summarize_plane",
    f"{HERE}.summary:plane_in_words",
    meaning="the planar answer for the equivalent slot, beside a bead in space",
    refuse=f"{HERE}.stages:refuse_without_bead",
    brings=(
        Stage(
            "plane",
            1,
            ("flow", LAW, "fiber.melt", "streamlines.count", "streamlines.points", *FLOW_NUMERICS),
            ("streamlines", "cell", "motion"),
            f"{HERE}.stages:plane_stage",
            inputs_if=_with_voids,
        ),
    ),
)
