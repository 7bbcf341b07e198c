"""Triangles and tetrahedra as arrays of node numbers: sizes, facets, neighbours, boundary."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

__all__ = [
    "Facets",
    "adjacency",
    "boundary_nodes",
    "facets",
    "ridges",
    "sharp_nodes",
    "signed_sizes",
    "used_only",
]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SHARP = np.radians(30.0)
"""Turn of the boundary at an edge that points into the flow, above which it counts as sharp: a
round wall is drawn with more than twelve facets around."""


AROUND = 0.999
"""Part of the full angle from which on the cells at a node go all around it: a flat wall has half,
slivers that were taken out leave no gap."""


@dataclass(frozen=True, eq=False)
class Facets:
    """The facets of simplices: edges of triangles, faces of tetrahedra.

    Parameters
    ----------
    neighbour : (m, k) int array
        The cell across the facet opposite to each corner, -1 on the boundary.
    boundary : (b, k - 1) int array
        Nodes of the facets that belong to one cell.
    inside : (b,) int array
        The node of that cell opposite to the facet.
    """

    neighbour: Index
    boundary: Index
    inside: Index


def _keys(nodes: Index, count: int) -> Index:
    """Return one number for each row of sorted node numbers, the same for the same rows."""
    key, most = nodes[:, 0].astype(np.int64), count
    for column in nodes.T[1:]:
        if most * count >= 2**63:
            key = np.unique(key, return_inverse=True)[1].reshape(-1)
            most = int(key.max(initial=0)) + 1
        key, most = key * count + column, most * count
    return np.asarray(key)


def facets(cells: Index, *, over_slivers: bool = True) -> Facets:
    """Return how cells (m, k), triangles or tetrahedra, lie together.

    Around a sliver that was taken out they do not meet at whole facets, and yet there is no
    boundary: each of its facets leads to the cell behind the next one, which is across it after
    three at most. Unless ``over_slivers``, these facets count as boundary.
    """
    m, k = cells.shape
    count = int(cells.max(initial=0)) + 1
    corners = [[j for j in range(k) if j != i] for i in range(k)]
    opposite = cells[:, corners].reshape(-1, k - 1)
    key = _keys(np.sort(opposite, axis=1), count)
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    neighbour = np.full(m * k, -1, dtype=np.int64)
    first, second = order[same], order[same + 1]
    neighbour[first], neighbour[second] = second // k, first // k
    if over_slivers:
        alone = np.flatnonzero(neighbour < 0)
        around = alone[_holes(opposite[alone], count)]
        around = around[np.ptp(around // k, axis=1) > 0]  # not around a cell that is all there is
        neighbour[around] = np.roll(around, 1, axis=1) // k
    outer = neighbour < 0
    return Facets(neighbour.reshape(m, k), opposite[outer], cells.reshape(-1)[outer])


def _holes(boundary: Index, count: int) -> Index:
    """Return the facets (h, k) around each hole in the shape of a single cell, by their numbers.

    Of ``boundary`` (b, k - 1) on so many nodes; a hole's facets are all those between its k nodes.
    """
    width = boundary.shape[1]
    boundary = np.sort(boundary, axis=1)
    rest = [[j for j in range(width) if j != i] for i in range(width)]
    key = _keys(boundary[:, rest].reshape(-1, width - 1), count)
    order = np.argsort(key, kind="stable")
    pairs, lag = [np.empty((0, 2), dtype=np.int64)], 1
    while True:
        same = np.flatnonzero(key[order[lag:]] == key[order[:-lag]])
        if not same.size:
            break
        pairs.append(np.stack([order[same], order[same + lag]], axis=1))
        lag += 1
    pair = np.concatenate(pairs)
    # of two facets that share all nodes but one: those of the first, and the second's own
    facet, place = pair // width, pair % width
    own = boundary[facet[:, 1], place[:, 1]]
    nodes = np.sort(np.column_stack([boundary[facet[:, 0]], own]), axis=1)
    key = _keys(nodes, count)
    order = np.argsort(key, kind="stable")
    start = np.flatnonzero(np.diff(key[order], prepend=-1))
    number = np.diff(np.append(start, len(order)))
    many = width * (width + 1) // 2
    whole = start[number == many]
    among = order[whole[:, None] + np.arange(many)]
    found = np.sort(facet[among].reshape(len(whole), 2 * many), axis=1)
    return found[:, ::width]  # each facet is in one pair with each of the others


def signed_sizes(points: Array, cells: Index) -> Array:
    """Return areas or volumes of cells (m, k) on points (n, k - 1); negative if turned over."""
    sides = points[cells[:, 1:]] - points[cells[:, :1]]
    if cells.shape[1] == 3:
        a, b = sides[:, 0], sides[:, 1]
        return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2.0
    cross = np.cross(sides[:, 0], sides[:, 1])
    return np.asarray(np.einsum("ni,ni->n", cross, sides[:, 2])) / 6.0


def adjacency(cells: Index, count: int) -> csr_array:
    """Return which of so many nodes share a cell, each with itself, as a sparse pattern."""
    k = cells.shape[1]
    pairs = [(i, j) for i in range(k) for j in range(k) if i != j]
    rows = np.concatenate([cells[:, i] for i, _ in pairs] + [np.arange(count)])
    columns = np.concatenate([cells[:, j] for _, j in pairs] + [np.arange(count)])
    pattern = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), (count, count))
    return pattern.tocsr()


def boundary_nodes(points: Array, cells: Index, found: Facets) -> NDArray[np.bool_]:
    """Return which nodes lie on the boundary: on a facet of one cell, not surrounded by cells.

    Facets alone are not enough where cells do not meet at whole ones (hanging nodes, slivers that
    were taken out): the angles of the cells at a node tell whether they go all around.
    """
    is_open = np.zeros(len(points), dtype=bool)
    is_open[found.boundary] = True
    if not is_open.any():
        return is_open
    touched = cells[is_open[cells].any(axis=1)]
    corners = points[touched]
    full = 2 * np.pi if cells.shape[1] == 3 else 4 * np.pi
    angle = np.zeros(len(points))
    for corner in range(cells.shape[1]):
        others = [k for k in range(cells.shape[1]) if k != corner]
        sides = corners[:, others] - corners[:, corner, None]
        sides = sides / np.linalg.norm(sides, axis=2, keepdims=True)
        angle += np.bincount(touched[:, corner], _angle(sides), minlength=len(points))
    return is_open & (angle < AROUND * full)


def _angle(sides: Array) -> Array:
    """Return the angles between unit vectors (n, 2, 2), or the solid angles of (n, 3, 3).

    Reference: Van Oosterom and Strackee 1983, IEEE Trans. Biomed. Eng. 30, 125
    (doi:10.1109/TBME.1983.325207).
    """
    if sides.shape[1] == 2:
        return np.asarray(np.arccos(np.clip(np.einsum("nd,nd->n", *sides.swapaxes(0, 1)), -1, 1)))
    a, b, c = sides.swapaxes(0, 1)
    triple = np.abs(np.einsum("nd,nd->n", a, np.cross(b, c)))
    products = [np.einsum("nd,nd->n", *pair) for pair in ((a, b), (b, c), (c, a))]
    return np.asarray(2 * np.arctan2(triple, 1.0 + sum(products)))


def used_only(cells: Index, count: int) -> tuple[Index, Index]:
    """Return cells numbered anew without the nodes that none has, and the nodes kept."""
    is_used = np.zeros(count, dtype=bool)
    is_used[cells] = True
    kept = np.flatnonzero(is_used)
    number = np.full(count, -1, dtype=np.int64)
    number[kept] = np.arange(len(kept))
    return number[cells], kept


def ridges(points: Array, found: Facets) -> tuple[Index, Array, Array]:
    """Return where two facets of the boundary meet, and how it turns there.

    Returns
    -------
    nodes : (r, k - 2) int array
        Edges between faces; single nodes between the edges of a plane.
    turn : (r,) array
        Cosine between the outward normals.
    ahead : (r,) array
        Above zero where the boundary turns into the flow.
    """
    boundary = found.boundary
    spatial = boundary.shape[1] == 3
    sides = points[boundary[:, 1:]] - points[boundary[:, :1]]
    if spatial:
        normal = np.cross(sides[:, 0], sides[:, 1])
        edges = boundary[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    else:
        normal = np.column_stack([sides[:, 0, 1], -sides[:, 0, 0]])
        edges = boundary.reshape(-1, 1)
    inward = points[found.inside] - points[boundary[:, 0]]
    outward = np.where(np.einsum("ni,ni->n", normal, inward) > 0, -1.0, 1.0)
    normal = normal * (outward / np.linalg.norm(normal, axis=1))[:, None]
    centre = points[boundary].mean(axis=1)
    key = _keys(np.sort(edges, axis=1), len(points))
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    per_facet = edges.shape[0] // max(len(boundary), 1)
    first, second = order[same] // per_facet, order[same + 1] // per_facet
    turn = np.einsum("ni,ni->n", normal[first], normal[second])
    ahead = np.einsum("ni,ni->n", normal[first], centre[second] - centre[first])
    return edges[order[same]], np.asarray(turn), np.asarray(ahead)


def sharp_nodes(points: Array, found: Facets) -> Index:
    """Return the boundary nodes at which a sharp edge points into the flow.

    There the velocity gradient of a viscous flow is singular (a lip, a step, an insert).
    """
    nodes, turn, ahead = ridges(points, found)
    return np.unique(nodes[(turn < np.cos(SHARP)) & (ahead > 0)])
