"""What this installation is checked against as a part of studies."""

from __future__ import annotations

from typing import Literal

from fibermelt.engine.parameters import Section, setting
from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.parts.melt.checks import WITHOUT_VISCOSITY
from fibermelt.verify.ladder import LADDER_VERSION

__all__ = ["PART"]

HERE = "fibermelt.parts.verification"


class Extent(Section):
    """How far the ladder is climbed."""

    ladder: Literal["brief", "quick", "full"] = setting(
        "brief",
        'How much "verification" checks: in about 5 s, in 10 s, or as fibermelt verify does.',
    )


PART = Part(
    "verification",
    ("verification",),
    f"{HERE}.summary:summarize_verification",
    f"{HERE}.summary:verification_in_words",
    meaning="what this installation is checked against",
    tables={"study": Extent},
    traits=frozenset({WITHOUT_VISCOSITY}),
    brings=(
        Stage(
            "verification",
            LADDER_VERSION,
            ("study.ladder",),
            (),
            f"{HERE}.stages:verification_stage",
        ),
    ),
)
