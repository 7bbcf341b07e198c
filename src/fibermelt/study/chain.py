"""The chain of a study: flow, streamlines, the fiber's cell, its motion. Here the scales meet."""

from __future__ import annotations

from fibermelt.study.claims import claims_in_words, summarize_claims
from fibermelt.study.fiber_stages import cell_stage, motion_stage
from fibermelt.study.flow_stages import (
    FLOW_NUMERICS,
    flow_stage,
    streamlines_stage,
    write_fields,
)
from fibermelt.study.parts import Chain, Part
from fibermelt.study.stages import Stage
from fibermelt.study.summary import bead_in_words, summarize_bead
from fibermelt.study.void_stages import VOID_PARAMETERS, voids_stage
from fibermelt.study.void_summary import summarize_voids, voids_in_words

__all__ = ["CHAIN"]

_CELL_PARAMETERS = (
    "fiber.half_length",
    "fiber.aspect_ratio",
    "fiber.model",
    "fiber.domain_size",
    "fiber.pressure_reference",
    "numerics.cell_mesh",
    "numerics.cell_order",
)
_STREAMLINE_PARAMETERS = ("flow", "melt", "streamlines.count", "streamlines.points")
_MOTION_PARAMETERS = (
    "melt.viscosity",
    "fiber.initial_angles",
    "fiber.directions",
    "fiber.direction_count",
    "numerics.angle_tolerance",
    "numerics.isotropic_angles",
)

CHAIN = Chain(
    stages=(
        Stage("flow", 1, ("flow", "melt", *FLOW_NUMERICS), (), flow_stage),
        Stage(
            "streamlines", 1, _STREAMLINE_PARAMETERS, ("flow",), streamlines_stage, told_with="flow"
        ),
        Stage("cell", 1, _CELL_PARAMETERS, (), cell_stage),
        Stage("motion", 1, _MOTION_PARAMETERS, ("streamlines", "cell"), motion_stage),
        Stage("voids", 1, VOID_PARAMETERS, ("streamlines", "cell", "motion"), voids_stage),
    ),
    parts=(
        Part("bead", ("motion",), summarize_bead, bead_in_words, write_fields),
        Part("voids", ("voids",), summarize_voids, voids_in_words),
        Part("claims", (), summarize_claims, claims_in_words),
    ),
    version=1,
)
"""What `fibermelt run` goes through, as far as a study asks for it."""
