"""The table ``[interaction]``."""

from __future__ import annotations

from typing import Literal

from fibermelt.study.config.sources import PAPER_25
from fibermelt.study.parameters import Section, quantity, setting

__all__ = ["Interaction"]


class Interaction(Section):
    """How fibers disturb one another: the suspension, and the law of its orientation."""

    volume_fraction: float = quantity(
        0.084, "", "Fiber content by volume.", gt=0, lt=1, source=f"{PAPER_25}, 13 % by weight"
    )
    law: Literal["bay", "phan-thien"] = setting(
        "bay", "What content and aspect ratio say of the coefficient.", source=PAPER_25
    )
    coefficient: float | None = quantity(
        None, "", "Interaction coefficient C_I; from the law if left out.", gt=0, example="0.0128"
    )
    closure: Literal[
        "linear", "quadratic", "hybrid", "ORS", "ORF", "ORL", "ORW", "ORW3", "ORE", "IBOF", "exact"
    ] = setting("ORE", "Closure of the fourth moment of the orientation.", source=PAPER_25)
    convention: Literal["standard", "paper"] = setting(
        "standard",
        "Rate of deformation that multiplies the coefficient: sqrt(2 D:D), or sqrt(2) times that.",
        source='"paper" is what the paper\'s Eq. 33 follows, not what its text says',
    )
    start: Literal["isotropic", "inlet"] = setting(
        "isotropic",
        "Orientation of the fibers that enter: every direction alike, or steady in the inlet's "
        "flow.",
    )
