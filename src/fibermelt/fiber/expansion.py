"""Exponentials of many 3 x 3 matrices, and the Magnus steps made of them.

By Cayley and Hamilton every power of ``A`` is ``a I + b A + c A^2``: ``A^3 = t A^2 - m A + d I``
with the trace ``t``, the sum ``m`` of the principal minors and the determinant ``d``. The
exponential's series is then three scalar sums, whose terms follow from one another.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["EXPONENT_BOUND", "exponential3", "magnus_generator"]

Array = NDArray[np.float64]

EXPONENT_BOUND = 1.0
"""Largest Frobenius norm of a generator: the series then needs `SERIES_TERMS` terms."""

SERIES_TERMS = 19
"""``1/19!`` is 8e-18."""

MAGNUS_WEIGHT = np.sqrt(3.0) / 12.0


def exponential3(generator: Array) -> Array:
    """Return ``exp(A)`` of matrices of norm up to `EXPONENT_BOUND`, (..., 3, 3).

    Parameters
    ----------
    generator : (..., 3, 3) array
        ``A``.
    """
    square = generator @ generator
    trace = np.einsum("...ii->...", generator)
    minors = 0.5 * (trace * trace - np.einsum("...ii->...", square))
    determinant = np.einsum(
        "...i,...i->...", generator[..., 0, :], np.cross(generator[..., 1, :], generator[..., 2, :])
    )
    one, none = np.ones_like(trace), np.zeros_like(trace)
    a, b, c = one, none, none
    constant, linear, quadratic = one, none, none
    for k in range(1, SERIES_TERMS):
        a, b, c = c * determinant / k, (a - c * minors) / k, (b + c * trace) / k
        constant, linear, quadratic = constant + a, linear + b, quadratic + c
    result: Array = linear[..., None, None] * generator + quadratic[..., None, None] * square
    diagonal = np.einsum("...ii->...i", result)
    diagonal += constant[..., None]
    return result


def magnus_generator(first: Array, second: Array, step: Array) -> Array:
    """Return ``h (A_1 + A_2)/2 + (sqrt 3/12) h^2 [A_2, A_1]``, of fourth order in the step.

    Blanes, Casas, Oteo and Ros 2009, doi 10.1016/j.physrep.2008.11.001, section 5.4.

    Parameters
    ----------
    first, second : (..., 3, 3) array
        ``A`` at the two Gauss points of the step [1/s].
    step : (...) array
        ``h`` [s].
    """
    h = step[..., None, None]
    commutator = second @ first - first @ second
    return np.asarray(0.5 * h * (first + second) + (MAGNUS_WEIGHT * h * h) * commutator)
