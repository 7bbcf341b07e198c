"""Fully symmetric products of two tensors, and their contraction with a strain rate.

    S(X, Y)_ijkl = (X_ij Y_kl + Y_ij X_kl + X_ik Y_jl + X_il Y_jk + X_jk Y_il + X_jl Y_ik) / 6

is the average over all 24 orders of the indices when X and Y are symmetric. Every fully symmetric
isotropic function of one tensor is a sum of such products (Smith's representation, as used by
Chung and Kwon 2002).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["IDENTITY", "cofactor", "double_dot", "scaled", "symmetric_part", "symmetric_product"]
__all__ += ["symmetric_product_dot"]

Array = NDArray[np.float64]

IDENTITY = np.eye(3)
IDENTITY.flags.writeable = False


def scaled(factor: Array, tensor: Array) -> Array:
    """Return scalars (...) times tensors (..., 3, 3)."""
    result: Array = np.asarray(factor)[..., None, None] * tensor
    return result


def double_dot(x: Array, y: Array) -> Array:
    """Return ``X:Y = X_ij Y_ij`` of tensors (..., 3, 3), shape (...)."""
    result: Array = np.einsum("...ij,...ij->...", x, y)
    return result


def symmetric_part(x: Array) -> Array:
    """Return ``(X + X^T)/2``."""
    result: Array = 0.5 * (x + x.swapaxes(-1, -2))
    return result


def cofactor(a: Array) -> Array:
    """Return the cofactors of symmetric tensors: ``d det(a) = cof(a):da``, shape (..., 3, 3)."""
    a11, a22, a33 = a[..., 0, 0], a[..., 1, 1], a[..., 2, 2]
    a12, a13, a23 = a[..., 0, 1], a[..., 0, 2], a[..., 1, 2]
    c = np.empty_like(a)
    c[..., 0, 0] = a22 * a33 - a23 * a23
    c[..., 1, 1] = a11 * a33 - a13 * a13
    c[..., 2, 2] = a11 * a22 - a12 * a12
    c[..., 0, 1] = c[..., 1, 0] = a13 * a23 - a12 * a33
    c[..., 0, 2] = c[..., 2, 0] = a12 * a23 - a13 * a22
    c[..., 1, 2] = c[..., 2, 1] = a12 * a13 - a11 * a23
    return c


def symmetric_product(x: Array, y: Array) -> Array:
    """Return ``S(X, Y)`` of symmetric tensors (..., 3, 3), shape (..., 3, 3, 3, 3)."""
    outer = np.einsum("...ij,...kl->...ijkl", x, y)
    outer = outer + np.einsum("...ijkl->...klij", outer)
    crossed = outer.swapaxes(-3, -2) + np.einsum("...ijkl->...iklj", outer)
    result: Array = (outer + crossed) / 6.0
    return result


def symmetric_product_dot(x: Array, y: Array, D: Array) -> Array:
    """Return ``S(X, Y):D = [X (Y:D) + Y (X:D) + 2 (X D Y + Y D X)]/6``, shape (..., 3, 3).

    Parameters
    ----------
    x, y, D : (..., 3, 3) arrays
        Symmetric tensors; shapes broadcast.
    """
    both = x @ D @ y
    result: Array = (
        scaled(double_dot(y, D), x) + scaled(double_dot(x, D), y) + 4.0 * symmetric_part(both)
    ) / 6.0
    return result
