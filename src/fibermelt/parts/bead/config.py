"""The table ``[fiber]``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, Self

from pydantic import model_validator

from fibermelt.engine.parameters import Section, quantity, setting
from fibermelt.parts.bead.shape import FiberShape
from fibermelt.parts.bead.shapes import SHAPES, choices
from fibermelt.parts.sources import PAPER_3, PAPER_25, VERIFIED

__all__ = ["FROM_CONTENT", "Fiber", "Numerics"]

if TYPE_CHECKING:
    ShapeName = str
else:
    ShapeName = Literal[tuple(SHAPES)]

FROM_CONTENT = "from-content"
"""What a domain size is called that follows from the fiber content."""

FULL_TURN = 2 * math.pi
"""Largest angle [rad] at which a fiber can be said to enter; beyond, it was meant in degrees."""


class Fiber(Section):
    """The fiber, its cell, and how fibers enter the flow."""

    half_length: float = quantity(
        "42 um", "m", "Half the length of the fiber, its major semi-axis.", gt=0, source=PAPER_3
    )
    aspect_ratio: float = quantity(
        6.0,
        "",
        "Length over width of the elliptic fiber.",
        ge=1,
        le=50,
        source=PAPER_3,
        hints={"le": VERIFIED},
    )
    thickness_ratio: float | None = quantity(
        None,
        "",
        "Length over thickness of an ellipsoid of three axes, whose length over width is "
        "aspect_ratio; in the plane of a flow the thickness is across. By default aspect_ratio: a "
        "spheroid. Ellipsoid only.",
        ge=1,
        le=100,
        example="12",
    )
    model: ShapeName = setting(
        next(iter(SHAPES)),
        "What answers for the fiber: " + ", ".join(one.meaning for one in SHAPES.values()) + ".",
        source="the paper's is the confined ellipse; a real fiber is closest to a spheroid",
    )
    melt: Literal["law", "local-viscosity"] = setting(
        "law",
        "How a melt that thins answers a fiber: by its law, the fiber's own disturbance thinned "
        "too; or, an approximation, as a Newtonian melt of the viscosity that the flow has there.",
        source="a Newtonian fiber at the local viscosity sees twice the pressure at n = 0.35",
    )
    domain_size: float | Literal["from-content"] = quantity(
        4.0,
        "",
        "Domain-size factor M: the cell's radius is M / 2 half-lengths. From content: so that the "
        "fiber stalls at the preferred angle of its suspension. Confined ellipse only.",
        words=("from-content",),
        gt=2,
        ge=2.01,
        le=200,
        source=f"{PAPER_25}: M = 4.08, rounded to 4.0",
        hints={
            "gt": "the fiber would be larger than its cell",
            "ge": VERIFIED,
            "le": VERIFIED,
        },
    )
    pressure_reference: Literal["mean", "far-node"] = setting(
        "mean",
        "What has the streamline's pressure: the mean over the cell's edge, or one far node. "
        "Confined ellipse only.",
        source='"far-node" is the paper\'s way, Eq. 7',
    )
    initial_angles: tuple[float, ...] = quantity(
        [f"{degrees} deg" for degrees in range(-90, 91, 15)],
        "rad",
        "Angles at which fibers enter, from the x axis, counter-clockwise.",
        source=PAPER_3,
    )
    directions: Literal["in-plane", "equal-area"] = setting(
        "in-plane",
        "How fibers enter: at initial_angles in the plane of the flow, or evenly over the sphere.",
        source="the paper's fibers lie in the plane; a spheroid need not",
    )
    path: Literal["superposition", "newton"] = setting(
        "superposition",
        "How fibers are followed: by the cell's two flows, or by Newton-Raphson on force and "
        "torque at every step. Newton: confined ellipse only, at 10^4 to 10^5 times the cost.",
        source='"newton" is the paper\'s algorithm, Eq. 15-22',
    )
    direction_count: int = setting(
        50, 'Number of initial directions, with directions = "equal-area".', ge=1, le=10000
    )

    @property
    def shape(self) -> FiberShape:
        """Return what ``model`` names."""
        return SHAPES[self.model]

    @model_validator(mode="after")
    def _path(self) -> Self:
        """Refuse the paper's algorithm where there is no cell to work on."""
        if self.path == "newton" and not self.shape.has_cell:
            msg = (
                'fiber.path = "newton": the paper\'s algorithm works on a cell, which '
                f'fiber.model = "{self.model}" has not: take fiber.model = {choices("has_cell")}, '
                'or fiber.path = "superposition"'
            )
            raise ValueError(msg)
        return self

    @model_validator(mode="after")
    def _start(self) -> Self:
        """Refuse no fibers, degrees written as radians, an ellipse out of its plane."""
        if self.directions == "equal-area" and not self.shape.in_space:
            msg = (
                f'fiber.directions = "equal-area": with fiber.model = "{self.model}" the fiber is '
                "a cylinder across the flow, which has no direction out of the plane: take "
                f"fiber.model = {choices('in_space')}"
            )
            raise ValueError(msg)
        if self.thickness_ratio is not None and not self.shape.has_thickness:
            msg = (
                f"fiber.thickness_ratio = {self.thickness_ratio:g}: with fiber.model = "
                f'"{self.model}" there is no third axis: leave it away, or take fiber.model = '
                f"{choices('has_thickness')}"
            )
            raise ValueError(msg)
        if self.thickness_ratio is not None and self.thickness_ratio < self.aspect_ratio:
            msg = (
                f"fiber.thickness_ratio = {self.thickness_ratio:g}: must be at least "
                f"fiber.aspect_ratio = {self.aspect_ratio:g}, as the thickness is the shortest axis"
            )
            raise ValueError(msg)
        if not self.initial_angles:
            msg = 'fiber.initial_angles = []: at least one angle, such as ["0 deg"]'
            raise ValueError(msg)
        for item, angle in enumerate(self.initial_angles, 1):
            if abs(angle) > FULL_TURN:
                msg = (
                    f"fiber.initial_angles: item {item} = {angle:g} rad: must be within a full "
                    f'turn, {FULL_TURN:.3f} rad (a bare number is in radians; write "-90 deg")'
                )
                raise ValueError(msg)
        return self


class Numerics(Section):
    """The fiber's share of ``[numerics]``."""

    cell_mesh: Literal["graded", "paper"] = setting(
        "graded",
        "Mesh of the fiber's cell: ours, or the paper's 1800 quadratic triangles (Fig. 6).",
        source='"paper" overstates the tip pressure at M = 4 by 14.5 %',
    )
    cell_order: int = setting(
        7, 'Velocity order in the fiber\'s cell, with cell_mesh = "graded".', ge=2, le=13
    )
    thinning_order: int = setting(
        5, "Velocity order in the cells of a fiber in a melt that thins.", ge=3, le=9
    )
    angle_tolerance: float = quantity(
        "1e-8 rad",
        "rad",
        "Largest error of a fiber's angle from the time integration.",
        gt=0,
        lt=0.1,
    )
    isotropic_angles: int = setting(
        200,
        "Number of fibers that stand for an isotropic start, for the quantiles: initial angles in "
        "the plane, directions or frames in space.",
        ge=3,
        le=10000,
    )
