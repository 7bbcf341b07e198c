"""The velocity gradient from nodal velocities: local polynomials, fitted to the nodes around.

A cubic through the node's own value is fitted by weighted least squares to the nodes within two
rings of cells, three where that is one-sided: of third order in the edge. A quadratic fitted to the
same nodes differs from it by the quadratic's error, far above the cubic's where the mesh resolves
the flow, near it where it does not. That is the estimate, with what scatter of the velocities about
the cubic (a coarse solution, few digits) makes of the gradient. Reference: Zhang and Naga 2005,
SIAM J. Sci. Comput. 26, 1192 (doi:10.1137/S1064827503402837), with quadratics without weights.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from fibermelt.fields.patches import batches, inverse_normal, monomials, own_axes, padded
from fibermelt.fields.simplices import adjacency, facets
from fibermelt.threads import cores

__all__ = ["recovered_gradient"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DECAY = 2.0
"""Of the cubic's weights ``exp(-DECAY r^2 / d)``, ``r`` in root-mean-square distances of the patch
along its own axes: between 0 and 4 the cubic's error moves by a factor of two. The quadratic gains
by looking near and has the squares of them."""

RINGS, RINGS_AT_BOUNDARY, MOST_RINGS = 2, 3, 5

SPARE = 1.2
"""Nodes around for each coefficient of the cubic, at least."""

WORST_CONDITION = 1e9
"""Of the cubic's normal matrix, in the patch's own axes: 1e3 to 1e6 on good patches; above, the
nodes lie on a cubic."""

ROWS = 20_000
"""Nodes whose patches are gathered at once."""


def _fit(basis: Array, rise: Array, root: Array) -> tuple[Array, Array, Array]:
    """Return coefficients (b, q, c) of weighted fits, inverse normal matrices, and conditions.

    Of ``rise`` (b, c, k) by ``basis`` (b, q, k), with the roots (b, k) of the weights.
    """
    q = basis.shape[1]
    rows = np.concatenate([basis, rise], axis=1) * root[:, None]
    product = rows @ rows.swapaxes(1, 2)
    inverse, condition = inverse_normal(product[:, :q, :q])
    return inverse @ product[:, :q, q:], inverse, condition


def _scatter(left: Array, weight: Array, count: Array, inverse: Array, axes: Array) -> Array:
    """Return a bound of the standard deviation of fitted slopes in Frobenius's norm (b,).

    Parameters
    ----------
    left : (b, c, k) array
        What the fits leave of the velocities; zero at the centre and where it fills a patch up.
    weight : (b, k) array
        Weights of the fits, at most one.
    count : (b,) array
        Nodes of each patch but for the centre.
    inverse : (b, q, q) array
        Of the normal matrix: times the variance, a bound of the coefficients' covariance.
    axes : (b, d, d) array
        From the patch's own axes to those of the flow.
    """
    d, q = axes.shape[-1], inverse.shape[-1]
    spare = np.maximum(count - q, 1) / count
    variance = np.einsum("bk,bck->b", weight, left**2) / (weight.sum(axis=1) * spare)
    spread = np.einsum("bij,bik,bkj->b", axes, inverse[:, :d, :d], axes)
    return np.asarray(np.sqrt(variance * np.abs(spread)))


def recovered_gradient(points: Array, cells: Index, velocity: Array) -> tuple[Array, Array]:
    """Return the velocity gradient at the nodes of a mesh, and an estimate of its error.

    Parameters
    ----------
    points : (n, d) array
        Nodes [m], d = 2 or 3.
    cells : (m, d + 1) int array
        Triangles or tetrahedra; nodes that share none are no neighbours, however near.
    velocity : (n, c) array
        [m/s].

    Returns
    -------
    gradient : (n, c, d) array
        ``d u_i / d x_j`` [1/s].
    error : (n,) array
        Estimated error in Frobenius's norm [1/s]: what the cubic differs from the quadratic, and
        what scatters. Where the mesh has too few nodes for a cubic, a
        plane is fitted, and all of the gradient is in doubt.
    """
    n, d = points.shape
    coefficients = 9 if d == 2 else 19
    joined = adjacency(cells, n)
    gradient = np.zeros((n, velocity.shape[1], d))
    error = np.zeros(n)
    at_boundary = np.zeros(n, dtype=bool)
    at_boundary[facets(cells).boundary] = True
    left = np.flatnonzero(~at_boundary)
    for rings in range(RINGS, MOST_RINGS + 1):
        if rings == RINGS_AT_BOUNDARY:
            left = np.sort(np.concatenate([left, np.flatnonzero(at_boundary)]))
        failed = []
        for rows in np.array_split(left, max(1, -(-len(left) // ROWS))):
            pattern = joined[rows]
            for _ in range(rings - 1):
                pattern = pattern @ joined
            patches = batches(pattern, coefficients)
            fit = partial(_patch, points, velocity, is_last=rings == MOST_RINGS)
            around = (pattern[batch] for batch in patches)
            # nearly all of a fit is in NumPy, which lets other threads run meanwhile
            with ThreadPoolExecutor(cores()) as pool:
                fits = list(pool.map(fit, (rows[batch] for batch in patches), around))
            for batch, (good, slopes, doubt) in zip(patches, fits, strict=True):
                centre = rows[batch]
                gradient[centre[good]], error[centre[good]] = slopes[good], doubt[good]
                failed.append(centre[~good])
        left = np.concatenate(failed) if failed else left[:0]
    return gradient, error


def _patch(
    points: Array, velocity: Array, centre: Index, pattern: csr_array, is_last: bool
) -> tuple[NDArray[np.bool_], Array, Array]:
    """Return which patches will do, the gradients (b, c, d) and their estimated errors (b,)."""
    d = points.shape[1]
    # short patches are filled up with the centre, which adds nothing to a fit through it
    around, is_own = padded(pattern, centre)
    length = is_own.sum(axis=1)
    table = np.column_stack([points, velocity])
    beyond = np.take(table, around, axis=0) - table[centre, None]
    away, rise = beyond[..., :d], beyond[..., d:].swapaxes(1, 2)
    axes = own_axes(away, length)
    y = axes @ away.swapaxes(1, 2)
    basis = monomials(y, 3)
    root = np.exp(-0.5 * DECAY / d * np.einsum("bik,bik->bk", y, y))
    near = root**2
    cubic, inverse, condition = _fit(basis, rise, root)
    of_two = d + d * (d + 1) // 2
    quadratic = _fit(basis[:, :of_two], rise, near)[0]
    good = (condition < WORST_CONDITION) & (length - 1 >= SPARE * basis.shape[1])
    slopes = cubic[:, :d].swapaxes(1, 2) @ axes
    doubt = np.linalg.norm(slopes - quadratic[:, :d].swapaxes(1, 2) @ axes, axis=(1, 2))
    left = rise - cubic.swapaxes(1, 2) @ basis
    count = np.maximum(length - 1, 1)
    doubt += _scatter(left, near * is_own, count, inverse, axes)
    if is_last and not good.all():
        plane = _fit(basis[:, :d], rise, near)[0].swapaxes(1, 2) @ axes
        slopes[~good] = plane[~good]
        doubt[~good] = np.linalg.norm(plane[~good], axis=(1, 2))
        good = np.ones_like(good)
    return good, slopes, doubt
