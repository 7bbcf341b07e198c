"""Principal frames of orientation tensors, coincident eigenvalues included, and how they turn.

Some models speak of the eigenvectors of ``a``: RSC slows the eigenvalues, pARD and MRD diffuse
along the eigenvectors. Where eigenvalues coincide those are not unique. The choice made here does
not depend on the observer's frame: inside a coincident set the vectors are those of the strain
rate (to which a tensor that starts there turns first), and where that coincides too, weights that
belong to single vectors are averaged over the set.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.orientation.tensors import principal

__all__ = ["PrincipalFrame", "oriented", "oriented_derivative", "pinched", "pinched_derivative"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

TIE = 1e-9
"""Eigenvalues closer than this coincide: rounding turns their vectors by 1e-16 over the gap."""

SEPARATION = 4.0
"""Distance put between sets that do not coincide; the scaled strain rate is within +-1."""


@dataclass(frozen=True, eq=False)
class PrincipalFrame:
    """Eigenvalues and eigenvectors of orientation tensors.

    Parameters
    ----------
    values : (..., 3) array
        Eigenvalues, descending.
    vectors : (..., 3, 3) array
        Eigenvectors as columns.
    coincident : (..., 3, 3) array of bool
        Which pairs of eigenvalues coincide; true on the diagonal.
    averaged : (..., 3, 3) array of bool
        Which of them the strain rate does not tell apart either.
    """

    values: Array
    vectors: Array
    coincident: Mask
    averaged: Mask

    @classmethod
    def of(cls, a: Array, D: Array) -> PrincipalFrame:
        """Return the frame of ``a`` (..., 3, 3) in a flow of strain rate ``D`` (..., 3, 3)."""
        values, vectors = principal(a)
        coincident = _linked(np.abs(values[..., :, None] - values[..., None, :]) <= TIE)
        averaged = coincident & np.eye(3, dtype=bool)
        tied = np.any(coincident != averaged, axis=(-2, -1))
        if np.any(tied):
            vectors, averaged = vectors.copy(), averaged.copy()
            vectors[tied], averaged[tied] = _told_apart(vectors[tied], coincident[tied], D[tied])
        return cls(values, vectors, coincident, averaged)

    def inward(self, x: Array) -> Array:
        """Return the components of symmetric tensors in the frame, ``V^T x V``."""
        inner: Array = self.vectors.swapaxes(-1, -2) @ x @ self.vectors
        return inner

    def outward(self, x: Array) -> Array:
        """Return the components outside the frame of tensors given inside, ``V x V^T``."""
        outer: Array = self.vectors @ x @ self.vectors.swapaxes(-1, -2)
        return outer

    def spread(self) -> PrincipalFrame:
        """Return the frame with one more axis, for k tensors at each point."""
        return PrincipalFrame(
            self.values[..., None, :],
            self.vectors[..., None, :, :],
            self.coincident[..., None, :, :],
            self.averaged[..., None, :, :],
        )

    def turning(self, da: Array) -> Array:
        """Return how the frame turns along ``da``: skew ``O`` with ``dV = V O``, (..., 3, 3).

        ``O_ij = (V^T da V)_ij/(lambda_j - lambda_i)``, zero inside a coincident set: the
        derivative there is the one along changes that keep the set together.
        """
        gap = self.values[..., None, :] - self.values[..., :, None]
        safe = np.where(self.coincident, 1.0, gap)
        return np.where(self.coincident, 0.0, self.inward(da) / safe)


def _linked(close: Mask) -> Mask:
    """Return pairs joined directly or through the middle value."""
    linked = close.copy()
    chain = close[..., 0, 1] & close[..., 1, 2]
    linked[..., 0, 2] |= chain
    linked[..., 2, 0] |= chain
    return linked


def _told_apart(vectors: Array, coincident: Mask, D: Array) -> tuple[Array, Mask]:
    """Return vectors that diagonalise ``D`` inside each coincident set, largest strain first."""
    size = np.linalg.norm(D, axis=(-2, -1))[..., None, None]
    inner = vectors.swapaxes(-1, -2) @ D @ vectors / np.where(size > 0.0, size, 1.0)
    first = np.argmax(coincident, axis=-1)  # a set is named by its first member
    apart = np.where(coincident, inner, 0.0)
    apart = apart - SEPARATION * first[..., None] * np.eye(3)
    strain, turn = np.linalg.eigh(apart)
    strain, turn = strain[..., ::-1], turn[..., ::-1]
    same = np.abs(strain[..., :, None] - strain[..., None, :]) <= TIE
    return vectors @ turn, _linked(same) & coincident


def oriented(frame: PrincipalFrame, weights: Array) -> Array:
    """Return ``sum_i w_i e_i e_i`` (..., 3, 3), the largest eigenvalue's vector first.

    Weights (3,) of vectors that nothing tells apart are averaged.
    """
    return frame.outward(_averaged(frame, weights)[..., None] * np.eye(3))


def oriented_derivative(frame: PrincipalFrame, weights: Array, da: Array) -> Array:
    """Return the derivative of `oriented` along ``da`` (..., k, 3, 3), same shape."""
    wide = frame.spread()
    w = _averaged(frame, weights)[..., None, :]
    return wide.outward(wide.turning(da) * (w[..., None, :] - w[..., :, None]))


def _averaged(frame: PrincipalFrame, weights: Array) -> Array:
    count = np.sum(frame.averaged, axis=-1)
    mean: Array = np.where(frame.averaged, weights, 0.0).sum(axis=-1) / count
    return mean


def pinched(frame: PrincipalFrame, x: Array) -> Array:
    """Return the part of ``x`` that changes the eigenvalues of ``a``, (..., 3, 3).

    ``M:x`` with ``M = sum_i e_i e_i e_i e_i`` (Wang, O'Gara and Tucker 2008); inside a
    coincident set the whole block is kept, the limit along the tensor's own path.
    """
    return frame.outward(np.where(frame.coincident, frame.inward(x), 0.0))


def pinched_derivative(frame: PrincipalFrame, x: Array, dx: Array, da: Array) -> Array:
    """Return the derivative of ``M:x`` along ``da`` and ``dx``, (..., k, 3, 3).

    With ``P = V m(Y) V^T``, ``Y = V^T x V``, ``m`` the mask and ``dV = V O``:
    ``dP = V [O m(Y) - m(Y) O + m(Y O - O Y + V^T dx V)] V^T``.
    """
    wide = frame.spread()
    turn = wide.turning(da)
    inner = wide.inward(x[..., None, :, :])
    kept = np.where(wide.coincident, inner, 0.0)
    change = np.where(wide.coincident, inner @ turn - turn @ inner + wide.inward(dx), 0.0)
    return wide.outward(turn @ kept - kept @ turn + change)
