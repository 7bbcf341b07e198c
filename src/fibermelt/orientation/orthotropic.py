"""Orthotropic fitted closures: the principal components as polynomials of the eigenvalues.

A function of the tensor alone has ``h_i = h_j = 3/8 h_k`` where the eigenvalues i and j coincide
(`fibermelt.orientation.eigenframe`): ``v = h_i + h_j - 3/4 h_k`` vanishes, and ``u = h_i - h_j``
changes its sign where they are exchanged. A fit misses that by its error, up to 4e-3, and would
jump there: where the rates lead back to the jump from every side, as for fibers that enter aligned,
there is no solution. So its v, and the part of its u that an exchange of the two leaves, are led to
zero over a small gap, with the share ``s = x^2 (3 - 2 x)``, ``x = gap/width``. Rates are continuous
then, and a state that would slide along the jump rests beside it (the regularisation of Sotomayor
and Teixeira 1996, whose limit solves the equation as Filippov means it). Elsewhere the fit is as
published.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.orientation.bivariate import Bivariate
from fibermelt.orientation.eigen import ROUNDING

__all__ = ["FittedDeviation"]

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

WIDTH = 1e-5
"""Gap of two eigenvalues below which a fit is led over: what slides is off by some 1e-4, a part
of the fit's own error, and takes some hundred steps; what crosses is off by 1e-8 or less."""

_GAPS = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]])
"""Derivatives of the two gaps by the three eigenvalues."""


@dataclass(frozen=True)
class FittedDeviation:
    """``A_1111, A_2222, A_3333`` fitted, the rest from ``A_ijkk = a_ij`` (Cintra and Tucker 1995).

    The three normalisation conditions give ``A_1122 = (lambda_1 + lambda_2 - lambda_3 - A_1111 -
    A_2222 + A_3333)/2`` and so on, which is what a deviation without traces says.

    Parameters
    ----------
    components : Bivariate
        The fitted components as polynomials of ``lambda_1`` and ``lambda_2``.
    """

    components: Bivariate

    def value(self, values: Array) -> Array:
        """Return ``h_i = A_iiii - (6/7 lambda_i - 3/35)``, shape (n, 3)."""
        h = self._fitted(values)
        for pair, rows, share, _ in _near(values):
            i, j, _ = pair
            twofold, fourfold = _departure(
                h[rows], self._fitted(_exchanged(values[rows], i, j)), pair
            )
            less = 1.0 - share
            h[rows, i] -= 0.5 * less * (fourfold + twofold)
            h[rows, j] -= 0.5 * less * (fourfold - twofold)
        return h

    def value_and_slopes(self, values: Array) -> tuple[Array, Array]:
        """Return h and ``d h_i / d lambda_j`` for ``lambda_3 = 1 - lambda_1 - lambda_2``."""
        h, slopes = self._fitted(values), self._fitted_slopes(values)
        for pair, rows, share, change in _near(values):
            i, j, _ = pair
            other = _exchanged(values[rows], i, j)
            twofold, fourfold = _departure(h[rows], self._fitted(other), pair)
            twofold_slopes, fourfold_slopes = _departure(
                slopes[rows], _exchanged(self._fitted_slopes(other), i, j), pair
            )
            less = 1.0 - share
            for m, sign in ((i, 1.0), (j, -1.0)):
                departure = 0.5 * (fourfold + sign * twofold)
                steepness = 0.5 * (fourfold_slopes + sign * twofold_slopes)
                h[rows, m] -= less * departure
                slopes[rows, m] -= less[:, None] * steepness - change * departure[:, None]
        return h, slopes

    def _fitted(self, values: Array) -> Array:
        fitted = self.components.value(values[:, 0], values[:, 1])
        return fitted - (6.0 / 7.0 * values - 3.0 / 35.0)

    def _fitted_slopes(self, values: Array) -> Array:
        by_first, by_second = self.components.slopes(values[:, 0], values[:, 1])
        slopes = np.stack([by_first, by_second, np.zeros_like(by_first)], axis=-1)
        return slopes - 6.0 / 7.0 * np.eye(3)


def _near(values: Array) -> Iterator[tuple[tuple[int, int, int], Rows, Array, Array]]:
    """Yield pairs i, j with the third k, rows where they nearly coincide, the share s, its slopes.

    The width is at most the other gap: of three eigenvalues that nearly coincide the closer pair
    counts, and a tensor with an axis of symmetry keeps it.
    """
    gaps = values @ _GAPS.T
    for position, pair in enumerate(((0, 1, 2), (1, 2, 0))):
        width = np.minimum(WIDTH, gaps[:, 1 - position])
        rows = np.flatnonzero(gaps[:, position] < width)
        if not rows.size:
            continue
        wide = width[rows]
        # no gap is smaller than its rounding, which must not turn into a slope
        x = np.maximum(gaps[rows, position] - ROUNDING, 0.0) / wide
        by_gap = 6.0 * x * (1.0 - x) / wide
        by_width = np.where(wide < WIDTH, -x * by_gap, 0.0)
        change = by_gap[:, None] * _GAPS[position] + by_width[:, None] * _GAPS[1 - position]
        yield pair, rows, x * x * (3.0 - 2.0 * x), change


def _exchanged(array: Array, i: int, j: int) -> Array:
    """Return an array with the eigenvalues i and j, of its last axis, exchanged."""
    order = [{i: j, j: i}.get(m, m) for m in range(3)]
    return array[..., order]


def _departure(here: Array, exchanged: Array, pair: tuple[int, int, int]) -> tuple[Array, Array]:
    """Return u, the part of it that an exchange leaves, and v, of h or of its slopes."""
    i, j, k = pair
    left = here[:, i] - here[:, j] + exchanged[:, i] - exchanged[:, j]
    return 0.5 * left, here[:, i] + here[:, j] - 0.75 * here[:, k]
