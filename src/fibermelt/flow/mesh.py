"""The mesh of nozzle and bead for given free surfaces, in capillary widths."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import ngsolve as ng
import numpy as np
from netgen.geom2d import SplineGeometry
from netgen.libngpy._meshing import NgException
from numpy.typing import NDArray

from fibermelt.errors import MeshError
from fibermelt.flow.problem import FlowNumerics, Nozzle
from fibermelt.flow.spacing import resample

__all__ = ["NOZZLE_COARSENING", "Surfaces", "deposition_mesh", "scaled"]

Array = NDArray[np.float64]

NOZZLE_COARSENING = 2.0
"""Edges in the nozzle against those in the bead: its flow is smooth but for the two corners."""

GIVE_UP = 20
"""Rounds after which the mesher gives a front up; with its own 200 a bad outline never ends."""

SHRINKAGES = (1.0, 0.9, 0.8, 0.65)
"""Edges are tried this many times as long: on one outline in twenty the mesher's front does not
close for the first choice, for no reason that shows, and does for the next."""

LARGEST_OVERSHOOT = 3.0
"""A mesh edge at a lip longer than this times what was asked for is not what was asked for."""


AT_LIP = 1e-9
"""Distance [widths] at which an end of an edge is the lip: above rounding, below any edge."""


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The two free surfaces as polylines, in capillary widths.

    ``upstream`` runs from the left lip to the contact point on the bed, ``downstream`` from the
    right lip to the outlet.
    """

    upstream: Array
    downstream: Array


def scaled(nozzle: Nozzle) -> Nozzle:
    """Return the nozzle with the capillary's width as the unit of length."""
    width = nozzle.capillary_width
    return Nozzle(
        inlet_width=nozzle.inlet_width / width,
        inlet_length=nozzle.inlet_length / width,
        taper_length=nozzle.taper_length / width,
        capillary_width=1.0,
        capillary_length=nozzle.capillary_length / width,
        gap=nozzle.gap / width,
        outlet=nozzle.outlet / width,
    )


class _Outline:
    """Collects points and lines of the geometry; every line knows what lies on its left."""

    def __init__(self, bulk_edge: float) -> None:
        self.geometry = SplineGeometry()
        self.bulk_edge = bulk_edge

    def point(self, xy: tuple[float, float] | Array, edge: float | None = None) -> int:
        edge = self.bulk_edge if edge is None else edge
        return int(self.geometry.AppendPoint(float(xy[0]), float(xy[1]), maxh=edge))

    def path(self, points: list[int], name: str, left: int, right: int = 0) -> None:
        for first, last in pairwise(points):
            self.geometry.Append(
                ["line", first, last],
                leftdomain=left,
                rightdomain=right,
                bc=name,
                maxh=self.bulk_edge * (NOZZLE_COARSENING if left == 1 else 1.0),
            )


def deposition_mesh(nozzle: Nozzle, surfaces: Surfaces, numerics: FlowNumerics) -> ng.Mesh:
    """Return the mesh of ``nozzle`` (scaled) and the bead between ``surfaces``.

    Regions are ``nozzle`` and ``bead``; boundaries ``inlet``, ``wall``, ``upstream``,
    ``downstream``, ``bed``, ``outlet`` and, between the regions, ``exit``.

    Raises
    ------
    MeshError
        If the outline cannot be meshed, or the edges at the lips are not as short as asked for.
    """
    for shrinkage in SHRINKAGES:
        try:
            mesh = ng.Mesh(
                _outline(nozzle, surfaces, numerics.coarsened(shrinkage)).GenerateMesh(
                    maxh=NOZZLE_COARSENING * numerics.bulk_edge, grading=0.3, giveuptol2d=GIVE_UP
                )
            )
        except NgException:
            continue
        _check_lip_edges(mesh, nozzle.gap, numerics.lip_edge)
        return mesh
    up = surfaces.upstream
    msg = (
        "the free surfaces found so far cannot be meshed (they cross or fold): "
        f"contact at {up[-1, 0]:.3f}, heel at {up[:, 0].min():.3f} capillary widths; "
        "try another numerics.edge_growth or numerics.surface_edge"
    )
    raise MeshError(msg)


def _outline(nozzle: Nozzle, surfaces: Surfaces, numerics: FlowNumerics) -> SplineGeometry:
    """Return the geometry: two regions, named boundaries, points where edges must end."""
    outline = _Outline(numerics.bulk_edge)
    grade = (numerics.surface_edge, numerics.edge_growth, numerics.lip_edge)
    up = resample(surfaces.upstream, *grade, numerics.contact_edge)
    down = resample(surfaces.downstream, *grade, None)

    left_lip = outline.point((-0.5, nozzle.gap), numerics.lip_edge)
    right_lip = outline.point((0.5, nozzle.gap), numerics.lip_edge)
    contact = outline.point(up[-1], numerics.contact_edge)
    bed_end = outline.point((nozzle.outlet, 0.0))
    bead_top = outline.point(down[-1])
    top, half = nozzle.inlet_height, nozzle.inlet_width / 2
    shoulder = top - nozzle.inlet_length
    right = [
        right_lip,
        outline.point((0.5, nozzle.capillary_entrance), numerics.corner_edge),
        outline.point((half, shoulder)),
        outline.point((half, top)),
    ]
    left = [
        outline.point((-half, top)),
        outline.point((-half, shoulder)),
        outline.point((-0.5, nozzle.capillary_entrance), numerics.corner_edge),
        left_lip,
    ]
    outline.path([contact, bed_end], "bed", left=2)
    outline.path([bed_end, bead_top], "outlet", left=2)
    inner = [outline.point(q) for q in down[-2:0:-1]]
    outline.path([bead_top, *inner, right_lip], "downstream", left=2)
    outline.path(right, "wall", left=1)
    outline.path([right[-1], left[0]], "inlet", left=1)
    outline.path(left, "wall", left=1)
    outline.path([left_lip, *(outline.point(q) for q in up[1:-1]), contact], "upstream", left=2)
    outline.path([left_lip, right_lip], "exit", left=1, right=2)
    outline.geometry.SetMaterial(1, "nozzle")
    outline.geometry.SetMaterial(2, "bead")
    return outline.geometry


def _check_lip_edges(mesh: ng.Mesh, gap: float, asked: float) -> None:
    """Raise if a free surface's first edge came out much longer than asked for."""
    points = np.array([vertex.point for vertex in mesh.vertices])
    for name, x in (("upstream", -0.5), ("downstream", 0.5)):
        ends = np.array([[v.nr for v in e.vertices] for e in mesh.Boundaries(name).Elements()])
        at_lip = np.hypot(*np.moveaxis(points[ends] - (x, gap), -1, 0)).min(axis=1) < AT_LIP
        edges = np.hypot(*(points[ends[at_lip, 0]] - points[ends[at_lip, 1]]).T)
        if edges.size != 1 or edges[0] > LARGEST_OVERSHOOT * asked:
            msg = (
                f"the {name} lip's mesh edge came out as {edges} capillary widths where "
                f"lip_edge = {asked:g} was asked for: choose a smaller growth"
            )
            raise MeshError(msg)
