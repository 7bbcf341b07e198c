"""Rotary diffusion tensors ``C``, each a model of its own.

How ``C`` enters the rate is in `fibermelt.orientation.diffusion`.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.orientation.diffusion import AnisotropicDiffusion, InteractingDiffusion
from fibermelt.orientation.flows import shear_rate
from fibermelt.orientation.frames import PrincipalFrame, oriented, oriented_derivative
from fibermelt.orientation.kinetics import symmetric_product

__all__ = ["ARDRSC", "IARD", "MRD", "PARD"]

Array = NDArray[np.float64]

IDENTITY = np.eye(3)


def _unit_strain(D: Array) -> Array:
    """Return ``D/gamma_dot`` [-]; zero where nothing is strained, where no diffusion is either."""
    rate = shear_rate(D)[..., None, None]
    return D / np.where(rate > 0.0, rate, 1.0)


@dataclass(frozen=True)
class ARDRSC(AnisotropicDiffusion):
    """Phelps and Tucker's diffusion tensor, with reduced strain.

    ``C = b_1 I + b_2 a + b_3 a a + b_4 D/gamma_dot + b_5 D D/gamma_dot^2``. The coefficients are
    fitted together, and the negative of any but the first is common: ``C`` is then not positive
    definite for every ``a``, which is lawful as long as no direction ``n`` without fibers is
    emptied further, see `fibermelt.orientation.diffusion`. There ``a n = 0`` and
    ``C_nn = b_1 + b_4 D_nn/gamma_dot + b_5 |D n|^2/gamma_dot^2`` must not be negative. Across a
    planar flow that is ``b_1``, which is therefore bounded here; the rest depends on the flow.

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-].
    b1, b2, b3, b4, b5 : float
        Coefficients [-], not all zero, the first not negative; ``b1`` alone is Folgar-Tucker's
        ``C_I`` (RSC's below ``kappa = 1``).
    kappa : float
        Strain reduction factor [-], in (0, 1].
    convention : {"standard", "paper"}
        Which ``gamma_dot`` multiplies ``C``.

    References
    ----------
    Phelps and Tucker 2009, doi 10.1016/j.jnnfm.2008.08.002.
    """

    b1: float
    b2: float = 0.0
    b3: float = 0.0
    b4: float = 0.0
    b5: float = 0.0
    kappa: float = 1.0
    name: ClassVar[str] = "ard-rsc"
    way_out: ClassVar[str] = "raise b1, or bring b4 and b5 nearer to 0"
    source: ClassVar[str] = "Phelps and Tucker 2009, doi 10.1016/j.jnnfm.2008.08.002"

    def __post_init__(self) -> None:
        """Refuse coefficients that are no numbers or no diffusion, and a bad ``kappa``."""
        super().__post_init__()
        largest = np.finfo(np.float64).max
        for key in ("b1", "b2", "b3", "b4", "b5"):
            self._bounded(key, -largest, largest, "a finite coefficient")
        if self.b1 < 0.0:
            msg = (
                f"{self.name}: b1 = {self.b1:g} must not be negative: across a planar flow it is "
                "all the diffusion that fibers in its plane have, and would take more fibers from "
                "where there are none"
            )
            raise ConfigError(msg)
        if self.strength == 0.0:
            msg = f"{self.name}: b1 to b5 are all 0: give b1 > 0, or take the model 'jeffery'"
            raise ConfigError(msg)
        self._bounded("kappa", 0.0, 1.0, "1 does not slow")
        self._positive("kappa", "at 0 no eigenvalue would ever change")

    @property
    def retardation(self) -> float:
        """Return ``kappa`` [-]."""
        return self.kappa

    @property
    def strength(self) -> float:
        """Return a bound of ``|C|`` [-]: ``|D|/gamma_dot`` is below one."""
        return abs(self.b1) + abs(self.b2) + abs(self.b3) + abs(self.b4) + abs(self.b5)

    def scaled(self, factor: float) -> Self:
        """Return the same model with ``factor`` times every coefficient."""
        b = (factor * value for value in (self.b1, self.b2, self.b3, self.b4, self.b5))
        b1, b2, b3, b4, b5 = b
        return replace(self, b1=b1, b2=b2, b3=b3, b4=b4, b5=b5)

    def without_retardation(self) -> ARDRSC:
        """Return the model with ``kappa = 1``, which has the same steady states."""
        return replace(self, kappa=1.0)

    def diffusion_tensor(self, a: Array, D: Array) -> Array:
        """Return ``C`` [-], (..., 3, 3)."""
        unit = _unit_strain(D)
        C: Array = self.b1 * IDENTITY + self.b2 * a + self.b3 * (a @ a)
        return C + self.b4 * unit + self.b5 * (unit @ unit)

    def diffusion_tensor_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return the derivatives of ``C`` along ``da``, (..., k, 3, 3)."""
        del D
        return self.b2 * da + self.b3 * symmetric_product(a[..., None, :, :], da)


@dataclass(frozen=True)
class IARD(InteractingDiffusion):
    """Diffusion that the strain takes from its own directions.

    ``C = C_I (I - C_M D D/||D D||)``, ``||D D|| = sqrt(D D:D D/2)``. In simple shear that is
    ``C_I diag(1 - C_M, 1 - C_M, 1)``. In uniaxial elongation it is ``1 - 4 C_M/3`` along the
    stretch, negative above ``C_M = 3/4``, which is refused there.

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-].
    interaction : float
        ``C_I`` [-], positive.
    anisotropy : float
        ``C_M`` [-], in [0, 1]; 0 is Folgar-Tucker.
    convention : {"standard", "paper"}
        Which ``gamma_dot`` multiplies ``C``.

    References
    ----------
    Tseng, Chang and Hsu 2016, doi 10.1122/1.4939098.
    """

    anisotropy: float
    name: ClassVar[str] = "iard"
    way_out: ClassVar[str] = "take an anisotropy of at most 3/4, which serves every flow"
    source: ClassVar[str] = "Tseng, Chang and Hsu 2016, doi 10.1122/1.4939098"

    def __post_init__(self) -> None:
        """Refuse an anisotropy outside [0, 1]."""
        super().__post_init__()
        self._bounded("anisotropy", 0.0, 1.0, "0 is Folgar-Tucker")

    def diffusion_tensor(self, a: Array, D: Array) -> Array:
        """Return ``C`` [-], (..., 3, 3)."""
        del a
        unit = _unit_strain(D)
        square = unit @ unit
        size = np.sqrt(0.5 * np.einsum("...ij,...ij->...", square, square))[..., None, None]
        taken: Array = square / np.where(size > 0.0, size, 1.0)
        return self.interaction * (IDENTITY - self.anisotropy * taken)


@dataclass(frozen=True)
class _AlongFibers(InteractingDiffusion):
    """A diffusion tensor with the eigenvectors of ``a``: ``C_I sum_i w_i e_i e_i``.

    Where eigenvalues coincide, see `fibermelt.orientation.frames`: the law jumps there (two states
    that differ by rounding diffuse differently), which no choice can mend.
    """

    def refuse_flow(self, D: Array) -> None:
        """Take any flow: no weight is negative."""
        del D

    @property
    @abstractmethod
    def weights(self) -> tuple[float, float, float]:
        """Return the weights [-] of the principal directions, the most populated one first."""

    def diffusion_tensor(self, a: Array, D: Array) -> Array:
        """Return ``C`` [-], (..., 3, 3)."""
        return self.interaction * oriented(PrincipalFrame.of(a, D), np.array(self.weights))

    def diffusion_tensor_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return the derivatives of ``C`` along ``da``, (..., k, 3, 3)."""
        frame = PrincipalFrame.of(a, D)
        return self.interaction * oriented_derivative(frame, np.array(self.weights), da)


@dataclass(frozen=True)
class PARD(_AlongFibers):
    """Diffusion along the principal directions, ``C = C_I V diag(1, Omega, 1 - Omega) V^T``.

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-].
    interaction : float
        ``C_I`` [-], positive.
    anisotropy : float
        ``Omega`` [-], in [1/2, 1].
    convention : {"standard", "paper"}
        Which ``gamma_dot`` multiplies ``C``.

    References
    ----------
    Tseng, Chang and Hsu 2018, doi 10.1122/1.4998520.
    """

    anisotropy: float
    name: ClassVar[str] = "pard"
    source: ClassVar[str] = "Tseng, Chang and Hsu 2018, doi 10.1122/1.4998520"

    def __post_init__(self) -> None:
        """Refuse an anisotropy outside [1/2, 1]."""
        super().__post_init__()
        self._bounded("anisotropy", 0.5, 1.0, "below 1/2 the second direction is the third")

    @property
    def weights(self) -> tuple[float, float, float]:
        """Return ``(1, Omega, 1 - Omega)`` [-]."""
        return 1.0, self.anisotropy, 1.0 - self.anisotropy


@dataclass(frozen=True)
class MRD(_AlongFibers):
    """Diffusion along the principal directions, ``C = C_I V diag(D_1, D_2, D_3) V^T``.

    The vendor's documentation gives the three defaults; that ``C`` enters the moment equation of
    Phelps and Tucker as it does in the other models is ``fiberoripy``'s reading, followed here: the
    proceedings paper could not be compared.

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-].
    interaction : float
        ``C_I`` [-], positive.
    first, second, third : float
        ``D_1, D_2, D_3`` [-], positive.
    convention : {"standard", "paper"}
        Which ``gamma_dot`` multiplies ``C``.

    References
    ----------
    Bakharev, Yu, Speight and Wang, SPE ANTEC, Orlando, 2018.
    """

    first: float = 1.0
    second: float = 0.8
    third: float = 0.15
    name: ClassVar[str] = "mrd"
    source: ClassVar[str] = "Bakharev, Yu, Speight and Wang, SPE ANTEC, Orlando, 2018"

    def __post_init__(self) -> None:
        """Refuse factors that are not positive."""
        super().__post_init__()
        for key in ("first", "second", "third"):
            self._positive(key, "factors of diffusion, by default 1, 0.8 and 0.15")

    @property
    def weights(self) -> tuple[float, float, float]:
        """Return ``(D_1, D_2, D_3)`` [-]."""
        return self.first, self.second, self.third
