"""Several polynomials of two variables that share their exponents, with their slopes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Bivariate"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Bivariate:
    """Polynomials ``sum_k c_k x^m_k y^n_k``.

    Parameters
    ----------
    exponents : tuple of (int, int)
        The pairs ``(m_k, n_k)``, one for each term.
    coefficients : (components, terms) array
        One row for each polynomial.
    """

    exponents: tuple[tuple[int, int], ...]
    coefficients: Array

    def value(self, x: Array, y: Array) -> Array:
        """Return the polynomials at points (...), shape (..., components)."""
        powers_x, powers_y = self._powers(x, y)
        terms = np.stack([powers_x[m] * powers_y[n] for m, n in self.exponents], axis=-1)
        result: Array = terms @ self.coefficients.T
        return result

    def slopes(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the derivatives with respect to x and to y, each (..., components)."""
        powers_x, powers_y = self._powers(x, y)
        zero = np.zeros_like(x)
        by_x = [m * powers_x[m - 1] * powers_y[n] if m else zero for m, n in self.exponents]
        by_y = [n * powers_x[m] * powers_y[n - 1] if n else zero for m, n in self.exponents]
        return (
            np.stack(by_x, axis=-1) @ self.coefficients.T,
            np.stack(by_y, axis=-1) @ self.coefficients.T,
        )

    def _powers(self, x: Array, y: Array) -> tuple[list[Array], list[Array]]:
        """Return the powers 0, 1, 2, ... of both variables."""
        degree = max(max(m, n) for m, n in self.exponents)
        powers_x, powers_y = [np.ones_like(x)], [np.ones_like(y)]
        for _ in range(degree):
            powers_x.append(powers_x[-1] * x)
            powers_y.append(powers_y[-1] * y)
        return powers_x, powers_y
