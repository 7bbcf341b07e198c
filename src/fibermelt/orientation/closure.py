"""What a closure is: the fourth moment of the orientation as a function of the second one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Closure", "ClosureLaw"]

Array = NDArray[np.float64]

CHUNK = 2048
"""Tensors contracted together: the dozen arrays of a closure then stay in the cache."""


class ClosureLaw(Protocol):
    """The formulas of a closure; shapes and meaning as in ``Closure``."""

    def fourth(self, a: Array) -> Array:
        """Return the closed tensor."""
        ...

    def fourth_derivative(self, a: Array, da: Array) -> Array:
        """Return its derivatives along directions."""
        ...

    def contract(self, a: Array, D: Array) -> Array:
        """Return the closed tensor contracted with a strain rate."""
        ...

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return the derivatives of that along directions."""
        ...


@dataclass(frozen=True)
class Closure:
    """A closure ``A(a)`` of the orientation tensor's evolution, for any batch of tensors.

    Arrays broadcast: one strain rate for many tensors, or one for each. Nothing is checked here,
    because this is called at every stage of every step: ``tensors.checked_orientation`` is the
    door. Eigenvalues outside [0, 1] are evaluated as they are, never clipped.

    Parameters
    ----------
    name : str
        Key in ``CLOSURES``.
    source : str
        Where it was published, with its DOI.
    law : ClosureLaw
        The formulas.
    is_fully_symmetric : bool
        Whether A is unchanged by every order of its indices, as a true fourth moment is.
    keeps_normalization : bool
        Whether ``A_ijkk = a_ij`` for a tensor of trace 1.
    validity : str
        For which tensors the formulas are meant.
    """

    name: str
    source: str
    law: ClosureLaw
    is_fully_symmetric: bool
    keeps_normalization: bool
    validity: str

    def fourth(self, a: Array) -> Array:
        """Return the closed fourth-order tensor.

        Parameters
        ----------
        a : (..., 3, 3) array
            Orientation tensors [-].

        Returns
        -------
        (..., 3, 3, 3, 3) array
            ``A_ijkl`` [-].
        """
        return self.law.fourth(a)

    def fourth_derivative(self, a: Array, da: Array) -> Array:
        """Return the exact directional derivatives of ``fourth``.

        Parameters
        ----------
        a : (..., 3, 3) array
            Orientation tensors [-].
        da : (..., k, 3, 3) array
            k symmetric directions without trace, such as ``tensors.TANGENTS``.

        Returns
        -------
        (..., k, 3, 3, 3, 3) array
            ``d A_ijkl`` along each direction.
        """
        return self.law.fourth_derivative(a, da)

    def contract(self, a: Array, D: Array) -> Array:
        """Return ``(A:D)_ij = A_ijkl D_kl``, without the 81 components.

        Parameters
        ----------
        a : (..., 3, 3) array
            Orientation tensors [-].
        D : (..., 3, 3) array
            Symmetric tensors, usually strain rates [1/s].

        Returns
        -------
        (..., 3, 3) array
            ``A:D`` in the units of D.
        """
        shape = np.broadcast_shapes(a.shape, D.shape)
        if math.prod(shape[:-2]) <= CHUNK:
            return self.law.contract(a, D)
        flat = np.broadcast_to(a, shape).reshape(-1, 3, 3)
        rates = None if D.ndim == 2 else np.broadcast_to(D, shape).reshape(-1, 3, 3)
        result = np.empty(flat.shape)
        for start in range(0, len(flat), CHUNK):
            part = slice(start, start + CHUNK)
            result[part] = self.law.contract(flat[part], D if rates is None else rates[part])
        return result.reshape(shape)

    def contract_derivative(self, a: Array, D: Array, da: Array) -> Array:
        """Return the exact directional derivatives of ``contract`` with respect to a.

        Parameters
        ----------
        a : (..., 3, 3) array
            Orientation tensors [-].
        D : (..., 3, 3) array
            Symmetric tensors, held fixed.
        da : (..., k, 3, 3) array
            k symmetric directions without trace.

        Returns
        -------
        (..., k, 3, 3) array
            ``d(A:D)_ij`` along each direction.
        """
        return self.law.contract_derivative(a, D, da)
