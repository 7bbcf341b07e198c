"""The mesh of a strand: a half disc of triangles times layers, prisms cut into tetrahedra.

A strand with a plane of symmetry is a half tube. Its mesh is that of a straight one of radius one,
whose nodes a map then places: there is no geometry to intersect, and nothing that can fail to mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import netgen.meshing as nm
import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import MeshError
from fibermelt.flow.spacing import graded_spacing

__all__ = ["Tube", "TubeMap", "tube_mesh"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

TubeMap = Callable[[Array, Array], Array]
"""From the way along the strand (n,) and the place in the disc (n, 2) to space (n, 3)."""

NAMES = ("inlet", "wall", "free", "outlet", "symmetry")
"""Boundaries in the order of their numbers."""


@dataclass(frozen=True, eq=False)
class Tube:
    """How finely a strand is cut.

    Parameters
    ----------
    layers : (n,) array
        Stations along the strand, in its own measure; below zero it lies in the nozzle, and zero,
        the lip, is one of them.
    rings : (m,) array
        Radii from the axis (0) to the rim (1).
    sectors : int
        Sectors of the half disc at its rim, a multiple of four; towards the axis there are fewer.
    """

    layers: Array
    rings: Array
    sectors: int

    @classmethod
    def graded(
        cls,
        stations: tuple[float, float],
        lip_edge: float,
        bulk_edge: float,
        sectors: int,
        growth: float,
    ) -> Tube:
        """Return a tube whose edges grow away from the lip, along the strand and towards its axis.

        Parameters
        ----------
        stations : (float, float)
            Of the inlet (below zero) and the outlet.
        lip_edge, bulk_edge : float
            Edges at the lip and away from it, in radii.
        sectors : int
            As above.
        growth : float
            Added length per distance.
        """
        up, down = (graded_spacing(abs(end), bulk_edge, growth, start=lip_edge) for end in stations)
        inwards = graded_spacing(1.0, bulk_edge, growth, start=lip_edge)
        return cls(np.r_[-up[:0:-1], down], 1.0 - inwards[::-1], sectors)


def _disc(rings: Array, sectors: int) -> tuple[Array, Index]:
    """Return points (n, 2) and triangles (k, 3) of the upper half of a disc of radius one.

    A ring has half the sectors of the one around it where its edges would be shorter than the
    distance to that by more than a half.
    """
    counts = [sectors]
    for inner, outer in zip(rings[-2::-1], rings[:0:-1], strict=True):
        halved = counts[-1] % 2 == 0 and counts[-1] > 4
        is_narrow = np.pi * inner / counts[-1] < (outer - inner) / 1.5
        counts.append(counts[-1] // 2 if halved and is_narrow else counts[-1])
    counts = counts[::-1]
    points, starts = [np.zeros((1, 2))], [0]
    for radius, count in zip(rings[1:], counts[1:], strict=True):
        angle = np.linspace(0.0, np.pi, count + 1)
        starts.append(starts[-1] + len(points[-1]))
        points.append(radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    fan = np.arange(counts[1])
    triangles = [np.column_stack([0 * fan, 1 + fan, 2 + fan])]
    for k in range(1, len(rings) - 1):
        inner, outer, few, many = starts[k], starts[k + 1], counts[k], counts[k + 1]
        i = np.arange(few)
        a, b = inner + i, inner + i + 1
        if few == many:
            c, d = outer + i, outer + i + 1
            # diagonals lean one way left of the middle, the other way right of it
            left = i < few // 2
            first = np.where(left[:, None], np.column_stack([a, c, d]), np.column_stack([a, c, b]))
            last = np.where(left[:, None], np.column_stack([a, d, b]), np.column_stack([b, c, d]))
            triangles += [first, last]
        else:
            c, d, e = outer + 2 * i, outer + 2 * i + 1, outer + 2 * i + 2
            for three in ((a, c, d), (a, d, b), (b, d, e)):
                triangles.append(np.column_stack(three))
    return np.vstack(points), np.vstack(triangles)


def _tetrahedra(triangles: Index, layers: int, count: int) -> Index:
    """Return tetrahedra of all prisms; diagonals go from the lower vertex to the higher one."""
    base = np.sort(triangles, axis=1)
    a = (base[None] + count * np.arange(layers - 1)[:, None, None]).reshape(-1, 3)
    b = a + count
    return np.vstack(
        [
            np.column_stack([a[:, 0], a[:, 1], a[:, 2], b[:, 2]]),
            np.column_stack([a[:, 0], a[:, 1], b[:, 1], b[:, 2]]),
            np.column_stack([a[:, 0], b[:, 0], b[:, 1], b[:, 2]]),
        ]
    )


def _outer_faces(cells: Index) -> tuple[Index, Index]:
    """Return the faces (n, 3) that belong to one cell, and the cell's vertex (n,) across."""
    corners = np.array([[1, 2, 3, 0], [0, 2, 3, 1], [0, 1, 3, 2], [0, 1, 2, 3]])
    faces = cells[:, corners].reshape(-1, 4)
    _, first, count = np.unique(
        np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = faces[first[count == 1]]
    return outer[:, :3], outer[:, 3]


def _volumes(points: Array, cells: Index) -> Array:
    """Return six times the signed volumes of tetrahedra."""
    origin, *ends = (points[cells[:, k]] for k in range(4))
    return np.asarray(np.linalg.det(np.stack([end - origin for end in ends], axis=1)))


def tube_mesh(tube: Tube, place: TubeMap) -> tuple[ng.Mesh, Array]:
    """Return the mesh of a strand, and where the middles of its edges lie.

    Regions are ``nozzle`` and ``strand``, boundaries ``inlet``, ``wall``, ``free``, ``outlet`` and
    ``symmetry``. Elements have straight edges.

    Parameters
    ----------
    tube : Tube
        Its layers and its half disc.
    place : TubeMap
        Where its nodes lie; one to one.

    Returns
    -------
    mesh : ng.Mesh
        The mesh.
    middles : (n_edges, 3) array
        How far the middles of the edges on ``wall`` and ``free`` are from their chord's, by the
        mesh's number of the edge; zero for others.

    Raises
    ------
    MeshError
        If the map folds an element.
    """
    disc, triangles = _disc(tube.rings, tube.sectors)
    count, layers = len(disc), len(tube.layers)
    along = np.repeat(tube.layers, count)
    across = np.tile(disc, (layers, 1))
    points = place(along, across)
    cells = _tetrahedra(triangles, layers, count)
    in_nozzle = along[cells].max(axis=1) <= 0.0
    straight = np.column_stack([along, across])
    cells = np.where((_volumes(straight, cells) > 0.0)[:, None], cells, cells[:, [1, 0, 2, 3]])
    folded = int((_volumes(points, cells) <= 0.0).sum())
    if folded:
        msg = (
            f"bead in space: the first guess of the strand folds {folded} of {len(cells)} "
            "elements: raise flow.gap or flow.outlet"
        )
        raise MeshError(msg)
    netgen = nm.Mesh(dim=3)
    for number, name in enumerate(NAMES, 1):
        netgen.Add(nm.FaceDescriptor(surfnr=number, domin=1, domout=0, bc=number))
        netgen.SetBCName(number - 1, name)
    netgen.AddPoints(np.ascontiguousarray(points))
    netgen.SetMaterial(1, "nozzle")
    netgen.SetMaterial(2, "strand")
    for material, chosen in ((1, in_nozzle), (2, ~in_nozzle)):
        data = np.ascontiguousarray(cells[chosen], dtype=np.int32)
        netgen.AddElements(dim=3, index=material, data=data, base=0)
    faces, across_from = _outer_faces(cells)
    outward = _volumes(points, np.column_stack([faces, across_from])) < 0.0
    faces = np.where(outward[:, None], faces, faces[:, [1, 0, 2]])
    kind = _boundary(tube, along[faces], across[faces])
    for number in range(1, len(NAMES) + 1):
        data = np.ascontiguousarray(faces[kind == number], dtype=np.int32)
        netgen.AddElements(dim=2, index=number, data=data, base=0)
    mesh = ng.Mesh(netgen)
    return mesh, _middles(mesh, along, across, points, place)


def _boundary(tube: Tube, along: Array, across: Array) -> Index:
    """Return the numbers of boundaries of faces, from where their corners lie (n, 3[, 2])."""
    on_rim = np.all(np.hypot(*np.moveaxis(across, -1, 0)) > 1.0 - 1e-9, axis=1)
    above = np.all(along <= 0.0, axis=1)
    kinds = [
        np.all(along == tube.layers[0], axis=1),
        on_rim & above,
        on_rim,
        np.all(along == tube.layers[-1], axis=1),
    ]
    return np.select(kinds, [1, 2, 3, 4], default=5)


def _middles(mesh: ng.Mesh, along: Array, across: Array, points: Array, place: TubeMap) -> Array:
    """Return how far the middles of edges on curved boundaries are from their chord's."""
    numbers = sorted(
        {edge.nr for face in mesh.Boundaries("wall|free").Elements() for edge in face.edges}
    )
    ends = np.array(
        [[v.nr for v in mesh[ng.NodeId(ng.EDGE, number)].vertices] for number in numbers]
    )
    angle = np.arctan2(across[ends, 1], across[ends, 0]).mean(axis=1)
    middle = place(along[ends].mean(axis=1), np.column_stack([np.cos(angle), np.sin(angle)]))
    found = np.zeros((mesh.nedge, 3))
    found[numbers] = middle - points[ends].mean(axis=1)
    return found
