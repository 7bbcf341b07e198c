"""Cells of any kind into triangles and tetrahedra that meet at whole facets.

A cell is cut into the simplices from its lowest-numbered node to the faces without it, a face into
the triangles from its own lowest-numbered node: two cells cut the face between them the same way.
Reference: Dompierre et al. 1999, How to subdivide pyramids, prisms and hexahedra into tetrahedra,
8th International Meshing Roundtable.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.lagrange import LagrangeTriangle

__all__ = ["CORNERS", "split_cells", "split_polygons", "split_polyhedra"]

Index = NDArray[np.int64]

TETRA, VOXEL, HEXAHEDRON, WEDGE, PYRAMID = 10, 11, 12, 13, 14
TRIANGLE, POLYGON, PIXEL, QUAD = 5, 7, 8, 9
QUADRATIC_TRIANGLE, QUADRATIC_QUAD, QUADRATIC_TETRA = 22, 23, 24
BIQUADRATIC_QUAD, TRIQUADRATIC_HEXAHEDRON = 28, 29
LAGRANGE_TRIANGLE, LAGRANGE_QUAD, LAGRANGE_TETRA = 69, 70, 71

FACES: dict[int, tuple[tuple[int, ...], ...]] = {
    HEXAHEDRON: (
        (0, 4, 7, 3),
        (1, 2, 6, 5),
        (0, 1, 5, 4),
        (3, 7, 6, 2),
        (0, 3, 2, 1),
        (4, 5, 6, 7),
    ),
    WEDGE: ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    PYRAMID: ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}

TETRA_PARTS = (
    *((0, 4, 6, 7), (4, 1, 5, 8), (6, 5, 2, 9), (7, 8, 9, 3)),
    *((6, 8, 4, 5), (6, 8, 5, 9), (6, 8, 9, 7), (6, 8, 7, 4)),
)
"""Of a tetrahedron with nodes on its edges 01, 12, 20, 03, 13, 23: corners, and the octahedron
between them about one of its diagonals."""

QUAD_PARTS = ((0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3))
"""Of a quadrilateral with nodes on its edges 01, 12, 23, 30 and in its middle."""

CORNERS = {
    25: HEXAHEDRON,
    33: HEXAHEDRON,
    72: HEXAHEDRON,
    26: WEDGE,
    32: WEDGE,
    31: WEDGE,
    73: WEDGE,
    27: PYRAMID,
    37: PYRAMID,
    74: PYRAMID,
    LAGRANGE_QUAD: QUAD,
    LAGRANGE_TETRA: TETRA,
}
"""Cells of higher order of which the corners are read, and what they are then."""

COUNT = {HEXAHEDRON: 8, WEDGE: 6, PYRAMID: 5, QUAD: 4, TETRA: 4}

# x, y, z of the 27 nodes: corners, edges, faces -x +x -y +y -z +z, middle
_CUBE = np.array(
    [
        *((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)),
        *((1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2)),
        *((0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)),
        *((0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)),
    ]
)


def _cube_parts() -> Index:
    """Return the eight small hexahedra (8, 8) of one with 27 nodes."""
    number = {tuple(place): k for k, place in enumerate(_CUBE.tolist())}
    corner = _CUBE[:8] // 2
    shifts = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    parts = [[number[tuple((c + shift).tolist())] for c in corner] for shift in np.array(shifts)]
    return np.array(parts)


def _fans(corners: Index) -> Index:
    """Return the triangles of polygons (m, k), k - 2 each, from each one's lowest node."""
    k = corners.shape[1]
    turn = (corners.argmin(axis=1)[:, None] + np.arange(k)) % k
    ring = np.take_along_axis(corners, turn, axis=1)
    parts = np.array([(0, i, i + 1) for i in range(1, k - 1)])
    return ring[:, parts].reshape(-1, 3)


def _cones(nodes: Index, faces: Sequence[tuple[int, ...]]) -> Index:
    """Return the tetrahedra of cells (m, k) with these faces, from each one's lowest node."""
    lowest = nodes.argmin(axis=1)
    found = []
    for place in range(nodes.shape[1]):
        members = nodes[lowest == place]
        for face in faces:
            if place in face or not len(members):
                continue
            triangles = _fans(members[:, face])
            apex = np.repeat(members[:, place], len(face) - 2)
            found.append(np.column_stack([apex, triangles]))
    return np.concatenate(found) if found else np.empty((0, 4), dtype=np.int64)


def _whole(simplices: Index) -> Index:
    """Return simplices without those that name a node twice: parts of cells that are collapsed."""
    ordered = np.sort(simplices, axis=1)
    return simplices[np.all(ordered[:, 1:] != ordered[:, :-1], axis=1)]


def split_polygons(polygons: Sequence[Index]) -> Index:
    """Return the triangles (m, 3) of polygons, each the numbers of its nodes."""
    sizes = np.array([len(polygon) for polygon in polygons])
    found = [np.empty((0, 3), dtype=np.int64)]
    for size in np.unique(sizes[sizes > 2]):
        rows = np.flatnonzero(sizes == size)
        found.append(_fans(np.array([polygons[int(row)] for row in rows])))
    return _whole(np.concatenate(found))


def split_polyhedra(connectivity: Index, ends: Index, cell: Index) -> Index:
    """Return the tetrahedra of polyhedra, given by their faces.

    Parameters
    ----------
    connectivity, ends : int arrays
        Nodes of all faces one after another, and where each face ends, a zero first.
    cell : (f,) int array
        The polyhedron of each face.
    """
    sizes = np.diff(ends)
    lowest = np.full(int(cell.max(initial=-1)) + 1, np.iinfo(np.int64).max)
    np.minimum.at(lowest, np.repeat(cell, sizes), connectivity)
    found = [np.empty((0, 4), dtype=np.int64)]
    for size in np.unique(sizes[sizes > 2]):
        rows = np.flatnonzero(sizes == size)
        corners = connectivity[ends[rows][:, None] + np.arange(size)]
        apex = lowest[cell[rows]]
        away = np.all(corners != apex[:, None], axis=1)
        triangles = _fans(corners[away])
        found.append(np.column_stack([np.repeat(apex[away], size - 2), triangles]))
    return _whole(np.concatenate(found))


def split_cells(kind: int, nodes: Index) -> Index | None:
    """Return the simplices of cells of one of VTK's types, None if it has none that are read.

    Parameters
    ----------
    kind : int
        VTK's number of the type.
    nodes : (m, k) int array
        Nodes of each cell, in VTK's order.
    """
    count = nodes.shape[1]
    kind = {(LAGRANGE_TETRA, 10): QUADRATIC_TETRA, (LAGRANGE_QUAD, 9): BIQUADRATIC_QUAD}.get(
        (kind, count), kind
    )
    if kind in CORNERS:
        kind = CORNERS[kind]
        nodes = nodes[:, : COUNT[kind]]
    if kind in {QUADRATIC_TRIANGLE, LAGRANGE_TRIANGLE}:
        order = 2 if kind == QUADRATIC_TRIANGLE else round((np.sqrt(8 * count + 1) - 3) / 2)
        return _whole(nodes[:, LagrangeTriangle(order).split()].reshape(-1, 3))
    parts = _PARTS.get(kind)
    return None if parts is None else _whole(parts(nodes))


def _quadratic_quads(nodes: Index) -> Index:
    """Return the triangles of quadrilaterals with nodes on their edges: corners, and the middle."""
    corners = nodes[:, [[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7]]].reshape(-1, 3)
    return np.concatenate([corners, _fans(nodes[:, [4, 5, 6, 7]])])


_PARTS: dict[int, Callable[[Index], Index]] = {
    TRIANGLE: lambda nodes: nodes,
    TETRA: lambda nodes: nodes,
    POLYGON: _fans,
    QUAD: _fans,
    PIXEL: lambda nodes: _fans(nodes[:, [0, 1, 3, 2]]),
    QUADRATIC_QUAD: _quadratic_quads,
    BIQUADRATIC_QUAD: lambda nodes: _fans(nodes[:, QUAD_PARTS].reshape(-1, 4)),
    QUADRATIC_TETRA: lambda nodes: nodes[:, TETRA_PARTS].reshape(-1, 4),
    PYRAMID: lambda nodes: _cones(nodes, FACES[PYRAMID]),
    WEDGE: lambda nodes: _cones(nodes, FACES[WEDGE]),
    HEXAHEDRON: lambda nodes: _cones(nodes, FACES[HEXAHEDRON]),
    VOXEL: lambda nodes: _cones(nodes[:, [0, 1, 3, 2, 4, 5, 7, 6]], FACES[HEXAHEDRON]),
    TRIQUADRATIC_HEXAHEDRON: lambda nodes: _cones(
        nodes[:, _cube_parts()].reshape(-1, 8), FACES[HEXAHEDRON]
    ),
}
"""How cells of each type are cut."""
