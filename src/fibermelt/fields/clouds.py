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

JITTER = 1e-9
"""Parts of the extent by which points are moved before they are joined: of a grid any cube's
corners lie on one sphere, and to settle that takes twice the time. A layer at a wall has 1e-6."""

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
    low = points.min(axis=0)
    scale = points.max(axis=0) - low
    # of points in one place the first
    place, first = np.unique(points, axis=0, return_index=True)
    moved = JITTER * np.random.default_rng(0).uniform(-1.0, 1.0, place.shape)
    nothing = (
        f"field.file: {len(points)} points in {d} dimensions span no "
        f"{'area' if d == 2 else 'volume'}: export the flow's domain, not a line or a boundary"
    )
    try:
        cells = first[Delaunay((place - low) / scale.max() + moved).simplices].astype(np.int64)
    except (QhullError, ValueError, ZeroDivisionError) as error:
        raise ConfigError(nothing) from error
    whole = len(cells)
    edges = _edge_lengths(points, cells)
    longest = edges.max(axis=1)
    keep = np.abs(signed_sizes(points, cells)) > SLIVER * longest**d
    if not keep.any():
        raise ConfigError(nothing)
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
    most = 2.0 * float(length.max(initial=0.0))
    # one number to sort by: a node's, and of its edges the length
    key = np.sort(node + length / most)
    number = np.bincount(node, minlength=count)
    some = np.flatnonzero(number)
    start = np.searchsorted(key, some)
    usual = np.zeros(count)
    usual[some] = most * (key[start + number[some] // 2] - some)
    return usual
