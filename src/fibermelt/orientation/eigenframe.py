"""Closures that are known in the principal axes of the tensor: orthotropic fits, exact closure.

Every fully symmetric, normalised fourth moment is the linear closure plus a tensor H that has no
trace over any two indices (nine numbers). If H shares the principal axes of a, three are left,
``h_i = H_iiii``, and ``H_1122 = (h_3 - h_1 - h_2)/2`` and so on. Such a closure is therefore three
functions of the eigenvalues; what is here does the rest for all of them: axes, contraction, and
the derivative that includes the turning of the axes.

Where two eigenvalues coincide, their axes are arbitrary. A function of the tensor alone must then
be unchanged by a turn about the third axis k: ``h_i = h_j = 3/8 h_k``. The exact closure is; fits
miss it by their error, so that their value would depend on an arbitrary choice. Within ``SAME`` of
that state the average over the turn is taken instead (for three equal eigenvalues: over all turns,
H = 0), of the value and of the derivative. The average is the only choice that no rotation of the
laboratory changes, and it keeps uniaxial flows uniaxial. For the exact closure nothing jumps, and a
fit is led over to the average at a small gap (`fibermelt.orientation.orthotropic`); but where all
three coincide it jumps by its departure, of no consequence, as flows leave that state at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fibermelt.orientation.eigen import ROUNDING, eigenframe
from fibermelt.orientation.polynomial import LinearLaw

__all__ = ["SAME", "EigenframeLaw", "PrincipalDeviation"]

Array = NDArray[np.float64]

SAME = 1e-7
"""Gap, relative to the sum of two eigenvalues, below which they count as equal.

The divided differences carry rounding over the gap (1e-16/1e-7) and their limit is off by the gap
itself: both errors of the derivative are 1e-7 or less, of no consequence to a Newton step. The
value is off by the square of the gap. Relative, because an exact closure of nearly aligned fibers
varies on the scale of the two small eigenvalues.
"""

_PAIRS = ((0, 1, 2), (0, 2, 1), (1, 2, 0))
"""Two axes and the third."""

_LINEAR = LinearLaw()


class PrincipalDeviation(Protocol):
    """The three functions ``h_i = A_iiii - (6/7 lambda_i - 3/35)`` of sorted eigenvalues."""

    def value(self, values: Array) -> Array:
        """Return h, shape (n, 3), at eigenvalues (n, 3) in descending order."""
        ...

    def value_and_slopes(self, values: Array) -> tuple[Array, Array]:
        """Return h and ``d h_i / d lambda_j``, (n, 3, 3), right along changes that sum to 0."""
        ...


@dataclass(frozen=True)
class EigenframeLaw:
    """``A = A_linear(a) + H``, H orthotropic in the principal axes of a.

    Parameters
    ----------
    deviation : PrincipalDeviation
        The three functions of the eigenvalues.
    """

    deviation: PrincipalDeviation

    def fourth(self, a: Array) -> Array:
        """Return ``A``."""
        values, axes = eigenframe(a.reshape(-1, 3, 3))
        h = _averaged(self.deviation, values)
        turns = np.zeros((len(h), 3, 3, 3))
        H = _from_principal(_assemble(_pairwise(h), turns), axes)
        return _LINEAR.fourth(a) + H.reshape(*a.shape, 3, 3)

    def contract(self, a: Array, D: Array) -> Array:
        """Return ``A:D``: in principal axes ``(A:D)_ij = 2 A_iijj D_ij``, and the diagonal."""
        values, axes = eigenframe(a.reshape(-1, 3, 3))
        pairwise = _pairwise(_averaged(self.deviation, values))
        # The linear closure's A_iijj, in the same axes, saves a second contraction.
        pairwise += (values[:, :, None] + values[:, None, :]) / 7.0 - 1.0 / 35.0
        for i in range(3):
            pairwise[:, i, i] += 4.0 / 7.0 * values[:, i] - 2.0 / 35.0
        axes = axes.reshape(a.shape)
        rate = axes.swapaxes(-1, -2) @ D @ axes
        pairwise = pairwise.reshape(a.shape)
        diagonal = np.einsum("...ii->...i", rate)
        inner = 2.0 * pairwise * rate
        stretch = np.einsum("...ij,...j->...i", pairwise, diagonal)
        for i in range(3):
            inner[..., i, i] = stretch[..., i]
        result: Array = axes @ inner @ axes.swapaxes(-1, -2)
        return result

    def fourth_derivative(self, a: Array, da: Array) -> Array:
        """Return ``dA``: the eigenvalues' part and the axes' part."""
        axes, pairwise, turns, shape = self._principal_change(a, da)
        count = shape[-3]
        H = _from_principal(_assemble(pairwise, turns), np.repeat(axes, count, axis=0))
        return _LINEAR.fourth_derivative(a, da) + H.reshape(*shape, 3, 3)

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return ``dA:D`` without the 81 components."""
        a = np.broadcast_to(a, np.broadcast_shapes(a.shape, D.shape))
        axes, pairwise, turns, shape = self._principal_change(a, da)
        n, count = len(axes), shape[-3]
        each = axes[:, None]
        rates = np.broadcast_to(D, (*shape[:-3], 3, 3)).reshape(n, 1, 3, 3)
        rate = np.broadcast_to(each.swapaxes(-1, -2) @ rates @ each, (n, count, 3, 3))
        inner = _contract_principal(
            pairwise.reshape(n, count, 3, 3), turns.reshape(n, count, 3, 3, 3), rate
        )
        turned = each @ inner @ each.swapaxes(-1, -2)
        return _LINEAR.contract_derivative(a, D, da) + turned.reshape(shape)

    def _principal_change(self, a: Array, da: Array) -> tuple[Array, Array, Array, tuple[int, ...]]:
        """Return the axes (n, 3, 3) and, in them, the change of H along each direction.

        The change has components ``dH_iijj`` (n k, 3, 3), from the eigenvalues, and ``dH_ijkk``
        (n k, 3, 3, 3), from the turn of the axes by ``E_ij/(lambda_i - lambda_j)``.
        """
        shape = (*np.broadcast_shapes(a.shape[:-2], da.shape[:-3]), *da.shape[-3:])
        values, axes = eigenframe(np.broadcast_to(a, (*shape[:-3], 3, 3)).reshape(-1, 3, 3))
        h, slopes = self.deviation.value_and_slopes(values)
        same = _coincide(values)
        h, slopes = _average(values, h, slopes, same)
        quotients = _quotients(values, h, slopes, same)
        each = axes[:, None]
        along = np.broadcast_to(da, shape).reshape(len(axes), -1, 3, 3)
        along = each.swapaxes(-1, -2) @ along @ each
        pairwise = _pairwise(np.einsum("nij,nkjj->nki", slopes, along))
        turns = quotients[:, None] * along[..., None]
        return axes, pairwise.reshape(-1, 3, 3), turns.reshape(-1, 3, 3, 3), shape


def _pairwise(h: Array) -> Array:
    """Return ``H_iijj`` (..., 3, 3) from ``H_iiii`` (..., 3): no trace over any two indices."""
    half = 0.5 * h.sum(axis=-1)
    result = np.empty((*h.shape, 3))
    for i, j, k in _PAIRS:
        result[..., i, j] = result[..., j, i] = h[..., k] - half
    for i in range(3):
        result[..., i, i] = h[..., i]
    return result


def _coincide(values: Array) -> NDArray[np.bool_]:
    """Return where the first two and where the last two eigenvalues count as equal, (n, 2)."""
    size = np.abs(values)
    bound = SAME * (size[:, :2] + size[:, 1:]) + ROUNDING
    result: NDArray[np.bool_] = values[:, :2] - values[:, 1:] <= bound
    return result


def _averaged(deviation: PrincipalDeviation, values: Array) -> Array:
    """Return h, averaged over the arbitrary axes where eigenvalues coincide."""
    h = deviation.value(values)
    same = _coincide(values)
    rows = np.flatnonzero(same.any(axis=1))
    if rows.size:
        _, slopes = deviation.value_and_slopes(values[rows])
        h[rows], _ = _average(values[rows], h[rows], slopes, same[rows])
    return h


def _average(
    values: Array, h: Array, slopes: Array, same: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Return h and its slopes averaged over the turn about the axis of the third eigenvalue.

    Of the value only ``h_k`` survives. A function of the tensor alone has, at a small gap, also
    ``h_i - h_j`` = slope times gap; that is kept, because its slope is.
    """
    h, slopes = h.copy(), slopes.copy()
    for position, (i, j, k) in enumerate(((0, 1, 2), (1, 2, 0))):
        rows = np.flatnonzero(same[:, position])
        odd = 0.5 * _odd_slope(slopes[rows], i, j)
        difference = odd * (values[rows, i] - values[rows, j])
        h[rows, i] = 0.375 * h[rows, k] + difference
        h[rows, j] = 0.375 * h[rows, k] - difference
        zonal = slopes[rows, k]
        zonal[:, i] = zonal[:, j] = 0.5 * (zonal[:, i] + zonal[:, j])
        turning = np.zeros_like(zonal)
        turning[:, i], turning[:, j] = odd, -odd
        slopes[rows, k] = zonal
        slopes[rows, i] = 0.375 * zonal + turning
        slopes[rows, j] = 0.375 * zonal - turning
    isotropic = same.all(axis=1)
    h[isotropic], slopes[isotropic] = 0.0, 0.0
    return h, slopes


def _odd_slope(slopes: Array, i: int, j: int) -> Array:
    """Return the derivative of ``h_i - h_j`` by ``lambda_i - lambda_j``."""
    odd = slopes[:, i] - slopes[:, j]
    result: Array = 0.5 * (odd[:, i] - odd[:, j])
    return result


def _quotients(values: Array, h: Array, slopes: Array, same: NDArray[np.bool_]) -> Array:
    """Return the divided differences ``dH_ijkk / E_ij`` from averaged h and slopes.

    A turn of the axes by ``E_ij/(lambda_i - lambda_j)`` changes ``H_iiij`` by ``H_iiii -
    3 H_iijj``, ``H_jjij`` by ``3 H_iijj - H_jjjj`` and ``H_ijkk`` by ``H_iikk - H_jjkk`` times
    that angle. With ``u = h_i - h_j``, which turns with twice the angle about axis k, and
    ``v = h_i + h_j - 3/4 h_k``, with four times, these are ``2 v + u/2``, ``u/2 - 2 v``, ``-u``.
    Where the eigenvalues coincide u over the gap becomes its slope and v over the gap 0.

    Returns
    -------
    (n, 3, 3, 3) array
        ``[i, j, k]``, symmetric in i and j, 0 for i = j.
    """
    quotients = np.zeros((len(values), 3, 3, 3))
    # Two eigenvalues that are not neighbours coincide only if all three do.
    coincide = {(0, 1): same[:, 0], (1, 2): same[:, 1], (0, 2): same.all(axis=1)}
    for i, j, k in _PAIRS:
        at_limit = coincide[i, j]
        gap = np.where(at_limit, 1.0, values[:, i] - values[:, j])
        twofold = (h[:, i] - h[:, j]) / gap
        fourfold = (h[:, i] + h[:, j] - 0.75 * h[:, k]) / gap
        twofold = np.where(at_limit, _odd_slope(slopes, i, j), twofold)
        fourfold = np.where(at_limit, 0.0, fourfold)
        for first, second in ((i, j), (j, i)):
            quotients[:, first, second, i] = 2.0 * fourfold + 0.5 * twofold
            quotients[:, first, second, j] = 0.5 * twofold - 2.0 * fourfold
            quotients[:, first, second, k] = -twofold
    return quotients


def _assemble(pairwise: Array, turns: Array) -> Array:
    """Return the 81 components from ``H_iijj`` (n, 3, 3) and ``H_ijkk`` (n, 3, 3, 3)."""
    H = np.zeros((len(pairwise), 3, 3, 3, 3))
    for i in range(3):
        H[:, i, i, i, i] = pairwise[:, i, i]
    for i, j, _ in _PAIRS:
        for p, q, r, s in set(permutations((i, i, j, j))):
            H[:, p, q, r, s] = pairwise[:, i, j]
        for k in range(3):
            for p, q, r, s in set(permutations((i, j, k, k))):
                H[:, p, q, r, s] = turns[:, i, j, k]
    return H


def _from_principal(H: Array, axes: Array) -> Array:
    """Return fourth-order tensors (n, 3, 3, 3, 3) in the frame of the laboratory."""
    n = len(H)
    pairs = np.einsum("nia,njb->nijab", axes, axes).reshape(n, 9, 9)
    turned: Array = pairs @ H.reshape(n, 9, 9) @ pairs.swapaxes(-1, -2)
    return turned.reshape(n, 3, 3, 3, 3)


def _contract_principal(pairwise: Array, turns: Array, rate: Array) -> Array:
    """Return ``dH:D`` in principal axes, (..., 3, 3), from ``dH_iijj`` and ``dH_ijkk``."""
    result = np.empty(rate.shape)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        result[..., i, i] = np.einsum("...j,...jj->...", pairwise[..., i, :], rate) + 2.0 * (
            turns[..., i, j, i] * rate[..., i, j]
            + turns[..., i, k, i] * rate[..., i, k]
            + turns[..., j, k, i] * rate[..., j, k]
        )
    for i, j, k in _PAIRS:
        shear = np.einsum("...k,...kk->...", turns[..., i, j, :], rate) + 2.0 * (
            pairwise[..., i, j] * rate[..., i, j]
            + turns[..., j, k, i] * rate[..., i, k]
            + turns[..., i, k, j] * rate[..., j, k]
        )
        result[..., i, j] = result[..., j, i] = shear
    return result
