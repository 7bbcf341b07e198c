"""The tables of the deposition flow: ``[flow]``, ``[strand]``, ``[streamlines]``."""

from __future__ import annotations

from dataclasses import fields
from typing import Literal, Self

from pydantic import model_validator

from fibermelt.engine.parameters import Section, declared_by, setting
from fibermelt.flow.problem import BeadNumerics, Deposition, FlowNumerics, Nozzle
from fibermelt.parts.sources import INFERRED, PAPER_21

__all__ = ["FLOW_NUMERICS", "SOLVED", "Flow", "Numerics", "Strand", "Streamlines"]

FLOW_NUMERICS = tuple(f"numerics.{one.name}" for one in fields(FlowNumerics))
"""What the flow reads of ``[numerics]``."""

SOLVED = ("deposition", "deposition-3d")
"""Sources of a flow that is solved here, of a nozzle over a bed."""

OUTLET_BEADS = 2.0
"""Bead heights from the downstream lip to the outlet, at least: the swell needs the room."""

SHORTEST, LONGEST = 0.01, 100.0
"""Lengths of the nozzle and its gap over the capillary's width: beyond, no mesh resolves both."""


class Flow(Section):
    """The nozzle, its height over the bed, and the two speeds; or that the flow is given."""

    source: Literal["deposition", "deposition-3d", "field", "histories"] = setting(
        "deposition",
        "Where the flow comes from: the deposition flow of this table is solved, in the plane or "
        "in space, where widths are diameters of a round nozzle ([strand]); another solver's "
        "field is read ([field], [paths]); or paths are (paths.file).",
    )

    inlet_width: float = declared_by(
        Nozzle, "inlet_width", "Width of the nozzle's inlet.", "mm", le=1, source=INFERRED
    )
    inlet_length: float = declared_by(
        Nozzle,
        "inlet_length",
        "Length of the straight channel above the taper.",
        "mm",
        le=1,
        source=INFERRED,
    )
    taper_length: float = declared_by(
        Nozzle,
        "taper_length",
        "Length over which the nozzle narrows to the capillary.",
        "mm",
        le=1,
        source=INFERRED,
    )
    capillary_width: float = declared_by(
        Nozzle,
        "capillary_width",
        "Width of the capillary, the nozzle's outlet.",
        "mm",
        le=1,
        source=INFERRED,
    )
    capillary_length: float = declared_by(
        Nozzle, "capillary_length", "Length of the capillary.", "mm", le=1, source=INFERRED
    )
    gap: float = declared_by(
        Nozzle, "gap", "Distance from the nozzle's lips to the bed.", "mm", le=1, source=INFERRED
    )
    outlet: float = declared_by(
        Nozzle,
        "outlet",
        "Where the bead is cut off, downstream of the nozzle's axis (x of the outlet).",
        "mm",
        le=1,
        source="far enough that the answer does not feel it",
    )
    inlet_speed: float = declared_by(
        Deposition,
        "inlet_speed",
        "Mean speed of the melt at the inlet.",
        "mm/s",
        le=100,
        source=PAPER_21,
    )
    bed_speed: float = declared_by(
        Deposition, "bed_speed", "Speed of the bed, towards +x.", "mm/s", le=100, source=PAPER_21
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
        if self.source == "deposition-3d":  # what the solver in space refuses, it names
            return self
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


def _edge(name: str, doc: str) -> float:
    """Declare the edge length of a mesh, relative so that it suits a nozzle of any size."""
    edge: float = declared_by(FlowNumerics, name, f"{doc}, over the capillary's width.")
    return edge


def _of_bead(name: str, doc: str) -> float:
    """Declare an edge length of a bead in space, likewise."""
    edge: float = declared_by(BeadNumerics, name, f"{doc}, over the nozzle's diameter.")
    return edge


class Strand(Section):
    """How a bead in space is solved: the film that is the bed, and the mesh."""

    film: float = declared_by(
        BeadNumerics,
        "film",
        "Thickness of the film that stands for the bed, over the nozzle's diameter; the bead is "
        "extrapolated from it and twice it.",
    )
    lip_edge: float = _of_bead("lip_edge", "Thickness of the layers at the lip")
    bulk_edge: float = _of_bead("bulk_edge", "Thickness of layers away from it")
    rim_edge: float = _of_bead("rim_edge", "Width of the outermost ring of the section")
    sectors: int = declared_by(
        BeadNumerics, "sectors", "Elements around half of the section, a multiple of four."
    )
    edge_growth: float = declared_by(
        BeadNumerics, "edge_growth", "How fast edges grow away from lip and rim, per distance."
    )
    flow_tolerance: float = declared_by(
        BeadNumerics,
        "flow_tolerance",
        "Newton stops when no mesh node moves further than this over the nozzle's diameter.",
    )


class Streamlines(Section):
    """The paths that fibers take through the flow."""

    count: int = setting(
        22,
        "Number of streamlines, each with the same share of the flux, from the upstream edge.",
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
        source="the paper's feature streamlines: near both edges and at the center",
    )


class Numerics(Section):
    """Orders, edge lengths and tolerances: what changes the cost and the error, not the problem."""

    flow_order: int = declared_by(
        FlowNumerics,
        "flow_order",
        "Velocity order of the flow; the pressure has one less. 2 is coarser, 4 finer and slower.",
    )
    lip_edge: float = _edge("lip_edge", "Mesh edge at the lips")
    contact_edge: float = _edge("contact_edge", "Mesh edge at the upstream contact point")
    corner_edge: float = _edge("corner_edge", "Mesh edge at the capillary's entrance")
    surface_edge: float = _edge("surface_edge", "Largest mesh edge on a free surface")
    bulk_edge: float = _edge("bulk_edge", "Largest mesh edge in the bead")
    edge_growth: float = declared_by(
        FlowNumerics,
        "edge_growth",
        "How fast edges grow away from lips and contact, per distance.",
    )
    flow_tolerance: float = declared_by(
        FlowNumerics,
        "flow_tolerance",
        "Newton stops when no mesh node moves further than this over the capillary's width.",
    )
    contact_guess: float | None = declared_by(
        FlowNumerics,
        "contact_guess",
        "First guess of the contact point's x; the answer does not depend on it.",
        example="1 mm",
    )
