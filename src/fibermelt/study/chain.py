"""The chain of a study: flow, streamlines, the fiber's cell, its motion. Here the scales meet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fibermelt.engine.parts import Chain, Part
from fibermelt.engine.stages import Stage
from fibermelt.paper.claims.stages import CLAIM_TABLES, claims_stage, fed_by_parts
from fibermelt.paper.claims.summary import claims_in_words, summarize_claims
from fibermelt.paper.dimensions.stages import DIMENSIONS_PARAMETERS, dimensions_stage
from fibermelt.paper.orbits.stages import ORBITS_PARAMETERS, orbits_stage
from fibermelt.paper.orbits.summary import (
    dimensions_in_words,
    orbits_in_words,
    summarize_dimensions,
    summarize_orbits,
)
from fibermelt.parts.bead.response import response_estimates, response_stage
from fibermelt.parts.bead.stages import (
    cell_estimates,
    cell_stage,
    foresee_motion,
    motion_estimates,
    motion_stage,
)
from fibermelt.parts.bead.summary import bead_in_words, summarize_bead
from fibermelt.parts.flow.imported import field_stage
from fibermelt.parts.flow.stages import (
    FLOW_NUMERICS,
    flow_but_for_scale,
    flow_estimates,
    flow_from,
    flow_stage,
    streamline_estimates,
    streamlines_stage,
    write_fields,
)
from fibermelt.parts.interaction.stages import interaction_stage
from fibermelt.parts.melt.melt import LAW, thins_at_fibers
from fibermelt.parts.orientation.stages import (
    content_stage,
    orientation_estimates,
    orientation_stage,
    stall_estimates,
    stall_stage,
)
from fibermelt.parts.orientation.summary import (
    interaction_in_words,
    orientation_in_words,
    summarize_interaction,
    summarize_orientation,
)
from fibermelt.parts.thinning.stages import EFFECT_PARAMETERS, effect_stage
from fibermelt.parts.thinning.summary import summarize_thinning, thinning_in_words
from fibermelt.parts.verification.stages import verification_stage
from fibermelt.parts.verification.summary import (
    summarize_verification,
    verification_in_words,
)
from fibermelt.parts.voids.stages import VOID_PARAMETERS, voids_stage, with_orientation
from fibermelt.parts.voids.summary import summarize_voids, voids_in_words
from fibermelt.study.config import FROM_CONTENT
from fibermelt.verify.ladder import LADDER_VERSION

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value

__all__ = ["CHAIN"]

_FIBER_PARAMETERS = (
    "fiber.half_length",
    "fiber.aspect_ratio",
    "fiber.thickness_ratio",
    "fiber.model",
    "fiber.domain_size",
    "fiber.pressure_reference",
)
_CELL_PARAMETERS = (*_FIBER_PARAMETERS, "numerics.cell_mesh", "numerics.cell_order")
_RESPONSE_PARAMETERS = (*_FIBER_PARAMETERS, LAW, "numerics.thinning_order")
_STREAMLINE_PARAMETERS = ("flow", LAW, "streamlines.count", "streamlines.points", "paths")
_MOTION_PARAMETERS = (
    *_CELL_PARAMETERS,
    LAW,
    "fiber.melt",
    "fiber.path",
    "numerics.thinning_order",
    "fiber.initial_angles",
    "fiber.directions",
    "fiber.direction_count",
    "numerics.angle_tolerance",
    "numerics.isotropic_angles",
)

_CONTENT_PARAMETERS = (
    "fiber.aspect_ratio",
    "interaction.volume_fraction",
    "interaction.law",
    "interaction.coefficient",
    "interaction.closure",
    "interaction.convention",
)
_ORIENTATION_PARAMETERS = ("fiber.aspect_ratio", "interaction")


def _from_content(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return what feeds the cell: its size may follow from the fiber content."""
    return ("content",) if values["fiber.domain_size"] == FROM_CONTENT else ()


def _in_the_melt(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return what feeds the fibers besides: their size, and their table in a melt that thins."""
    return _from_content(values) + _thinning(values)


def _thinning(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return the table of fibers in a melt that thins, where a study has one."""
    return ("response",) if thins_at_fibers(values) else ()


def _flow_of(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return where the paths lead through: the deposition flow, a field, or nothing."""
    return {"deposition": ("flow",), "field": ("field",), "histories": ()}[
        str(values["flow.source"])
    ]


def _always(values: Mapping[str, Value]) -> bool:
    """Tell that a stage costs less than to store it: milliseconds, or megabytes."""
    return True


def _closed_form(values: Mapping[str, Value]) -> bool:
    """Tell whether the fiber has no cell to solve: 3 ms, where writing and reading takes 70."""
    return values["fiber.model"] != "confined-ellipse"


CHAIN = Chain(
    stages=(
        Stage(
            "flow",
            6,
            ("flow", LAW, *FLOW_NUMERICS),
            (),
            flow_stage,
            compute_from=flow_from,
            but_for_scale=flow_but_for_scale,
            estimates=flow_estimates,
        ),
        Stage("field", 4, ("field",), (), field_stage),
        Stage(
            "streamlines",
            4,
            _STREAMLINE_PARAMETERS,
            (),
            streamlines_stage,
            told_with="flow",
            inputs_if=_flow_of,
            estimates=streamline_estimates,
        ),
        Stage("stall", 2, ("fiber.aspect_ratio",), (), stall_stage, estimates=stall_estimates),
        Stage("content", 1, _CONTENT_PARAMETERS, ("stall",), content_stage),
        Stage(
            "cell",
            2,
            _CELL_PARAMETERS,
            (),
            cell_stage,
            inputs_if=_from_content,
            light_if=_closed_form,
            estimates=cell_estimates,
        ),
        Stage(
            "response",
            1,
            _RESPONSE_PARAMETERS,
            (),
            response_stage,
            inputs_if=_from_content,
            estimates=response_estimates,
        ),
        Stage(
            "motion",
            3,
            _MOTION_PARAMETERS,
            ("streamlines", "cell"),
            motion_stage,
            inputs_if=_in_the_melt,
            light_if=_always,
            estimates=motion_estimates,
            foresee=foresee_motion,
        ),
        Stage(
            "orientation",
            4,
            _ORIENTATION_PARAMETERS,
            ("streamlines",),
            orientation_stage,
            estimates=orientation_estimates,
        ),
        Stage(
            "voids",
            3,
            VOID_PARAMETERS,
            ("streamlines", "cell", "motion"),
            voids_stage,
            inputs_if=with_orientation,
            light_if=_always,
        ),
        Stage(
            "interaction",
            1,
            ("fiber.aspect_ratio", "interaction.closure"),
            ("stall",),
            interaction_stage,
        ),
        Stage("orbits", 2, ORBITS_PARAMETERS, (), orbits_stage),
        Stage(
            "dimensions",
            1,
            DIMENSIONS_PARAMETERS,
            ("streamlines", "cell"),
            dimensions_stage,
            inputs_if=_from_content,
        ),
        Stage(
            "thinning",
            1,
            EFFECT_PARAMETERS,
            ("flow", "streamlines", "cell"),
            effect_stage,
            inputs_if=_from_content,
        ),
        Stage("verification", LADDER_VERSION, ("study.ladder",), (), verification_stage),
        Stage(
            "claims", 1, CLAIM_TABLES, (), claims_stage, inputs_if=fed_by_parts, light_if=_always
        ),
    ),
    parts=(
        Part("bead", ("motion",), summarize_bead, bead_in_words, write_fields),
        Part("orientation", ("orientation",), summarize_orientation, orientation_in_words),
        Part(
            "interaction", ("content", "interaction"), summarize_interaction, interaction_in_words
        ),
        Part("orbits", ("orbits",), summarize_orbits, orbits_in_words),
        Part("dimensions", ("dimensions",), summarize_dimensions, dimensions_in_words),
        Part("thinning", ("thinning",), summarize_thinning, thinning_in_words),
        Part("voids", ("voids",), summarize_voids, voids_in_words),
        Part("verification", ("verification",), summarize_verification, verification_in_words),
        Part("claims", ("claims",), summarize_claims, claims_in_words),
    ),
    version=5,
)
"""What `fibermelt run` goes through, as far as a study asks for it."""
