"""The section on the flow: figures only."""

from __future__ import annotations

from fibermelt.report.kit.sections import Section

__all__ = ["FLOW"]

FLOW = Section("flow", "The flow", place=10)
