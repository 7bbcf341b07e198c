"""The table ``[numerics]``."""

from __future__ import annotations

from typing import Literal

from fibermelt.engine.parameters import Section, quantity, setting

__all__ = ["Numerics"]


def _edge(default: float, doc: str) -> float:
    """Declare the edge length of a mesh, relative so that it suits a nozzle of any size."""
    edge: float = quantity(default, "", f"{doc}, over the capillary's width.", ge=1e-6, le=0.5)
    return edge


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
        360,
        "Number of directions in space that stand for an isotropic start of spheroids, for the "
        "quantiles; those of fibers in the plane are exact.",
        ge=3,
        le=10000,
    )
