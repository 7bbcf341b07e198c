"""From the cells of a finite-volume solver to the nodes between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from fibermelt.fields.patches import own_axes, padded

__all__ = ["cells_to_nodes"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FARTHEST = 36.0
"""Square of a node's distance from the middle of its cells, in their own width, up to which a plane
is led on to it: 12 in the corner of a box of two layers of bricks, 17 of tetrahedra. Beyond, the
cells lie in one layer and say nothing of the slope across."""

LEVEL = 1e-5
"""Parts of the longest extent of all cells' centres below which they lie in one layer, or one row:
coordinates may have four bytes."""

ROWS = 10_000
"""Nodes looked at together."""


def cells_to_nodes(points: Array, centres: Array, member: csr_array) -> csr_array:
    """Return the matrix (n, m) that takes values at cell centres to the nodes.

    Parameters
    ----------
    points : (n, d) array
        Nodes.
    centres : (m, d) array
        Centres of the cells.
    member : (n, m) sparse pattern
        Which node belongs to which cell; each has one at least.

    Notes
    -----
    A plane is fitted through the cells at the node, and evaluated there: linear fields are
    reproduced up to the boundary, where the cells next to those at the node help. In coordinates
    with the patch's mean as origin and its covariance the identity, the weights of K cells at
    ``y_k`` for a node at ``y`` are ``(1 + y . y_k) / K``. Of cells in one layer, as OpenFOAM has
    planar and axisymmetric flows, the plane is one in the layer.
    """
    within = _span(centres)
    points, centres = points @ within, centres @ within
    count = len(points)
    rows, columns, weights = [], [], []
    left = np.arange(count)
    joined: csr_array | None = None
    for is_last in (False, True):
        if is_last and left.size:
            joined = member @ member.T
        failed = []
        for part in np.array_split(left, max(1, -(-len(left) // ROWS))):
            if not part.size:
                continue
            pattern = member[part] if joined is None else joined[part] @ member
            around, is_own = padded(pattern, np.zeros(len(part), dtype=np.int64))
            number = is_own.sum(axis=1)
            mean = np.einsum("bkd,bk->bd", centres[around], is_own) / number[:, None]
            away = (centres[around] - mean[:, None]) * is_own[..., None]
            size = np.einsum("bkd,bkd->b", away, away)
            good = size > 0
            weight = np.where(is_own, 1.0 / number[:, None], 0.0)
            axes = own_axes(away[good], number[good])
            y = np.einsum("bij,bkj->bki", axes, away[good])
            node = np.einsum("bij,bj->bi", axes, points[part[good]] - mean[good])
            near = np.einsum("bi,bi->b", node, node) <= FARTHEST
            chosen = np.flatnonzero(good)[near]
            weight[chosen] *= 1.0 + np.einsum("bi,bki->bk", node[near], y[near])
            done = np.full(len(part), is_last)
            done[chosen] = True
            failed.append(part[~done])
            keep = is_own & done[:, None]
            rows.append(np.repeat(part, keep.sum(axis=1)))
            columns.append(around[keep])
            weights.append(weight[keep])
        left = np.concatenate(failed) if failed else left[:0]
    shape = (count, len(centres))
    entries = (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns)))
    return csr_array(entries, shape=shape)


def _span(centres: Array) -> Array:
    """Return the directions (d, s) in which centres (m, d) have an extent; at least one."""
    extent, axes = np.linalg.eigh(np.cov(centres, rowvar=False, bias=True))
    has = extent > LEVEL**2 * extent[-1]
    has[-1] = True
    return np.eye(len(axes)) if has.all() else np.asarray(axes[:, has])
