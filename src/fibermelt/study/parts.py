"""The parts of a study, by the packages that hold them: adding one adds a line."""

from __future__ import annotations

__all__ = ["HOMES"]

HOMES = (
    "fibermelt.parts.melt",
    "fibermelt.parts.flow",
    "fibermelt.parts.bead",
    "fibermelt.parts.interaction",
    "fibermelt.parts.orientation",
    "fibermelt.parts.voids",
    "fibermelt.parts.thinning",
    "fibermelt.parts.verification",
    "fibermelt.paper.orbits",
    "fibermelt.paper.dimensions",
    "fibermelt.paper.claims",
)
"""Each has its figures in ``figures``, a module or a package, and its words in ``section``."""
