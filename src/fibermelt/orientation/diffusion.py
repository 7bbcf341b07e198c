"""The moment equation of an anisotropic rotary diffusion tensor ``C``.

All share the moment equation of Phelps and Tucker 2009 (doi 10.1016/j.jnnfm.2008.08.002),

``diffusion = gamma_dot [2 C - 2 (tr C) a - 5 (C a + a C) + 10 A:C]``,

and differ in ``C``. With ``C = C_I I`` it is ``2 C_I gamma_dot (I - 3 a)`` for every closure that
keeps ``A:I = a``. A ``C`` that is not positive definite diffuses backwards in some direction. True
moments leave the range that fibers can have exactly if that is a direction ``n`` without fibers:
there ``a n = 0``, of ``n.a_dot n`` all terms vanish but the first (Jeffery's, too), and what is
left, ``2 gamma_dot C_nn``, makes ``a_nn`` negative.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.orientation.kinetics import (
    ClosureLike,
    Convention,
    OrientationModel,
    checked_convention,
    diffusion_rate,
    symmetric_product,
)

__all__ = ["AnisotropicDiffusion", "InteractingDiffusion"]

Array = NDArray[np.float64]

ROUNDING = 1e-14
"""Part of the strength by which an eigenvalue of ``C`` is off."""


@dataclass(frozen=True)
class AnisotropicDiffusion(OrientationModel):
    """Jeffery's terms and the diffusion of the module's docstring."""

    convention: Convention = field(default="standard", kw_only=True)
    way_out: ClassVar[str] = "take less of what is negative"

    def __post_init__(self) -> None:
        """Refuse an unknown convention."""
        super().__post_init__()
        checked_convention(self.name, self.convention)

    @abstractmethod
    def diffusion_tensor(self, a: Array, D: Array) -> Array:
        """Return ``C`` [-], (..., 3, 3), for strain rates ``D`` [1/s]."""

    def refuse_flow(self, D: Array) -> None:
        """Refuse strain rates (..., 3, 3) [1/s] in which a direction without fibers is emptied.

        ``C`` of a direction that ``a`` does not reach is that of ``a = 0``: what it has of ``a``
        vanishes there.

        Raises
        ------
        ConfigError
            If ``C`` is negative along some direction.
        """
        C = self.diffusion_tensor(np.zeros_like(D), D)
        least = np.linalg.eigvalsh(C)[..., 0]
        if np.any(least < -ROUNDING * self.strength):
            msg = (
                f"{self.name}: along a direction of this flow the diffusion is {np.min(least):.4g} "
                "even while no fibers lie there, and would take away more: must not be negative; "
                f"{self.way_out}"
            )
            raise ConfigError(msg)

    def diffusion_tensor_derivative(self, a: Array, D: Array, da: Array) -> Array | None:
        """Return the derivatives of ``C`` along ``da`` (..., k, 3, 3); None if it has none."""
        del a, D, da
        return None

    def _parts(self, a: Array, D: Array, W: Array) -> tuple[Array, Array, Array]:
        """Return ``gamma_dot C``, what multiplies ``a`` from the left, and what ``A``."""
        C = diffusion_rate(D, self.convention) * self.diffusion_tensor(a, D)
        xi = self.shape_factor
        return C, W + xi * D - 5.0 * C, 10.0 * C - (2.0 * xi) * D

    def _unretarded(self, a: Array, D: Array, W: Array, closure: ClosureLike) -> Array:
        C, B, closed = self._parts(a, D, W)
        trace = np.trace(C, axis1=-2, axis2=-1)[..., None, None]
        whole: Array = symmetric_product(B, a) + 2.0 * (C - trace * a) + closure.contract(a, closed)
        return whole

    def _unretarded_derivative(
        self, a: Array, D: Array, W: Array, closure: ClosureLike, da: Array
    ) -> Array:
        C, B, closed = self._parts(a, D, W)
        trace = np.trace(C, axis1=-2, axis2=-1)[..., None, None, None]
        change: Array = symmetric_product(B[..., None, :, :], da) - 2.0 * trace * da
        change = change + closure.contract_derivative(a, closed, da)
        dC = self.diffusion_tensor_derivative(a, D, da)
        if dC is None:
            return change
        dC = diffusion_rate(D, self.convention)[..., None, :, :] * dC
        wide = np.broadcast_to(a[..., None, :, :], dC.shape)
        lost = np.trace(dC, axis1=-2, axis2=-1)[..., None, None]
        turned = 2.0 * (dC - lost * wide) - 5.0 * symmetric_product(dC, wide)
        change += turned + 10.0 * closure.contract(wide, dC)
        return change


@dataclass(frozen=True)
class InteractingDiffusion(AnisotropicDiffusion):
    """A diffusion tensor proportional to one interaction coefficient."""

    interaction: float

    def __post_init__(self) -> None:
        """Refuse a coefficient that is not positive."""
        super().__post_init__()
        self._positive("interaction", "take the model 'jeffery' for fibers that do not interact")

    @property
    def strength(self) -> float:
        """Return ``C_I`` [-]."""
        return self.interaction

    def scaled(self, factor: float) -> Self:
        """Return the same model with ``factor`` times ``C_I``."""
        return replace(self, interaction=factor * self.interaction)
