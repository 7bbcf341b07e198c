"""Points without cells: joined anew, where the points themselves leave no gap.

Delaunay's triangulation fills the convex hull. A cell with an edge much longer than those usual at
its corners bridges a gap (the air beside a nozzle, a hole) and is taken out, as are slivers. What
walls the points do not show, such as a slit narrower than their distance, is bridged.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from fibermelt.errors import ConfigError
from fibermelt.fields.simplices import signed_sizes

__all__ = ["joined"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LONGEST = 2.2
"""Longest edge of a cell over the edges usual at its corners: the diagonal of a cube is 1.7, a
grading of a third from cell to cell adds to it."""

SLIVER = 1e-4
"""Area or volume over the longest edge to its power, below which a cell is a sliver: four points of
a cube's face that rounding joined; 0.118 is a regular tetrahedron's."""

PASSES = 3
"""Rounds of taking out: the edges that bridged a gap no longer count as usual at their ends."""


def joined(points: Array) -> tuple[Index, str]:
    """Return cells (m, d + 1) between points (n, d), and a sentence on them.

    Raises
    ------
    ConfigError
        If the points span no area or volume.
    """
    d = points.shape[1]
    scale = points.max(axis=0) - points.min(axis=0)
    try:
        cells = Delaunay((points - points.min(axis=0)) / scale.max()).simplices.astype(np.int64)
    except (QhullError, ValueError, ZeroDivisionError) as error:
        msg = (
            f"field.file: {len(points)} points in {d} dimensions span no "
            f"{'area' if d == 2 else 'volume'}: export the flow's domain, not a line or a boundary"
        )
        raise ConfigError(msg) from error
    whole = len(cells)
    edges = _edge_lengths(points, cells)
    longest = edges.max(axis=1)
    keep = np.abs(signed_sizes(points, cells)) > SLIVER * longest**d
    for _ in range(PASSES):
        usual = _usual(cells[keep], edges[keep], len(points))
        at_corners = np.median(usual[cells], axis=1)
        new = keep & (longest <= LONGEST * at_corners)
        if np.array_equal(new, keep):
            break
        keep = new
    removed = whole - int(keep.sum())
    note = (
        f"the file has points only: joined to {int(keep.sum())} cells; {removed} that bridged gaps "
        "or had no width were taken out; a wall thinner than the distance of points is not seen"
    )
    return cells[keep], note


def _pairs(d: int) -> list[tuple[int, int]]:
    return [(i, j) for i in range(d + 1) for j in range(i)]


def _edge_lengths(points: Array, cells: Index) -> Array:
    """Return the lengths of all edges of each cell (m, 3 or 6)."""
    pairs = _pairs(cells.shape[1] - 1)
    return np.column_stack(
        [np.linalg.norm(points[cells[:, i]] - points[cells[:, j]], axis=1) for i, j in pairs]
    )


def _usual(cells: Index, edges: Array, count: int) -> Array:
    """Return the median length of the edges at each node, zero where it has none."""
    pairs = _pairs(cells.shape[1] - 1)
    node = np.concatenate([cells[:, end] for pair in pairs for end in pair])
    length = np.repeat(edges, 2, axis=1).T.reshape(-1)
    order = np.lexsort((length, node))
    node, length = node[order], length[order]
    start = np.searchsorted(node, np.arange(count))
    number = np.bincount(node, minlength=count)
    usual = np.zeros(count)
    some = number > 0
    usual[some] = length[start[some] + number[some] // 2]
    return usual
