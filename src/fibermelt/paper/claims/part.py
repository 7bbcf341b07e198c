"""Whether the paper's claims hold as a part of studies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage, always
from fibermelt.parts.flow.checks import OF_DEPOSITION
from fibermelt.parts.melt.checks import WITHOUT_VISCOSITY

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value

__all__ = ["PART", "STAGES_OF"]

HERE = "fibermelt.paper.claims"

STAGES_OF = {
    "bead": ("streamlines", "motion"),
    "interaction": ("content", "interaction", "stall"),
    "orbits": ("orbits",),
    "voids": ("streamlines", "voids"),
}
"""The stages that claims are judged by, by the part of a study that has them."""


def _fed(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return the stages that the claims are fed, as far as a study has their parts."""
    parts: Any = values["study.parts"]
    asked = [name for part, names in STAGES_OF.items() if part in parts for name in names]
    return tuple(dict.fromkeys(asked))


PART = Part(
    "claims",
    ("claims",),
    f"{HERE}.summary:summarize_claims",
    f"{HERE}.summary:claims_in_words",
    meaning="whether the paper's claims hold in what the others found",
    refuse=f"{HERE}.conditions:refuse_nothing_to_judge",
    attributes=f"{HERE}.conditions:conditions_of",
    traits=frozenset({WITHOUT_VISCOSITY, OF_DEPOSITION}),
    brings=(
        Stage(
            "claims",
            1,
            ("flow", "fiber", "interaction"),
            (),
            f"{HERE}.stages:claims_stage",
            inputs_if=_fed,
            light_if=always,
        ),
    ),
)
