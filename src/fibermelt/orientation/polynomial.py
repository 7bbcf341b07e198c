"""Closures that are polynomials of the tensor itself: linear, quadratic, hybrid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.orientation.products import (
    IDENTITY,
    cofactor,
    double_dot,
    scaled,
    symmetric_part,
    symmetric_product,
)

__all__ = ["HybridLaw", "LinearLaw", "QuadraticLaw"]

Array = NDArray[np.float64]

_ISOTROPIC_PAIR = symmetric_product(IDENTITY, IDENTITY)
"""``S(I, I) = (d_ij d_kl + d_ik d_jl + d_il d_jk)/3``; a fifth of it is the isotropic A."""


@dataclass(frozen=True)
class LinearLaw:
    """``A = 6/7 S(I, a) - 3/35 S(I, I)`` (Hand 1962; Advani and Tucker 1987).

    Exact for random orientation; what every fully symmetric, normalised A has in common: the rest
    has no trace over any two indices.
    """

    def fourth(self, a: Array) -> Array:
        """Return ``A``."""
        result: Array = 6.0 / 7.0 * symmetric_product(IDENTITY, a) - 3.0 / 35.0 * _ISOTROPIC_PAIR
        return result

    def fourth_derivative(self, a: Array, da: Array) -> Array:
        """Return ``6/7 S(I, da)``, the same for every a."""
        shape = (*np.broadcast_shapes(a.shape[:-2], da.shape[:-3]), *da.shape[-3:], 3, 3)
        return np.broadcast_to(6.0 / 7.0 * symmetric_product(IDENTITY, da), shape)

    def contract(self, a: Array, D: Array) -> Array:
        """Return ``[a tr D + I (a:D) + 2 (aD + Da)]/7 - [I tr D + 2 D]/35``."""
        trace = np.trace(D, axis1=-2, axis2=-1)
        constant = (scaled(trace, IDENTITY) + 2.0 * D) / 35.0
        return self._homogeneous(a, D) - constant

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return ``[da tr D + I (da:D) + 2 (da D + D da)]/7``."""
        result = self._homogeneous(da, D[..., None, :, :])
        shape = (*np.broadcast_shapes(a.shape[:-2], result.shape[:-3]), *result.shape[-3:])
        return np.broadcast_to(result, shape)

    @staticmethod
    def _homogeneous(a: Array, D: Array) -> Array:
        """Return ``6/7 S(I, a):D``."""
        trace = np.trace(D, axis1=-2, axis2=-1)
        product = a @ D
        result: Array = (4.0 / 7.0) * symmetric_part(product)
        if np.any(trace):
            result = result + scaled(trace, a) / 7.0
        along = double_dot(a, D) / 7.0
        for i in range(3):
            result[..., i, i] += along
        return result


@dataclass(frozen=True)
class QuadraticLaw:
    """``A_ijkl = a_ij a_kl`` (Doi 1981): exact for perfectly aligned fibers, not symmetric."""

    def fourth(self, a: Array) -> Array:
        """Return ``A``."""
        result: Array = np.einsum("...ij,...kl->...ijkl", a, a)
        return result

    def fourth_derivative(self, a: Array, da: Array) -> Array:
        """Return ``da_ij a_kl + a_ij da_kl``."""
        base = a[..., None, :, :]
        first: Array = np.einsum("...ij,...kl->...ijkl", da, base)
        second: Array = np.einsum("...ij,...kl->...ijkl", base, da)
        return first + second

    def contract(self, a: Array, D: Array) -> Array:
        """Return ``a (a:D)``."""
        return scaled(double_dot(a, D), a)

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return ``da (a:D) + a (da:D)``."""
        along = double_dot(a, D)[..., None]
        return scaled(along, da) + scaled(double_dot(da, D[..., None, :, :]), a[..., None, :, :])


@dataclass(frozen=True)
class HybridLaw:
    """``A = (1 - f) A_linear + f A_quadratic``, ``f = 1 - 27 det a`` (Advani and Tucker 1990)."""

    linear: LinearLaw = LinearLaw()
    quadratic: QuadraticLaw = QuadraticLaw()

    def fourth(self, a: Array) -> Array:
        """Return ``A``."""
        randomness = self._randomness(a)[..., None, None, None, None]
        quadratic = self.quadratic.fourth(a)
        result: Array = quadratic + randomness * (self.linear.fourth(a) - quadratic)
        return result

    def fourth_derivative(self, a: Array, da: Array) -> Array:
        """Return the product rule's three terms."""
        fourfold = (..., None, None, None, None)
        randomness = self._randomness(a)[..., None][fourfold]
        slope = self._slope(a, da)[fourfold]
        jump = (self.linear.fourth(a) - self.quadratic.fourth(a))[..., None, :, :, :, :]
        quadratic = self.quadratic.fourth_derivative(a, da)
        change = self.linear.fourth_derivative(a, da) - quadratic
        result: Array = quadratic + randomness * change + slope * jump
        return result

    def contract(self, a: Array, D: Array) -> Array:
        """Return ``A:D``."""
        quadratic = self.quadratic.contract(a, D)
        return quadratic + scaled(self._randomness(a), self.linear.contract(a, D) - quadratic)

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return the product rule's three terms, contracted."""
        jump = (self.linear.contract(a, D) - self.quadratic.contract(a, D))[..., None, :, :]
        quadratic = self.quadratic.contract_derivative(a, D, da)
        change = self.linear.contract_derivative(a, D, da) - quadratic
        randomness = self._randomness(a)[..., None]
        return quadratic + scaled(randomness, change) + scaled(self._slope(a, da), jump)

    @staticmethod
    def _randomness(a: Array) -> Array:
        """Return ``1 - f = 27 det a``: 1 for random fibers, 0 for planar and aligned ones."""
        a11, a22, a33 = a[..., 0, 0], a[..., 1, 1], a[..., 2, 2]
        a12, a13, a23 = a[..., 0, 1], a[..., 0, 2], a[..., 1, 2]
        det: Array = a11 * (a22 * a33 - a23 * a23) - a12 * (a12 * a33 - a13 * a23)
        det = det + a13 * (a12 * a23 - a13 * a22)
        return 27.0 * det

    @staticmethod
    def _slope(a: Array, da: Array) -> Array:
        """Return ``d(27 det a)`` along each direction, shape (..., k)."""
        return 27.0 * double_dot(cofactor(a)[..., None, :, :], da)
