"""Fibers along the paths of a flow as a part of studies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage, always
from fibermelt.parts.bead.config import FROM_CONTENT, Fiber, Numerics
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.parts.melt.melt import LAW, thins_at_fibers

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value

__all__ = ["PART", "from_content"]

HERE = "fibermelt.parts.bead"

FIBER = (
    "fiber.half_length",
    "fiber.aspect_ratio",
    "fiber.thickness_ratio",
    "fiber.model",
    "fiber.domain_size",
    "fiber.pressure_reference",
)
CELL = (*FIBER, "numerics.cell_mesh", "numerics.cell_order")


def from_content(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return what feeds the cell: its size may follow from the fiber content."""
    return ("content",) if values["fiber.domain_size"] == FROM_CONTENT else ()


def _in_the_melt(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return what feeds the fibers besides: their size, and their table in a melt that thins."""
    return from_content(values) + (("response",) if thins_at_fibers(values) else ())


def _surrounded(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return what a part needs besides: what surrounds a fiber whose flows do not add up.

    Of a fiber in a cell, and where figures show one on its way through a nozzle.
    """
    has_cell = SHAPES[str(values["fiber.model"])].has_cell
    is_shown = has_cell and values["flow.source"] == "deposition" and thins_at_fibers(values)
    return ("surroundings",) if is_shown else ()


def _closed_form(values: Mapping[str, Value]) -> bool:
    """Tell whether the fiber has no cell to solve: 3 ms, where writing and reading takes 70."""
    return not SHAPES[str(values["fiber.model"])].has_cell


PART = Part(
    "bead",
    ("motion",),
    f"{HERE}.summary:summarize_bead",
    f"{HERE}.summary:bead_in_words",
    "fibermelt.parts.flow.stages:write_fields",
    meaning="fibers along the streamlines of the deposition flow",
    tables={"fiber": Fiber, "numerics": Numerics},
    stages_if=_surrounded,
    refuse=f"{HERE}.checks:refuse_fibers",
    notes=f"{HERE}.checks:fiber_notes",
    brings=(
        Stage(
            "cell",
            2,
            CELL,
            (),
            f"{HERE}.stages:cell_stage",
            inputs_if=from_content,
            light_if=_closed_form,
            estimates=f"{HERE}.stages:cell_estimates",
        ),
        Stage(
            "response",
            3,
            (*FIBER, LAW, "numerics.thinning_order"),
            (),
            f"{HERE}.response:response_stage",
            inputs_if=from_content,
            estimates=f"{HERE}.response:response_estimates",
        ),
        Stage(
            "motion",
            6,
            (
                *CELL,
                LAW,
                "fiber.melt",
                "fiber.path",
                "numerics.thinning_order",
                "fiber.initial_angles",
                "fiber.directions",
                "fiber.direction_count",
                "numerics.angle_tolerance",
                "numerics.isotropic_angles",
            ),
            ("streamlines", "cell"),
            f"{HERE}.stages:motion_stage",
            inputs_if=_in_the_melt,
            light_if=always,
            estimates=f"{HERE}.stages:motion_estimates",
            foresee=f"{HERE}.stages:foresee_motion",
        ),
        Stage(
            "surroundings",
            1,
            (*FIBER, LAW, "numerics.thinning_order", "streamlines.features"),
            ("streamlines", "motion"),
            f"{HERE}.response:surroundings_stage",
            inputs_if=from_content,
        ),
    ),
)
