"""The process as a part of studies: its table, and what follows from it."""

from __future__ import annotations

from fibermelt.engine.parts import Part
from fibermelt.parts.process.config import Process

__all__ = ["PART"]

HERE = "fibermelt.parts.process"

PART = Part(
    "process",
    tables={"process": Process},
    lend=f"{HERE}.slot:lend",
    refuse=f"{HERE}.checks:refuse_process",
    notes=f"{HERE}.checks:process_notes",
)
