"""The parts that there are: a folder each, which has a `PART` in its module ``part``."""

from __future__ import annotations

from importlib import import_module
from typing import cast

from fibermelt.engine.parts import Part

__all__ = ["HOMES", "parts"]

HOMES = (
    "fibermelt.parts.process",
    "fibermelt.parts.flow",
    "fibermelt.parts.melt",
    "fibermelt.parts.bead",
    "fibermelt.parts.orientation",
    "fibermelt.parts.interaction",
    "fibermelt.paper.orbits",
    "fibermelt.paper.dimensions",
    "fibermelt.parts.thinning",
    "fibermelt.parts.plane",
    "fibermelt.parts.voids",
    "fibermelt.parts.verification",
    "fibermelt.paper.claims",
)
"""In the order in which they are told. Each has its figures in ``figures`` and its sections of the
page in ``section``, where the report finds them."""


def parts() -> tuple[Part, ...]:
    """Return all parts."""
    return tuple(cast("Part", import_module(f"{home}.part").PART) for home in HOMES)
