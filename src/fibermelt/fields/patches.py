"""Patches of points around points: as rectangular arrays, in axes of their own, and polynomials."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

__all__ = ["batches", "inverse_normal", "monomials", "own_axes", "padded"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FLAT = 1e-12
"""Part of its size that is added to a patch's covariance: rounding does not make it negative, one
without width in a direction keeps a finite map, and one a hundred thousand times as long as wide
is as wide as long in its own axes."""

ENTRIES = 500_000
"""Numbers of a batch of fits: 4 MB an array."""


def batches(pattern: csr_array, coefficients: int) -> list[Index]:
    """Return the rows of patches in batches of nearly equal length, short enough for memory."""
    length = np.diff(pattern.indptr)
    order = np.argsort(length, kind="stable")
    starts, used = [0], 0
    for place, row in enumerate(order):
        used += int(length[row]) * coefficients
        if used > ENTRIES:
            starts.append(place)
            used = int(length[row]) * coefficients
    return [part for part in np.split(order, starts[1:]) if part.size]


def own_axes(away: Array, count: Array) -> Array:
    """Return maps (b, d, d) to coordinates in which patches (b, k, d) of so many are round."""
    covariance = np.einsum("bki,bkj->bij", away, away) / count[:, None, None]
    size = np.trace(covariance, axis1=1, axis2=2)[:, None, None]
    covariance = covariance + FLAT * size * np.eye(away.shape[-1])
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def padded(pattern: csr_array, fill: Index) -> tuple[Index, NDArray[np.bool_]]:
    """Return the columns of each row of a pattern, ``fill`` after them, and which are own."""
    length = np.diff(pattern.indptr)
    is_own = np.arange(length.max(initial=1)) < length[:, None]
    around = np.repeat(fill[:, None], is_own.shape[1], axis=1)
    around[is_own] = pattern.indices
    return around, is_own


def monomials(y: Array, degree: int) -> Array:
    """Return the products of one to ``degree`` coordinates (b, d, k) as rows (b, q, k), in order.

    d, then d (d + 1) / 2, then the cubic ones: what a fit of lower degree takes comes first.
    """
    b, d, k = y.shape
    degrees = range(1, degree + 1)
    axes = [item for n in degrees for item in combinations_with_replacement(range(d), n)]
    place = {item: number for number, item in enumerate(axes)}
    rows = np.empty((b, len(axes), k))
    rows[:, :d] = y
    for number, item in enumerate(axes[d:], start=d):
        np.multiply(rows[:, place[item[:-1]]], y[:, item[-1]], out=rows[:, number])
    return rows


def inverse_normal(normal: Array) -> tuple[Array, Array]:
    """Return the inverses of normal matrices (b, q, q), and bounds of their conditions (b,).

    A bound is the product of both traces; one of a singular matrix is above 1e15.
    """
    size = np.trace(normal, axis1=1, axis2=2)
    kept = normal + np.finfo(float).eps * size[:, None, None] * np.eye(normal.shape[-1])
    inverse = np.asarray(np.linalg.inv(kept), dtype=np.float64)
    return inverse, size * np.trace(inverse, axis1=1, axis2=2)
