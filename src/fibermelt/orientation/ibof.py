"""The invariant-based optimal fitting closure (IBOF) of Chung and Kwon (2002)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.orientation.bivariate import Bivariate
from fibermelt.orientation.products import (
    IDENTITY,
    cofactor,
    double_dot,
    scaled,
    symmetric_product,
    symmetric_product_dot,
)

__all__ = ["InvariantLaw"]

Array = NDArray[np.float64]

# fmt: off
_TERMS = (
    (0, 0), (1, 0), (2, 0), (0, 1), (0, 2), (1, 1), (2, 1), (1, 2), (3, 0), (0, 3), (3, 1),
    (2, 2), (1, 3), (4, 0), (0, 4), (4, 1), (3, 2), (2, 3), (1, 4), (5, 0), (0, 5),
)
"""Exponents of the second and third invariant, in the order of the published table."""

_COEFFICIENTS = np.array([
    [  # beta_3
        0.24940908165786e2, -0.435101153160329e3, 0.372389335663877e4,
        0.703443657916476e4, 0.823995187366106e6, -0.133931929894245e6,
        0.880683515327916e6, -0.991630690741981e7, -0.159392396237307e5,
        0.800970026849796e7, -0.237010458689252e7, 0.379010599355267e8,
        -0.337010820273821e8, 0.322219416256417e5, -0.257258805870567e9,
        0.214419090344474e7, -0.449275591851490e8, -0.213133920223355e8,
        0.157076702372204e10, -0.232153488525298e5, -0.395769398304473e10,
    ],
    [  # beta_4
        -0.497217790110754, 0.234980797511405e2, -0.391044251397838e3,
        0.153965820593506e3, 0.152772950743819e6, -0.213755248785646e4,
        -0.400138947092812e4, -0.185949305922308e7, 0.296004865275814e4,
        0.247717810054366e7, 0.101013983339062e6, 0.732341494213578e7,
        -0.147919027644202e8, -0.104092072189767e5, -0.635149929624336e8,
        -0.247435106210237e6, -0.902980378929272e7, 0.724969796807399e7,
        0.487093452892595e9, 0.138088690964946e5, -0.160162178614234e10,
    ],
    [  # beta_6
        0.234146291570999e2, -0.412048043372534e3, 0.319553200392089e4,
        0.573259594331015e4, -0.485212803064813e5, -0.605006113515592e5,
        -0.477173740017567e5, 0.599066486689836e7, -0.110656935176569e5,
        -0.460543580680696e8, 0.203042960322874e7, -0.556606156734835e8,
        0.567424911007837e9, 0.128967058686204e5, -0.152752854956514e10,
        -0.499321746092534e7, 0.132124828143333e9, -0.162359994620983e10,
        0.792526849882218e10, 0.466767581292985e4, -0.128050778279459e11,
    ],
])
# fmt: on

_FITTED = Bivariate(_TERMS, _COEFFICIENTS)
"""beta_3, beta_4 and beta_6 as polynomials of the invariants (Chung and Kwon 2002)."""


_MIXED = ((0, 0), (1, 0), (0, 1), (1, 1), (2, 0))
# fmt: off
_DEPENDENCE = Bivariate(_MIXED, np.array([
    [3 / 175, 12 / 175, 8 / 25, 0.0, 0.0],  # beta_1 by beta_3
    [-3 / 25, 8 / 25, 14 / 25, 0.0, 0.0],  # beta_1 by beta_4
    [-3 / 175, 12 / 175, 24 / 175, -16 / 25, -24 / 175],  # beta_1 by beta_6
    [-6 / 35, -24 / 35, 0.0, 0.0, 0.0],  # beta_2 by beta_3
    [1 / 5, -6 / 5, 0.0, 0.0, 0.0],  # beta_2 by beta_4
    [6 / 35, -24 / 35, -4 / 7, 0.0, 48 / 35],  # beta_2 by beta_6
    [-4 / 5, 0.0, 0.0, 0.0, 0.0],  # beta_5 by beta_3
    [-7 / 5, 0.0, 0.0, 0.0, 0.0],  # beta_5 by beta_4
    [-6 / 5, 8 / 5, 0.0, 0.0, 0.0],  # beta_5 by beta_6
]))
# fmt: on
"""How beta_1, beta_2, beta_5 depend on the fitted three (Chung and Kwon 2002)."""

_CONSTANT = np.array([-3.0 / 35.0, 6.0 / 7.0, 0.0])
"""What is left of beta_1, beta_2, beta_5 when the fitted three vanish: the linear closure."""


@dataclass(frozen=True)
class InvariantLaw:
    """``A`` from the products of I, a and a.a with coefficients that depend on invariants alone.

        A = b1 S(I, I) + b2 S(I, a) + b3 S(a, a) + b4 S(I, a.a) + b5 S(a, a.a) + b6 S(a.a, a.a)

    (Chung and Kwon 2002). b3, b4, b6 are fitted polynomials of II and III; b1, b2, b5 follow from
    ``A_ijkk = a_ij`` by the Cayley-Hamilton theorem. It is a smooth function of the components: no
    eigenframe, nothing special where eigenvalues coincide. In the code A is written as
    ``S(I, inner) + S(a, middle) + b6 S(a.a, a.a)``.
    """

    def fourth(self, a: Array) -> Array:
        """Return ``A``."""
        inner, middle, square, last = _factors(a)
        return (
            symmetric_product(np.broadcast_to(IDENTITY, a.shape), inner)
            + symmetric_product(a, middle)
            + symmetric_product(square, scaled(last, square))
        )

    def fourth_derivative(self, a: Array, da: Array) -> Array:
        """Return the product rule over the three symmetric products."""
        base = a[..., None, :, :]
        middle, square, d_inner, d_middle, d_last = _factor_slopes(a, da)
        return (
            symmetric_product(np.broadcast_to(IDENTITY, d_inner.shape), d_inner)
            + symmetric_product(da, middle)
            + symmetric_product(base, d_middle)
            + symmetric_product(square, d_last)
        )

    def contract(self, a: Array, D: Array) -> Array:
        """Return ``A:D``."""
        inner, middle, square, last = _factors(a)
        return (
            symmetric_product_dot(IDENTITY, inner, D)
            + symmetric_product_dot(a, middle, D)
            + symmetric_product_dot(square, scaled(last, square), D)
        )

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return the product rule over the three symmetric products, contracted."""
        base, rate = a[..., None, :, :], D[..., None, :, :]
        middle, square, d_inner, d_middle, d_last = _factor_slopes(a, da)
        return (
            symmetric_product_dot(IDENTITY, d_inner, rate)
            + symmetric_product_dot(da, middle, rate)
            + symmetric_product_dot(base, d_middle, rate)
            + symmetric_product_dot(square, d_last, rate)
        )


def _factors(a: Array) -> tuple[Array, Array, Array, Array]:
    """Return ``b1 I + b2 a + b4 a.a``, ``b3 a + b5 a.a``, ``a.a`` and b6."""
    second, third = _invariants(a)
    fitted = _FITTED.value(second, third)
    b3, b4, b6 = (fitted[..., k] for k in range(3))
    dependent = _CONSTANT + _times(_DEPENDENCE.value(second, third), fitted)
    b1, b2, b5 = (dependent[..., k] for k in range(3))
    square = a @ a
    inner = scaled(b1, IDENTITY) + scaled(b2, a) + scaled(b4, square)
    return inner, scaled(b3, a) + scaled(b5, square), square, b6


def _factor_slopes(a: Array, da: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return ``middle`` and ``a.a``, and what ``d inner``, ``d middle``, ``d(b6 ...)`` need.

    All have an axis for the directions. The last is X of ``d[b6 S(a.a, a.a)] = S(a.a, X)``.
    """
    base = a[..., None, :, :]
    second, third = _invariants(base)
    fitted = _FITTED.value(second, third)
    dependence = _DEPENDENCE.value(second, third)
    dependent = _CONSTANT + _times(dependence, fitted)
    d_second = np.trace(da, axis1=-2, axis2=-1) - double_dot(base, da)
    d_third = double_dot(cofactor(base), da)
    d_fitted = _along(_FITTED.slopes(second, third), d_second, d_third)
    d_dependence = _along(_DEPENDENCE.slopes(second, third), d_second, d_third)
    d_dependent = _times(dependence, d_fitted) + _times(d_dependence, fitted)
    b3, b4, b6 = (fitted[..., k] for k in range(3))
    _, b2, b5 = (dependent[..., k] for k in range(3))
    d3, d4, d6 = (d_fitted[..., k] for k in range(3))
    d1, d2, d5 = (d_dependent[..., k] for k in range(3))
    square = base @ base
    d_square = base @ da + da @ base
    middle = scaled(b3, base) + scaled(b5, square)
    d_inner = scaled(d1, IDENTITY) + scaled(d2, base) + scaled(d4, square)
    d_inner = d_inner + scaled(b2, da) + scaled(b4, d_square)
    d_middle = scaled(d3, base) + scaled(d5, square) + scaled(b3, da) + scaled(b5, d_square)
    return middle, square, d_inner, d_middle, scaled(d6, square) + scaled(2.0 * b6, d_square)


def _invariants(a: Array) -> tuple[Array, Array]:
    """Return ``II = tr cof(a)``, which is (1 - a:a)/2 for trace 1, and ``III = det a``."""
    cof = cofactor(a)
    third: Array = np.einsum("...j,...j->...", a[..., 0, :], cof[..., 0, :])
    return np.trace(cof, axis1=-2, axis2=-1), third


def _times(matrix: Array, vector: Array) -> Array:
    """Return the rows of a flattened 3x3 matrix times a vector, shape (..., 3)."""
    square = matrix.reshape(*matrix.shape[:-1], 3, 3)
    result: Array = np.einsum("...ij,...j->...i", square, vector)
    return result


def _along(slopes: tuple[Array, Array], d_second: Array, d_third: Array) -> Array:
    """Return the chain rule over the two invariants."""
    by_second, by_third = slopes
    result: Array = d_second[..., None] * by_second + d_third[..., None] * by_third
    return result
