"""Orientation models, from Jeffery to anisotropic diffusion, with exact Jacobians.

In every model the strength of diffusion is ``C gamma_dot``: ``convention`` says with which
``gamma_dot`` (see `fibermelt.orientation.kinetics.CONVENTIONS`), ``"standard"`` being
``sqrt(2 D:D)``. It enters that product only; the strain rate inside a diffusion tensor is always
scaled with the standard one. Dimension three throughout: the paper's ``alpha`` of Eq. 26 is 3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.orientation.anisotropic import ARDRSC, IARD, MRD, PARD
from fibermelt.orientation.flows import nearest_name
from fibermelt.orientation.kinetics import (
    ClosureLike,
    Convention,
    OrientationModel,
    checked_convention,
    diffusion_rate,
    jeffery_derivative,
    jeffery_rate,
    shape_factor,
    symmetric_product,
)

__all__ = [
    "ARDRSC",
    "IARD",
    "MODELS",
    "MRD",
    "PARD",
    "RSC",
    "FolgarTucker",
    "Jeffery",
    "Nematic",
    "OrientationModel",
    "model_class",
    "shape_factor",
]

Array = NDArray[np.float64]

IDENTITY = np.eye(3)


@dataclass(frozen=True)
class Jeffery(OrientationModel):
    """Fibers that do not meet: ``a_dot = W a - a W + xi (D a + a D - 2 A:D)``.

    References
    ----------
    Jeffery 1922, doi 10.1098/rspa.1922.0078; as moments: Advani and Tucker 1987,
    doi 10.1122/1.549945.
    """

    name: ClassVar[str] = "jeffery"
    source: ClassVar[str] = "Jeffery 1922, doi 10.1098/rspa.1922.0078"

    def _unretarded(self, a: Array, D: Array, W: Array, closure: ClosureLike) -> Array:
        return jeffery_rate(self.shape_factor, a, D, W, closure)

    def _unretarded_derivative(
        self, a: Array, D: Array, W: Array, closure: ClosureLike, da: Array
    ) -> Array:
        return jeffery_derivative(self.shape_factor, a, D, W, closure, da)


@dataclass(frozen=True)
class FolgarTucker(OrientationModel):
    """Isotropic rotary diffusion: Jeffery and ``2 C_I gamma_dot (I - 3 a)`` (the paper's Eq. 26).

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-].
    interaction : float
        ``C_I`` [-], positive.
    convention : {"standard", "paper"}
        Which ``gamma_dot`` multiplies it.

    References
    ----------
    Folgar and Tucker 1984, doi 10.1177/073168448400300201; Advani and Tucker 1987,
    doi 10.1122/1.549945.
    """

    interaction: float
    convention: Convention = field(default="standard", kw_only=True)
    name: ClassVar[str] = "folgar-tucker"
    source: ClassVar[str] = "Folgar and Tucker 1984, doi 10.1177/073168448400300201"

    def __post_init__(self) -> None:
        """Refuse a coefficient that is not positive, and an unknown convention."""
        super().__post_init__()
        self._positive("interaction", "take the model 'jeffery' for fibers that do not interact")
        checked_convention(self.name, self.convention)

    @property
    def strength(self) -> float:
        """Return ``C_I`` [-]."""
        return self.interaction

    def scaled(self, factor: float) -> Self:
        """Return the same model with ``factor`` times ``C_I``."""
        return replace(self, interaction=factor * self.interaction)

    def _unretarded(self, a: Array, D: Array, W: Array, closure: ClosureLike) -> Array:
        diffusion = (2.0 * self.interaction) * diffusion_rate(D, self.convention)
        return jeffery_rate(self.shape_factor, a, D, W, closure) + diffusion * (IDENTITY - 3.0 * a)

    def _unretarded_derivative(
        self, a: Array, D: Array, W: Array, closure: ClosureLike, da: Array
    ) -> Array:
        diffusion = (2.0 * self.interaction) * diffusion_rate(D, self.convention)[..., None, :, :]
        turned = jeffery_derivative(self.shape_factor, a, D, W, closure, da)
        return turned - 3.0 * diffusion * da


@dataclass(frozen=True)
class RSC(FolgarTucker):
    """Reduced strain closure: Folgar-Tucker whose eigenvalues change ``kappa`` times as fast.

    ``a_dot = W a - a W + xi (D a + a D - 2 [A + (1 - kappa)(L - M:A)]:D)
    + 2 kappa C_I gamma_dot (I - 3 a)``: the same steady states, reached later.

    Where eigenvalues of ``a`` coincide the eigenvectors are not unique, and the limit along the
    path of the tensor is taken: there the whole rate is slowed. (``fiberoripy`` takes whatever
    vectors the eigensolver gives: from an isotropic start its first rate is that of
    Folgar-Tucker in part, and depends on the frame of the observer.)

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-].
    interaction : float
        ``C_I`` [-], positive.
    kappa : float
        Strain reduction factor [-], in (0, 1]; 1 is Folgar-Tucker.
    convention : {"standard", "paper"}
        Which ``gamma_dot`` multiplies it.

    References
    ----------
    Wang, O'Gara and Tucker 2008, doi 10.1122/1.2946437.
    """

    kappa: float
    name: ClassVar[str] = "rsc"
    source: ClassVar[str] = "Wang, O'Gara and Tucker 2008, doi 10.1122/1.2946437"

    def __post_init__(self) -> None:
        """Refuse a reduction outside (0, 1]."""
        super().__post_init__()
        self._bounded("kappa", 0.0, 1.0, "1 is Folgar-Tucker")
        self._positive("kappa", "at 0 no eigenvalue would ever change")

    @property
    def retardation(self) -> float:
        """Return ``kappa`` [-]."""
        return self.kappa

    def without_retardation(self) -> FolgarTucker:
        """Return the Folgar-Tucker model with the same steady states."""
        return FolgarTucker(self.shape_factor, self.interaction, convention=self.convention)


@dataclass(frozen=True)
class Nematic(FolgarTucker):
    """Folgar-Tucker with the Maier-Saupe potential, which aligns fibers with one another.

    Adds ``2 U_0 gamma_dot (a a - A:a)``. Near isotropy the diffusion and the potential
    together change a small anisotropy at the rate ``gamma_dot (2 U_0/5 - 6 C_I)``: with no
    other strain terms isotropy is stable below ``U_0 = 15 C_I`` in three dimensions (in two the
    same equation has 8 C_I, the bound ``fiberoripy`` states for three).

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-].
    interaction : float
        ``C_I`` [-], positive.
    potential : float
        ``U_0`` [-], not negative; 0 is Folgar-Tucker.
    convention : {"standard", "paper"}
        Which ``gamma_dot`` multiplies both.

    References
    ----------
    Latz, Strautins and Niedziela 2010, doi 10.1016/j.jnnfm.2010.04.001.
    """

    potential: float
    name: ClassVar[str] = "nematic"
    source: ClassVar[str] = "Latz, Strautins and Niedziela 2010, doi 10.1016/j.jnnfm.2010.04.001"

    def __post_init__(self) -> None:
        """Refuse a potential that drives fibers apart."""
        super().__post_init__()
        self._bounded("potential", 0.0, np.finfo(np.float64).max, "0 is Folgar-Tucker")

    def _unretarded(self, a: Array, D: Array, W: Array, closure: ClosureLike) -> Array:
        aligning = (2.0 * self.potential) * diffusion_rate(D, self.convention)
        whole = super()._unretarded(a, D, W, closure)
        return whole + aligning * (a @ a - closure.contract(a, a))

    def _unretarded_derivative(
        self, a: Array, D: Array, W: Array, closure: ClosureLike, da: Array
    ) -> Array:
        aligning = (2.0 * self.potential) * diffusion_rate(D, self.convention)[..., None, :, :]
        change = super()._unretarded_derivative(a, D, W, closure, da)
        wide = np.broadcast_to(a[..., None, :, :], da.shape)
        closed = closure.contract_derivative(a, a, da) + closure.contract(wide, da)
        return change + aligning * (symmetric_product(wide, da) - closed)


MODELS: Mapping[str, type[OrientationModel]] = MappingProxyType(
    {kind.name: kind for kind in (Jeffery, FolgarTucker, RSC, ARDRSC, IARD, PARD, MRD, Nematic)}
)
"""Orientation models by name."""


def model_class(name: str) -> type[OrientationModel]:
    """Return the class of a model of `MODELS`.

    Raises
    ------
    ConfigError
        If there is none of that name; the message has the nearest.
    """
    if not isinstance(name, str) or name not in MODELS:
        raise ConfigError(nearest_name("orientation model", name, MODELS))
    return MODELS[name]
