"""What all orientation models share: Jeffery's terms, diffusion, retardation, exact derivatives.

Every model has the form ``a_dot = X - (1 - kappa) M:X`` with

``X = W a - a W + xi (D a + a D - 2 A:D) + diffusion``

(the paper's Eq. 26 with the halves put right), ``M`` the projector on the principal directions of
``a`` and ``A`` the closed fourth moment. With ``L = sum_i lambda_i e_i e_i e_i e_i`` written out
this is the reduced-strain form of the literature, because ``M:(D a + a D) = 2 L:D``.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from typing import ClassVar, Literal, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, refuse_no_number, refuse_other
from fibermelt.orientation.flows import nearest_name, shear_rate, strain_and_spin
from fibermelt.orientation.frames import PrincipalFrame, pinched, pinched_derivative
from fibermelt.orientation.tensors import TANGENTS, pack

__all__ = ["ClosureLike", "Convention", "OrientationModel", "shape_factor"]

Array = NDArray[np.float64]
Convention = Literal["standard", "paper"]

CONVENTIONS: dict[str, float] = {"standard": 1.0, "paper": math.sqrt(2.0)}
"""Rate that multiplies ``C_I``, over ``gamma_dot = sqrt(2 D:D)``: the paper's Eq. 33 was computed
with ``sqrt(G:G)``, ``G = grad v + grad v^T = 2 D``, which is ``sqrt(2)`` times as large."""


class ClosureLike(Protocol):
    """What a model asks of a closure (see `fibermelt.orientation.closures.Closure`)."""

    @property
    def name(self) -> str:
        """What messages call it."""

    def contract(self, a: Array, D: Array) -> Array:
        """Return ``A:D`` (..., 3, 3)."""

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return the derivatives of ``A:D`` along ``da`` (..., k, 3, 3)."""


def shape_factor(aspect_ratio: float) -> float:
    """Return Bretherton's ``xi = (r_e^2 - 1)/(r_e^2 + 1)`` [-] of a spheroid.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], positive; below one for a disc.

    Raises
    ------
    ConfigError
        If it is not positive.

    References
    ----------
    Bretherton 1962, doi 10.1017/S002211206200124X; the paper's Eq. 26.
    """
    refuse_no_number("aspect_ratio", aspect_ratio)
    if not (math.isfinite(aspect_ratio) and aspect_ratio > 0.0):
        msg = f"aspect_ratio = {aspect_ratio:g}: must be positive, e.g. 6"
        raise ConfigError(msg)
    square = float(aspect_ratio) * float(aspect_ratio)
    # beyond 1e154 the square overflows: 1 is then right to the last bit, as it is from 1e9 on
    return (square - 1.0) / (square + 1.0) if square < math.inf else 1.0


@dataclasses.dataclass(frozen=True)
class OrientationModel(ABC):
    """A law for the rate of the second-order orientation tensor.

    ``rate`` and ``derivative`` do not look at their input: `steady_state` and
    `follow_orientation` check it once.

    Parameters
    ----------
    shape_factor : float
        ``xi`` [-], in [-1, 1]: 1 a slender fiber, 0 a sphere, -1 a disc (see `shape_factor`).
    """

    shape_factor: float
    name: ClassVar[str]
    source: ClassVar[str]

    def __post_init__(self) -> None:
        """Refuse a shape that no fiber has."""
        self._bounded("shape_factor", -1.0, 1.0, "(r_e^2 - 1)/(r_e^2 + 1)")

    @property
    def retardation(self) -> float:
        """Return ``kappa`` [-]: what slows the eigenvalues, 1 where nothing does."""
        return 1.0

    @property
    def strength(self) -> float:
        """Return the size of the diffusion over the shear rate [-]; 0 without diffusion."""
        return 0.0

    def scaled(self, factor: float) -> Self:
        """Return the same model with ``factor`` times the diffusion."""
        del factor
        return self

    def refuse_flow(self, D: Array) -> None:
        """Refuse strain rates (..., 3, 3) [1/s] in which the law has no sense; here none."""
        del D

    def rate(self, a: Array, L: Array, closure: ClosureLike) -> Array:
        """Return ``a_dot`` [1/s], (..., 3, 3).

        Parameters
        ----------
        a : (..., 3, 3) array
            Orientation tensors, symmetric, trace 1.
        L : (..., 3, 3) array
            Velocity gradients [1/s], without trace.
        closure : ClosureLike
            What closes the fourth moment.
        """
        a, L = np.broadcast_arrays(a, L)
        D, W = strain_and_spin(L)
        whole = self._unretarded(a, D, W, closure)
        if self.retardation != 1.0:
            whole = whole - (1.0 - self.retardation) * pinched(PrincipalFrame.of(a, D), whole)
        # symmetric to the last bit: no law holds a skew part down, over long times rounding grows
        symmetric: Array = 0.5 * (whole + whole.swapaxes(-1, -2))
        return symmetric

    def derivative(self, a: Array, L: Array, closure: ClosureLike, da: Array) -> Array:
        """Return the derivatives of ``a_dot`` along ``da`` [1/s], (..., k, 3, 3).

        Parameters
        ----------
        a, L, closure
            As in `rate`.
        da : (..., k, 3, 3) array
            Symmetric traceless directions.
        """
        a, L = np.broadcast_arrays(a, L)
        da = np.broadcast_to(da, (*a.shape[:-2], *da.shape[-3:]))
        D, W = strain_and_spin(L)
        change = self._unretarded_derivative(a, D, W, closure, da)
        if self.retardation == 1.0:
            return change
        whole = self._unretarded(a, D, W, closure)
        frame = PrincipalFrame.of(a, D)
        return change - (1.0 - self.retardation) * pinched_derivative(frame, whole, change, da)

    def jacobian(self, a: Array, L: Array, closure: ClosureLike) -> Array:
        """Return ``d a_dot/d a`` in the components of `tensors.pack` [1/s], (..., 5, 5).

        Row: component of the rate; column: component of ``a`` (the paper's Eq. 29, with
        ``a_33 = 1 - a_11 - a_22`` and symmetry put in). Where a model that looks at the
        eigenvectors of ``a`` meets coincident eigenvalues, it is the derivative along changes
        that keep them together.
        """
        columns = pack(self.derivative(a, L, closure, TANGENTS))
        return columns.swapaxes(-1, -2)

    def rate_components(self, a: Array, L: Array, closure: ClosureLike) -> Array:
        """Return the independent components of `rate` [1/s], (..., 5)."""
        return pack(self.rate(a, L, closure))

    def without_retardation(self) -> OrientationModel:
        """Return the model with ``kappa = 1``, which has the same steady states.

        ``X = (1 - kappa) M:X`` and ``M:M = M`` give ``M:X = 0``, hence ``X = 0``.
        """
        return self

    @abstractmethod
    def _unretarded(self, a: Array, D: Array, W: Array, closure: ClosureLike) -> Array:
        """Return ``X`` of the module's docstring."""

    @abstractmethod
    def _unretarded_derivative(
        self, a: Array, D: Array, W: Array, closure: ClosureLike, da: Array
    ) -> Array:
        """Return the derivatives of ``X`` along ``da``, (..., k, 3, 3)."""

    def _bounded(self, key: str, low: float, high: float, meaning: str) -> None:
        """Refuse a parameter outside [low, high]."""
        value = getattr(self, key)
        refuse_no_number(f"{self.name}: {key}", value)
        if not (math.isfinite(value) and low <= value <= high):
            msg = f"{self.name}: {key} = {value:g} must be in [{low:g}, {high:g}]: {meaning}"
            raise ConfigError(msg)

    def _positive(self, key: str, way_out: str) -> None:
        """Refuse a parameter that is not positive and finite."""
        value = getattr(self, key)
        refuse_no_number(f"{self.name}: {key}", value)
        if not (math.isfinite(value) and value > 0.0):
            msg = f"{self.name}: {key} = {value:g} must be positive: {way_out}"
            raise ConfigError(msg)


def checked_law(model: OrientationModel, closure: ClosureLike) -> None:
    """Refuse what is no model, or no closure: a name is none yet (`ConfigError`)."""
    refuse_other("model", model, OrientationModel)
    if not (hasattr(closure, "contract") and hasattr(closure, "contract_derivative")):
        kind = type(closure).__name__
        msg = f'closure is of the type {kind}: must be one, e.g. fibermelt.closure("ORE")'
        raise ConfigError(msg)


def checked_convention(model: str, convention: str) -> None:
    """Refuse a convention that is not in `CONVENTIONS`."""
    if convention not in CONVENTIONS:
        msg = f"{model}: {nearest_name('convention', convention, CONVENTIONS)}"
        raise ConfigError(msg)


def symmetric_product(B: Array, a: Array) -> Array:
    """Return ``B a + a B^T`` for symmetric ``a``, (..., 3, 3)."""
    half = B @ a
    whole: Array = half + half.swapaxes(-1, -2)
    return whole


def jeffery_rate(xi: float, a: Array, D: Array, W: Array, closure: ClosureLike) -> Array:
    """Return ``W a - a W + xi (D a + a D - 2 A:D)`` [1/s], (..., 3, 3)."""
    return symmetric_product(W + xi * D, a) - (2.0 * xi) * closure.contract(a, D)


def jeffery_derivative(
    xi: float, a: Array, D: Array, W: Array, closure: ClosureLike, da: Array
) -> Array:
    """Return the derivatives of `jeffery_rate` along ``da``, (..., k, 3, 3)."""
    B = (W + xi * D)[..., None, :, :]
    closed: Array = closure.contract_derivative(a, D, da)
    return symmetric_product(B, da) - (2.0 * xi) * closed


def diffusion_rate(D: Array, convention: str) -> Array:
    """Return the rate that multiplies the interaction coefficient [1/s], (..., 1, 1)."""
    return CONVENTIONS[convention] * shear_rate(D)[..., None, None]
