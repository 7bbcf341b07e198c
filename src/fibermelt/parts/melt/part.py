"""The melt as a part of studies: its table, and what follows from it."""

from __future__ import annotations

from fibermelt.engine.parts import Part
from fibermelt.parts.melt.config import Melt, melted
from fibermelt.parts.melt.melt import CARD, LAW

__all__ = ["PART"]

HERE = "fibermelt.parts.melt"

PART = Part(
    "melt",
    tables={"melt": Melt},
    refuse=f"{HERE}.checks:refuse_melts",
    derive=f"{HERE}.melt:derived_of",
    derived={LAW: "melt", CARD: "melt"},
    notes=f"{HERE}.melt:melt_notes",
    renew={"melt": melted},
)
