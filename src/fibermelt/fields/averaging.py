"""From the cells of a finite-volume solver to the nodes between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from fibermelt.fields.patches import batches, inverse_normal, monomials, own_axes, padded

__all__ = ["cells_to_nodes"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DECAY = 1.0
"""Of the quadratic's weights ``exp(-DECAY r^2 / d)``, ``r`` as in `fibermelt.fields.recovery`."""

SPARE = 1.2
"""Cells around for each coefficient of the quadratic, at least."""

WORST_CONDITION = 1e6
"""Of the quadratic's normal matrix: below 1e4 on patches of three layers; of two it is singular."""

ONE_SIDED = 1.0
"""Square of a node's distance from the middle of its patch, in the patch's own width, above which
three rings of cells are asked for: 3 to 4 at a wall, below 0.1 inside."""

FARTHEST = 36.0
"""The same up to which a plane is led on to it: 12 in the corner of a box of two layers of bricks,
17 of tetrahedra. Beyond, the cells lie in one layer and say nothing of the slope across."""

LEVEL = 1e-5
"""Parts of the longest extent of all cells' centres below which they lie in one layer, or one row:
coordinates may have four bytes."""

ROWS = 10_000
"""Nodes looked at together."""


def cells_to_nodes(points: Array, centres: Array, member: csr_array, values: Array) -> Array:
    """Return the values of cells at the nodes between them, (n, c).

    Parameters
    ----------
    points : (n, d) array
        Nodes.
    centres : (m, d) array
        Centres of the cells.
    member : (n, m) sparse pattern
        Which node belongs to which cell; each has one at least.
    values : (m, c) array
        Of the cells: their means, or those at the centres, which is the same to second order.

    Notes
    -----
    A quadratic is fitted by weighted least squares to the cells within two rings of the node, three
    where these are on one side of it, and evaluated there: the same accuracy at a wall as inside,
    so that slopes between the nodes are of second order everywhere. A plane would leave errors of
    second order that differ from node to node. Where a quadratic has too few cells, a plane is led
    through those at the node, or those next to them. Of cells in one layer, as OpenFOAM has planar
    and axisymmetric flows, the fit is one in the layer.
    """
    within = _span(centres)
    points, centres = points @ within, centres @ within
    found = np.empty((len(points), values.shape[1]))
    left = np.arange(len(points))
    joined = member @ member.T
    for weigh, rings in (_quadratic, 2), (_quadratic, 3), (_plane, 1), (_plane, 2):
        failed = []
        for part in np.array_split(left, max(1, -(-len(left) // ROWS))):
            pattern = member[part] if rings == 1 else joined[part]
            for _ in range(rings - 2):
                pattern = pattern @ joined
            pattern = pattern @ member if rings > 1 else pattern
            for batch in batches(pattern, 1 + points.shape[1] * (points.shape[1] + 3) // 2):
                rows = part[batch]
                around, is_own = padded(pattern[batch], np.zeros(len(rows), dtype=np.int64))
                good, weight = weigh(points[rows], centres[around], is_own, rings)
                with np.errstate(over="ignore", invalid="ignore"):  # bytes in another order
                    found[rows] = np.einsum("bk,bkc->bc", weight, values[around])
                failed.append(rows[~good])
        left = np.concatenate(failed) if failed else left[:0]
    return found


def _quadratic(
    node: Array, centre: Array, is_own: NDArray[np.bool_], rings: int
) -> tuple[NDArray[np.bool_], Array]:
    """Return which patches (b, k) a quadratic does for, and the cells' weights at the nodes."""
    b, k, d = centre.shape
    number = is_own.sum(axis=1)
    away = (centre - node[:, None]) * is_own[..., None]
    axes = own_axes(away, number)
    y = axes @ away.swapaxes(1, 2)
    basis = np.concatenate([np.ones((b, 1, k)), monomials(y, 2)], axis=1)
    weighted = basis * (np.exp(-DECAY / d * np.einsum("bik,bik->bk", y, y)) * is_own)[:, None]
    inverse, condition = inverse_normal(weighted @ basis.swapaxes(1, 2))
    good = (condition < WORST_CONDITION) & (number >= SPARE * basis.shape[1])
    if rings == 2:
        good &= _distance(away, is_own)[0] < ONE_SIDED
    return good, np.einsum("bq,bqk->bk", inverse[:, 0], weighted)


def _plane(
    node: Array, centre: Array, is_own: NDArray[np.bool_], rings: int
) -> tuple[NDArray[np.bool_], Array]:
    """Return which patches (b, k) a plane does for, and the cells' weights at the nodes.

    In coordinates with the patch's mean as origin and its covariance the identity, the weights of K
    cells at ``y_k`` for a node at ``y`` are ``(1 + y . y_k) / K``. Where it does not, their mean.
    """
    far, product = _distance((centre - node[:, None]) * is_own[..., None], is_own)
    good = far <= FARTHEST
    weight = is_own / is_own.sum(axis=1)[:, None]
    return good, weight * np.where(good[:, None], 1.0 + product, 1.0)


def _distance(away: Array, is_own: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return how far nodes lie from the middles of patches (b, k, d) that are seen from them.

    The square of the distance in the patch's own width (b,), infinite where it has none, and the
    node's product with each cell's place (b, k).
    """
    number = is_own.sum(axis=1)
    mean = away.sum(axis=1) / number[:, None]
    off = (away - mean[:, None]) * is_own[..., None]
    wide = np.einsum("bkd,bkd->b", off, off) > 0
    far, product = np.full(len(away), np.inf), np.zeros(is_own.shape)
    axes = own_axes(off[wide], number[wide])
    node = -np.einsum("bij,bj->bi", axes, mean[wide])
    far[wide] = np.einsum("bi,bi->b", node, node)
    product[wide] = np.einsum("bi,bij,bkj->bk", node, axes, off[wide])
    return far, product


def _span(centres: Array) -> Array:
    """Return the directions (d, s) in which centres (m, d) have an extent; at least one."""
    extent, axes = np.linalg.eigh(np.cov(centres, rowvar=False, bias=True))
    has = extent > LEVEL**2 * extent[-1]
    has[-1] = True
    return np.eye(len(axes)) if has.all() else np.asarray(axes[:, has])
