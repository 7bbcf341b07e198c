"""Smallest and largest eigenvalue of many symmetric 3 x 3 matrices, with their directions.

Cardano's formula in its trigonometric form gives the eigenvalue that stands farthest apart from
the other two to rounding, but of two close ones it loses half the digits. So only the far one is
taken from it; its direction is a column of the adjugate of ``A - lambda I``, which is well
conditioned, and the plane across holds a 2 x 2 problem that the square root solves to rounding (the
order of steps of Eberly 2014, "A robust eigensolver for 3x3 symmetric matrices"). Everything is
written out in components: a million matrices take a third of a second.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Components",
    "Vector",
    "blocks",
    "components",
    "extreme_eigenpairs",
    "strain_ends",
    "vector",
]

Array = NDArray[np.float64]

BLOCK = 1 << 13
"""Matrices taken at a time: a few dozen arrays of this length stay in the cache."""

SAFE = (1e-100, 1e100)
"""Largest components between which no product of two vanishes or overflows."""

ISOTROPIC = 1e-140
"""Size of a deviator whose squares vanish: far below the rounding of a matrix within `SAFE`."""

Components = tuple[Array, Array, Array, Array, Array, Array]
"""``A_11, A_22, A_33, A_23, A_13, A_12`` of a symmetric matrix, arrays of one shape."""

Vector = tuple[Array, Array, Array]
"""The components of vectors, arrays of one shape."""


def components(matrix: Array) -> Components:
    """Return the components of the symmetric part of matrices (..., 3, 3)."""
    A = matrix
    return (
        np.asarray(A[..., 0, 0]),
        np.asarray(A[..., 1, 1]),
        np.asarray(A[..., 2, 2]),
        np.asarray(0.5 * (A[..., 1, 2] + A[..., 2, 1])),
        np.asarray(0.5 * (A[..., 0, 2] + A[..., 2, 0])),
        np.asarray(0.5 * (A[..., 0, 1] + A[..., 1, 0])),
    )


def vector(v: Array) -> Vector:
    """Return the components of vectors (..., 3)."""
    return np.asarray(v[..., 0]), np.asarray(v[..., 1]), np.asarray(v[..., 2])


def strain_ends(gradient: Array) -> tuple[Array, Array]:
    """Return lowest and highest rate of stretching [1/s] of velocity gradients (..., 3, 3)."""
    low, high, _, _ = extreme_eigenpairs(components(gradient))
    return low, high


def extreme_eigenpairs(matrix: Components) -> tuple[Array, Array, Vector, Vector]:
    """Return lowest and highest eigenvalue, then the unit eigenvector of each.

    The eigenvectors' signs are arbitrary. Where an eigenvalue is double, some vector of its plane
    is returned; for a multiple of the identity, some pair at right angles.

    Parameters
    ----------
    matrix : six arrays
        The components; not changed.

    Returns
    -------
    lowest, highest : (...) arrays
        To about ten roundings of the largest component.
    direction_lowest, direction_highest : three (...) arrays each
    """
    largest = reduce(np.maximum, (np.abs(part) for part in matrix))
    if np.all((largest > SAFE[0]) & (largest < SAFE[1])):
        return _eigenpairs(matrix)
    # rare: a melt at rest, or rates whose squares leave the range of floating-point numbers
    largest = np.where(largest > 0.0, largest, 1.0)
    a, b, c, d, e, f = (part / largest for part in matrix)
    low, high, at_low, at_high = _eigenpairs((a, b, c, d, e, f))
    return low * largest, high * largest, at_low, at_high


def _eigenpairs(matrix: Components) -> tuple[Array, Array, Vector, Vector]:
    """Return what `extreme_eigenpairs` does, of matrices within `SAFE` or zero."""
    mean = (matrix[0] + matrix[1] + matrix[2]) / 3.0
    a, b, c = matrix[0] - mean, matrix[1] - mean, matrix[2] - mean
    d, e, f = matrix[3], matrix[4], matrix[5]
    size = np.sqrt((0.5 * (a * a + b * b + c * c) + d * d + e * e + f * f) / 3.0)
    size = np.where(size > ISOTROPIC, size, 0.0)
    unit = 1.0 / np.where(size > 0.0, size, 1.0)
    a, b, c, d, e, f = (part * unit for part in (a, b, c, d, e, f))
    half_det = 0.5 * (a * (b * c - d * d) + f * (e * d - f * c) + e * (f * d - b * e))
    upper = half_det >= 0.0  # the largest eigenvalue stands apart
    # rounding may push the cosine beyond one
    third = np.arccos(np.minimum(np.abs(half_det), 1.0)) / 3.0
    far = np.where(upper, 2.0, -2.0) * np.cos(third)
    apart = _null_vector((a - far, b - far, c - far, d, e, f))
    other, across = _across((a, b, c, d, e, f), apart, upper)
    low, high = np.where(upper, other, far), np.where(upper, far, other)
    first = tuple(np.where(upper, v, w) for v, w in zip(across, apart, strict=True))
    second = tuple(np.where(upper, w, v) for v, w in zip(across, apart, strict=True))
    return (
        mean + size * low,
        mean + size * high,
        (first[0], first[1], first[2]),
        (second[0], second[1], second[2]),
    )


def blocks(shape: tuple[int, ...], size: int = BLOCK) -> Iterator[tuple[Any, ...]]:
    """Yield indices that cut the leading axes of a shape into pieces of about ``size`` elements.

    Parameters
    ----------
    shape : tuple of int
        Shape of the arrays that are taken piece by piece.
    size : int
        Elements in a piece; the work on a piece should stay in the cache.
    """
    rest = int(np.prod(shape[1:]))
    if rest * (shape[0] if shape else 1) <= size:
        yield ()
    elif rest <= size:
        step = size // rest
        for start in range(0, shape[0], step):
            yield (slice(start, start + step),)
    else:
        for k in range(shape[0]):
            for tail in blocks(shape[1:], size):
                yield (k, *tail)


def _null_vector(matrix: Components) -> Vector:
    """Return the unit vector that a matrix of rank two maps to zero.

    The adjugate is a multiple of ``v v^T``: its column with the largest diagonal is ``v``.
    """
    a, b, c, d, e, f = matrix
    aa, bb, cc = b * c - d * d, a * c - e * e, a * b - f * f
    bc, ac, ab = e * f - a * d, d * f - b * e, d * e - c * f
    sa, sb, sc = np.abs(aa), np.abs(bb), np.abs(cc)
    second = (sb > sa) & (sb >= sc)
    third = (sc > sa) & (sc > sb)
    x = np.where(third, ac, np.where(second, ab, aa))
    y = np.where(third, bc, np.where(second, bb, ab))
    z = np.where(third, cc, np.where(second, bc, ac))
    return _normalised(x, y, z)


def _across(matrix: Components, apart: Vector, upper: NDArray[np.bool_]) -> tuple[Array, Vector]:
    """Return the eigenvalue at the other end, in the plane across ``apart``, and its vector."""
    a, b, c, d, e, f = matrix
    x, y, z = apart
    steep = np.abs(x) > np.abs(y)
    none = np.zeros_like(x)
    u = _normalised(np.where(steep, -z, none), np.where(steep, none, z), np.where(steep, x, -y))
    v = (y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0])
    au = (
        a * u[0] + f * u[1] + e * u[2],
        f * u[0] + b * u[1] + d * u[2],
        e * u[0] + d * u[1] + c * u[2],
    )
    uu = u[0] * au[0] + u[1] * au[1] + u[2] * au[2]
    uv = v[0] * au[0] + v[1] * au[1] + v[2] * au[2]
    vv = v[0] * (a * v[0] + 2.0 * (f * v[1] + e * v[2])) + v[1] * (b * v[1] + 2.0 * d * v[2])
    vv = vv + c * v[2] * v[2]
    half = 0.5 * (uu - vv)
    radius = np.hypot(half, uv)
    end = np.where(upper, -radius, radius)
    # of the two forms of the eigenvector, the one that does not cancel
    along = half * end >= 0.0
    p = np.where(along, end + half, uv)
    q = np.where(along, uv, end - half)
    length = np.hypot(p, q)
    flat = length == 0.0
    inverse = 1.0 / np.where(flat, 1.0, length)
    p, q = np.where(flat, 1.0, p * inverse), q * inverse
    vector = (p * u[0] + q * v[0], p * u[1] + q * v[1], p * u[2] + q * v[2])
    return 0.5 * (uu + vv) + end, vector


def _normalised(x: Array, y: Array, z: Array) -> Vector:
    """Return the vectors over their lengths; where all vanish, the third axis."""
    length = np.sqrt(x * x + y * y + z * z)
    none = length == 0.0
    inverse = 1.0 / np.where(none, 1.0, length)
    return x * inverse, y * inverse, np.where(none, 1.0, z * inverse)
