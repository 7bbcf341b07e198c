"""A study, as a value: every parameter of the chain in SI, declared once with its source."""

from __future__ import annotations

import math
from typing import Literal, Self

from pydantic import Field, model_validator

from fibermelt.study.parameters import Section, quantity, setting
from fibermelt.study.voids.config import Voids

__all__ = [
    "Config",
    "Fiber",
    "Flow",
    "Interaction",
    "Melt",
    "Numerics",
    "Sensitivity",
    "Streamlines",
    "Voids",
    "What",
]

_INFERRED = "inferred: the paper prints no dimensions; these reproduce its stated results"
_PAPER_2 = "the paper, section 2 (after Heller et al. and Wang et al.)"
_PAPER_21 = "the paper, section 2.1 (after Heller et al. and Wang et al.)"
_PAPER_25 = "the paper, section 2.5: M = 4.08, rounded to 4.0"
_PAPER_25_ = "the paper, section 2.5"
_PAPER_3 = "the paper, section 3"
_TABLE_1 = "the paper, Table 1"

OUTLET_BEADS = 2.0
"""Bead heights from the downstream lip to the outlet, at least: the swell needs the room."""

FROM_CONTENT = "from-content"
"""What a domain size is called that follows from the fiber content."""

SHORTEST, LONGEST = 0.01, 100.0
"""Lengths of the nozzle and its gap over the capillary's width: beyond, no mesh resolves both."""

FULL_TURN = 2 * math.pi
"""Largest angle [rad] at which a fiber can be said to enter; beyond, it was meant in degrees."""

_VERIFIED = "the fiber's cell is verified in this range only"


def _edge(default: float, doc: str) -> float:
    """Declare the edge length of a mesh, relative so that it suits a nozzle of any size."""
    edge: float = quantity(default, "", f"{doc}, over the capillary's width.", ge=1e-6, le=0.5)
    return edge


PartName = Literal[
    "bead",
    "orientation",
    "interaction",
    "orbits",
    "dimensions",
    "voids",
    "verification",
    "claims",
]
"""What can be asked for; the chain has a part of each name."""


class What(Section):
    """What is computed: a study can be of a bead, of a single fiber, or of both."""

    parts: tuple[PartName, ...] = setting(
        ["bead"],
        'What is computed. "bead": fibers along the streamlines of the deposition flow; '
        '"orientation": orientation tensors along them; "interaction": from fiber content to the '
        'size of the cell; "orbits": '
        'one fiber in simple shear; "dimensions": what the plane ellipse costs against a spheroid; '
        '"voids": where in the bead voids can start; "verification": what this installation is '
        'checked against; "claims": whether the paper\'s claims hold in what the others found.',
    )
    ladder: Literal["brief", "quick", "full"] = setting(
        "brief",
        'How much "verification" checks: in about 5 s, in 10 s, or as fibermelt verify does.',
    )

    @model_validator(mode="after")
    def _something(self) -> Self:
        """Refuse a study of nothing."""
        if not self.parts:
            msg = 'study.parts = []: name at least one, such as ["bead"]'
            raise ValueError(msg)
        if self.parts == ("claims",):
            msg = (
                'study.parts = ["claims"]: nothing to judge them by; name "bead", "orbits", '
                '"interaction" or "voids" beside it'
            )
            raise ValueError(msg)
        return self


class Flow(Section):
    """The nozzle, its height over the bed, and the two speeds."""

    inlet_width: float = quantity(
        "12.7 mm", "m", "Width of the nozzle's inlet.", gt=0, le=1, source=_INFERRED
    )
    inlet_length: float = quantity(
        "5 mm", "m", "Length of the straight channel above the taper.", gt=0, le=1, source=_INFERRED
    )
    taper_length: float = quantity(
        "8 mm",
        "m",
        "Length over which the nozzle narrows to the capillary.",
        gt=0,
        le=1,
        source=_INFERRED,
    )
    capillary_width: float = quantity(
        "3.175 mm",
        "m",
        "Width of the capillary, the nozzle's outlet.",
        gt=0,
        le=1,
        source=_INFERRED,
    )
    capillary_length: float = quantity(
        "6 mm", "m", "Length of the capillary.", gt=0, le=1, source=_INFERRED
    )
    gap: float = quantity(
        "3 mm", "m", "Distance from the nozzle's lips to the bed.", gt=0, le=1, source=_INFERRED
    )
    outlet: float = quantity(
        "20 mm",
        "m",
        "Where the bead is cut off, downstream of the nozzle's axis (x of the outlet).",
        gt=0,
        le=1,
        source="far enough that the answer does not feel it",
    )
    inlet_speed: float = quantity(
        "24 mm/s", "m/s", "Mean speed of the melt at the inlet.", gt=0, le=100, source=_PAPER_21
    )
    bed_speed: float = quantity(
        "101.6 mm/s", "m/s", "Speed of the bed, towards +x.", gt=0, le=100, source=_PAPER_21
    )

    @property
    def bead_height(self) -> float:
        """Return the height of the finished bead [m]: mass balance, ``Q / V``."""
        return self.inlet_speed * self.inlet_width / self.bed_speed

    @model_validator(mode="after")
    def _geometry(self) -> Self:
        """Refuse dimensions that contradict one another."""
        if self.inlet_width < self.capillary_width:
            msg = (
                f"flow.inlet_width = {self.inlet_width:g} m is narrower than "
                f"flow.capillary_width = {self.capillary_width:g} m: a nozzle narrows "
                "downwards; widen flow.inlet_width or narrow flow.capillary_width"
            )
            raise ValueError(msg)
        self._proportions()
        nearest = self.capillary_width / 2 + OUTLET_BEADS * self.bead_height
        if self.outlet < nearest:
            msg = (
                f"flow.outlet = {self.outlet:g} m lies too near the nozzle: at least "
                f"{nearest:g} m (flow.capillary_width / 2 + {OUTLET_BEADS:g} bead heights of "
                f"{self.bead_height:g} m)"
            )
            raise ValueError(msg)
        return self

    def _proportions(self) -> None:
        """Refuse a length that the capillary's width tells to be a slip of the unit."""
        width = self.capillary_width
        lowest = dict.fromkeys(
            ("inlet_length", "taper_length", "capillary_length", "gap", "outlet"), SHORTEST
        )
        for name, low in {"inlet_width": 0.0, **lowest}.items():
            length = getattr(self, name)
            if low * width <= length <= LONGEST * width:
                continue
            bound = (
                f"at least {low * width:g}" if length < width else f"at most {LONGEST * width:g}"
            )
            msg = (
                f"flow.{name} = {length:g} m is {length / width:.3g} times flow.capillary_width = "
                f"{width:g} m: must be {bound} m ({low:g} to {LONGEST:g} times); "
                "correct one of the two"
            )
            raise ValueError(msg)


class Melt(Section):
    """The polymer melt, Newtonian."""

    viscosity: float = quantity(
        "817 Pa s", "Pa s", "Dynamic viscosity.", ge=1e-6, le=1e12, source=_PAPER_2
    )
    density: float = quantity("1154 kg/m^3", "kg/m^3", "Density.", gt=0, le=1e5, source=_PAPER_2)


class Fiber(Section):
    """The fiber, its cell, and how fibers enter the flow."""

    half_length: float = quantity(
        "42 um", "m", "Half the length of the fiber, its major semi-axis.", gt=0, source=_PAPER_3
    )
    aspect_ratio: float = quantity(
        6.0,
        "",
        "Length over width of the elliptic fiber.",
        ge=1,
        le=50,
        source=_PAPER_3,
        hints={"le": _VERIFIED},
    )
    model: Literal["confined-ellipse", "ellipse", "spheroid"] = setting(
        "confined-ellipse",
        "What answers for the fiber: an ellipse in its cell; an ellipse or a spheroid without one.",
        source="the paper's is the confined ellipse; a real fiber is closest to a spheroid",
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
        source=_PAPER_25,
        hints={
            "gt": "the fiber would be larger than its cell",
            "ge": _VERIFIED,
            "le": _VERIFIED,
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
        source=_PAPER_3,
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

    @model_validator(mode="after")
    def _path(self) -> Self:
        """Refuse the paper's algorithm where there is no cell to work on."""
        if self.path == "newton" and self.model != "confined-ellipse":
            msg = (
                'fiber.path = "newton": the paper\'s algorithm works on a cell, which '
                f'fiber.model = "{self.model}" has not: take fiber.model = "confined-ellipse", or '
                'fiber.path = "superposition"'
            )
            raise ValueError(msg)
        return self

    @model_validator(mode="after")
    def _start(self) -> Self:
        """Refuse no fibers, degrees written as radians, an ellipse out of its plane."""
        if self.directions == "equal-area" and self.model != "spheroid":
            msg = (
                f'fiber.directions = "equal-area": with fiber.model = "{self.model}" the fiber is '
                "a cylinder across the flow, which has no direction out of the plane: take "
                'fiber.model = "spheroid"'
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


class Streamlines(Section):
    """The paths that fibers take through the flow."""

    count: int = setting(
        22,
        "Number of streamlines, each with the same share of the flux, from the left edge.",
        ge=1,
        le=1000,
        source="the paper numbers them so: 4, 10 and 18 are its feature streamlines",
    )
    points: int = setting(1500, "Number of points on each streamline.", ge=50, le=20000)
    features: tuple[int, ...] = setting(
        [4, 10, 18],
        "Streamlines that are looked at one by one; where there are none of these numbers, those "
        "of the same share of the flux as the paper's.",
        ge=1,
        le=1000,
        source="the paper's feature streamlines: near the left edge, the center, the right edge",
    )


class Interaction(Section):
    """How fibers disturb one another: the suspension, and the law of its orientation."""

    volume_fraction: float = quantity(
        0.084, "", "Fiber content by volume.", gt=0, lt=1, source=f"{_PAPER_25_}, 13 % by weight"
    )
    law: Literal["bay", "phan-thien"] = setting(
        "bay", "What content and aspect ratio say of the coefficient.", source=_PAPER_25_
    )
    coefficient: float | None = quantity(
        None, "", "Interaction coefficient C_I; from the law if left out.", gt=0, example="0.0128"
    )
    closure: Literal[
        "linear", "quadratic", "hybrid", "ORS", "ORF", "ORL", "ORW", "ORW3", "ORE", "IBOF", "exact"
    ] = setting("ORE", "Closure of the fourth moment of the orientation.", source=_PAPER_25_)
    convention: Literal["standard", "paper"] = setting(
        "standard",
        "Rate of deformation that multiplies the coefficient: sqrt(2 D:D), or sqrt(2) times that.",
        source='"paper" is what the paper\'s Eq. 33 follows, not what its text says',
    )
    start: Literal["isotropic", "inlet"] = setting(
        "isotropic",
        "Orientation of the fibers that enter: every direction alike, or steady in the inlet's "
        "flow.",
    )


class Sensitivity(Section):
    """One fiber in simple shear: what is varied, and the cell that it turns in."""

    aspect_ratios: tuple[float, ...] = quantity(
        [1.0, 3.0, 6.0, 8.0, 10.0], "", "Aspect ratios.", ge=1, le=50, source=_TABLE_1
    )
    shear_rates: tuple[float, ...] = quantity(
        ["0.25 1/s", "0.5 1/s", "1 1/s", "2 1/s", "5 1/s"],
        "1/s",
        "Shear rates.",
        gt=0,
        source=_TABLE_1,
    )
    viscosities: tuple[float, ...] = quantity(
        ["200 Pa s", "400 Pa s", "817 Pa s", "1600 Pa s"],
        "Pa s",
        "Viscosities.",
        ge=1e-6,
        le=1e12,
        source="chosen: the paper varies the viscosity but states no values in its text",
    )
    shear_rate: float = quantity(
        "1 1/s", "1/s", "Shear rate while something else is varied.", gt=0, source=_TABLE_1
    )
    domain_size: float = quantity(
        28.0,
        "",
        "Domain-size factor M of the cell that the fiber turns in.",
        gt=2,
        ge=2.01,
        le=200,
        source="chosen: gives the periods of the paper's finite elements (Table 1) at aspect "
        "ratios of 6, 8 and 10 within 0.2 %; the paper does not state its own",
        hints={"gt": "the fiber would be larger than its cell", "ge": _VERIFIED, "le": _VERIFIED},
    )

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        """Refuse no aspect ratio, and what is listed twice."""
        if not self.aspect_ratios:
            msg = "sensitivity.aspect_ratios = []: at least one, such as [6]"
            raise ValueError(msg)
        for name in ("aspect_ratios", "shear_rates", "viscosities"):
            values = getattr(self, name)
            if len(set(values)) < len(values):
                msg = f"sensitivity.{name}: lists a value twice: name each once"
                raise ValueError(msg)
        return self


class Numerics(Section):
    """Orders, edge lengths and tolerances: what changes the cost and the error, not the problem."""

    flow_order: int = setting(
        3,
        "Velocity order of the flow; the pressure has one less. 2 is coarser, 4 finer and slower.",
        ge=2,
        le=6,
    )
    lip_edge: float = _edge(5e-4, "Mesh edge at the lips")
    contact_edge: float = _edge(1e-3, "Mesh edge at the upstream contact point")
    corner_edge: float = _edge(1e-2, "Mesh edge at the capillary's entrance")
    surface_edge: float = _edge(0.07, "Largest mesh edge on a free surface")
    bulk_edge: float = _edge(0.1, "Largest mesh edge in the bead")
    edge_growth: float = quantity(
        0.3, "", "How fast edges grow away from lips and contact, per distance.", ge=0.05, le=1
    )
    flow_tolerance: float = quantity(
        1e-7,
        "",
        "Newton stops when no mesh node moves further than this over the capillary's width.",
        ge=1e-12,
        le=1e-3,
    )
    contact_guess: float | None = quantity(
        None,
        "m",
        "First guess of the contact point's x; the answer does not depend on it.",
        example="1 mm",
    )
    cell_mesh: Literal["graded", "paper"] = setting(
        "graded",
        "Mesh of the fiber's cell: ours, or the paper's 1800 quadratic triangles (Fig. 6).",
        source='"paper" overstates the tip pressure at M = 4 by 14.5 %',
    )
    cell_order: int = setting(
        7, 'Velocity order in the fiber\'s cell, with cell_mesh = "graded".', ge=2, le=13
    )
    angle_tolerance: float = quantity(
        "1e-8 rad",
        "rad",
        "Largest error of a fiber's angle from the time integration.",
        gt=0,
        lt=0.1,
    )
    isotropic_angles: int = setting(
        360,
        "Number of directions in space that stand for an isotropic start of spheroids, for the "
        "quantiles; those of fibers in the plane are exact.",
        ge=3,
        le=10000,
    )


class Config(Section):
    """A study: what `fibermelt run` is given, resolved."""

    study: What = Field(default_factory=What)
    flow: Flow = Field(default_factory=Flow)
    melt: Melt = Field(default_factory=Melt)
    fiber: Fiber = Field(default_factory=Fiber)
    streamlines: Streamlines = Field(default_factory=Streamlines)
    interaction: Interaction = Field(default_factory=Interaction)
    sensitivity: Sensitivity = Field(default_factory=Sensitivity)
    voids: Voids = Field(default_factory=Voids)
    numerics: Numerics = Field(default_factory=Numerics)

    @model_validator(mode="after")
    def _moisture(self) -> Self:
        """Refuse what the material's card does not allow, before the flow is computed."""
        if "voids" in self.study.parts:
            self.voids.refuse_impossible()
        return self

    @model_validator(mode="after")
    def _scales(self) -> Self:
        """Refuse a fiber that sees the walls: every model takes the flow for a uniform gradient."""
        width, half_length = self.flow.capillary_width, self.fiber.half_length
        if self.fiber.model != "confined-ellipse" and 2 * half_length >= width:
            msg = (
                f"fiber.half_length = {half_length:g} m is too long: the fiber does not fit across "
                f"the capillary, flow.capillary_width = {width:g} m; shorten the fiber"
            )
            raise ValueError(msg)
        if self.fiber.model != "confined-ellipse" or self.fiber.domain_size == "from-content":
            return self
        cell = self.fiber.domain_size * half_length
        if cell >= width:
            msg = (
                f"fiber.half_length = {half_length:g} m is too long: its cell is {cell:g} m "
                f"across (fiber.domain_size = {self.fiber.domain_size:g} half-lengths), "
                f"flow.capillary_width = {width:g} m; shorten the fiber or lower fiber.domain_size"
            )
            raise ValueError(msg)
        return self
