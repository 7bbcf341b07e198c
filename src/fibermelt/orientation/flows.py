"""Homogeneous flows by name, and what every orientation model takes from a velocity gradient."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, HistoryError, legible, refuse_other
from fibermelt.history import TRACE_TOLERANCE

__all__ = [
    "FLOWS",
    "checked_gradient",
    "embedded",
    "flow_gradient",
    "nearest_name",
    "shear_rate",
    "strain_and_spin",
]

Array = NDArray[np.float64]


def _fixed(rows: list[list[float]]) -> Array:
    L = np.array(rows)
    L.setflags(write=False)
    return L


FLOWS: Mapping[str, Array] = MappingProxyType(
    {
        "simple-shear": _fixed([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
        "uniaxial": _fixed([[1.0, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, -0.5]]),
        "biaxial": _fixed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -2.0]]),
        "planar": _fixed([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]),
        "mixed": _fixed([[1.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]),
    }
)
"""Velocity gradients ``L[i, j] = d u_i/d x_j`` of unit rate [1/s].

====================  ================================================  ===================
name                  flow                                              ``gamma_dot`` [1/s]
====================  ================================================  ===================
``simple-shear``      ``u_1 = x_2``                                     1
``uniaxial``          stretched along 1, ``diag(1, -1/2, -1/2)``        ``sqrt(3)``
``biaxial``           stretched along 1 and 2, ``diag(1, 1, -2)``       ``sqrt(12)``
``planar``            stretched along 1, squeezed along 2               2
``mixed``             ``planar`` and ``simple-shear`` together          ``sqrt(5)``
====================  ================================================  ===================

``gamma_dot = sqrt(2 D:D)``. A steady state depends on ``L/gamma_dot`` only.
"""


def nearest_name(kind: str, name: str, known: Mapping[str, object]) -> str:
    """Return the message about an unknown name, with the nearest known one.

    Parameters
    ----------
    kind : str
        What is named ("flow", "orientation model").
    name : str
        What was asked for.
    known : mapping
        The names there are.

    Raises
    ------
    ConfigError
        If what was asked for is no name.
    """
    refuse_other(kind, name, str)
    folded = {key.casefold(): key for key in known}
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.0)
    hint = f"; did you mean {folded[near[0]]!r}?" if near else ""
    return f"{kind} {legible(name)!r} is unknown{hint} (known: {', '.join(known)})"


def flow_gradient(name: str) -> Array:
    """Return the velocity gradient of a flow of `FLOWS` [1/s], (3, 3), read-only.

    Raises
    ------
    ConfigError
        If there is no such flow; the message has the nearest name.
    """
    if not isinstance(name, str) or name not in FLOWS:
        raise ConfigError(nearest_name("flow", name, FLOWS))
    return FLOWS[name]


def embedded(gradient: ArrayLike) -> Array:
    """Return velocity gradients in space [1/s], (..., 3, 3).

    A planar one (..., 2, 2) gets a third direction in which nothing moves or changes; a spatial
    one is passed through.

    Raises
    ------
    HistoryError
        If the last two axes are neither (2, 2) nor (3, 3).
    """
    L = real_array("gradient", gradient, error=HistoryError)
    if L.shape[-2:] == (3, 3):
        return L
    if L.shape[-2:] != (2, 2):
        msg = f"gradient has shape {L.shape}, expected (..., 2, 2) or (..., 3, 3)"
        raise HistoryError(msg)
    whole = np.zeros((*L.shape[:-2], 3, 3))
    whole[..., :2, :2] = L
    return whole


def checked_gradient(gradient: ArrayLike) -> Array:
    """Return velocity gradients as (..., 3, 3) [1/s], planar ones embedded, or refuse them.

    Raises
    ------
    HistoryError
        If a component is not finite, or a trace is above `fibermelt.history.TRACE_TOLERANCE` of
        ``|L|``: every model and closure here is for incompressible flow.
    """
    L = embedded(gradient)
    if not np.all(np.isfinite(L)):
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(L))[0])
        msg = f"gradient{list(where)} = {L[where]} is not finite"
        raise HistoryError(msg)
    excess = np.abs(np.trace(L, axis1=-2, axis2=-1)) - TRACE_TOLERANCE * np.linalg.norm(
        L, axis=(-2, -1)
    )
    if np.any(excess > 0.0):
        where = tuple(int(k) for k in np.argwhere(excess > 0.0)[0])
        msg = (
            f"gradient{list(where) or ''} has trace {np.trace(L[where]):.3g} 1/s; an "
            f"incompressible melt has none (bound {TRACE_TOLERANCE:g} |L|): remove it before"
        )
        raise HistoryError(msg)
    return L


def strain_and_spin(L: Array) -> tuple[Array, Array]:
    """Return ``D = (L + L^T)/2`` and ``W = (L - L^T)/2`` [1/s], each (..., 3, 3)."""
    transposed = L.swapaxes(-1, -2)
    return 0.5 * (L + transposed), 0.5 * (L - transposed)


def shear_rate(D: Array) -> Array:
    """Return ``gamma_dot = sqrt(2 D:D)`` [1/s], (...)."""
    rate: Array = np.sqrt(2.0 * np.einsum("...ij,...ij->...", D, D))
    return rate
