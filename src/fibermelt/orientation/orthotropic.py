"""Orthotropic fitted closures: the principal components as polynomials of the eigenvalues."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.orientation.bivariate import Bivariate

__all__ = ["FittedDeviation"]

Array = NDArray[np.float64]


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
        fitted = self.components.value(values[:, 0], values[:, 1])
        return fitted - (6.0 / 7.0 * values - 3.0 / 35.0)

    def value_and_slopes(self, values: Array) -> tuple[Array, Array]:
        """Return h and ``d h_i / d lambda_j`` for ``lambda_3 = 1 - lambda_1 - lambda_2``."""
        by_first, by_second = self.components.slopes(values[:, 0], values[:, 1])
        slopes = np.stack([by_first, by_second, np.zeros_like(by_first)], axis=-1)
        return self.value(values), slopes - 6.0 / 7.0 * np.eye(3)
