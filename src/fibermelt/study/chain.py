"""The chain of a study: flow, streamlines, the fiber's cell, its motion. Here the scales meet."""

from __future__ import annotations

from collections.abc import Mapping

from fibermelt.study.claims import claims_in_words, summarize_claims
from fibermelt.study.fiber_stages import cell_stage, motion_stage
from fibermelt.study.flow_stages import (
    FLOW_NUMERICS,
    flow_stage,
    streamlines_stage,
    write_fields,
)
from fibermelt.study.parameters import Value
from fibermelt.study.parts import Chain, Part
from fibermelt.study.stages import Stage
from fibermelt.study.summary import bead_in_words, summarize_bead

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


def _closed_form(values: Mapping[str, Value]) -> bool:
    """Tell whether the fiber has no cell to solve: 3 ms, where writing and reading takes 70."""
    return values["fiber.model"] != "confined-ellipse"


CHAIN = Chain(
    stages=(
        Stage("flow", 1, ("flow", "melt", *FLOW_NUMERICS), (), flow_stage),
        Stage(
            "streamlines", 1, _STREAMLINE_PARAMETERS, ("flow",), streamlines_stage, told_with="flow"
        ),
        Stage("cell", 1, _CELL_PARAMETERS, (), cell_stage, light_if=_closed_form),
        Stage("motion", 1, _MOTION_PARAMETERS, ("streamlines", "cell"), motion_stage),
    ),
    parts=(
        Part("bead", ("motion",), summarize_bead, bead_in_words, write_fields),
        Part("claims", (), summarize_claims, claims_in_words),
    ),
    version=1,
)
"""What `fibermelt run` goes through, as far as a study asks for it."""
