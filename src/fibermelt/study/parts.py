"""Where the parts of a study are at home: adding one is its folder and a line here."""

from __future__ import annotations

__all__ = ["HOMES"]

HOMES = (
    "fibermelt.parts.flow",
    "fibermelt.parts.bead",
    "fibermelt.parts.orientation",
    "fibermelt.parts.interaction",
    "fibermelt.parts.thinning",
    "fibermelt.parts.voids",
    "fibermelt.parts.verification",
    "fibermelt.paper.orbits",
    "fibermelt.paper.dimensions",
    "fibermelt.paper.claims",
)
"""Packages; what they hold is found in modules of known names, such as ``quantities``."""
