"""What the closed forms ask of their input; a refusal names the value and the way out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, HistoryError, refuse_no_number
from fibermelt.history import TRACE_TOLERANCE

__all__ = [
    "checked_finite",
    "checked_gradient",
    "checked_number",
    "checked_positive",
    "checked_unit",
    "refuse_too_slender",
]

Array = NDArray[np.float64]

UNIT_TOLERANCE = 1e-10
"""Largest ``| |p|^2 - 1 |`` of a direction: a pressure is then good to the 1e-10 it promises."""


def checked_gradient(gradient: ArrayLike, dimension: int) -> Array:
    """Return velocity gradients as an array, or refuse them.

    Parameters
    ----------
    gradient : (..., d, d) array_like
        ``L[..., i, j] = d u_i/d x_j`` [1/s].
    dimension : int
        ``d``.

    Raises
    ------
    HistoryError
        If the shape is another, a component is not finite, or a trace is above
        `fibermelt.history.TRACE_TOLERANCE` of the sum of the components' magnitudes.
    """
    L = real_array("gradient", gradient, error=HistoryError)
    if L.shape[-2:] != (dimension, dimension):
        msg = f"gradient has shape {L.shape}, expected (..., {dimension}, {dimension})"
        raise HistoryError(msg)
    finite = np.isfinite(L)
    if not np.all(finite):
        where = _first(~np.all(finite, axis=(-2, -1)))
        msg = f"gradient{_place(where)} = {L[where].tolist()} is not finite"
        raise HistoryError(msg)
    trace = np.abs(np.trace(L, axis1=-2, axis2=-1))
    # a sum of magnitudes, unlike one of squares, does not underflow; it is never below |L|
    traced = trace > TRACE_TOLERANCE * np.sum(np.abs(L), axis=(-2, -1))
    if np.any(traced):
        where = _first(traced)
        msg = (
            f"gradient{_place(where)} has trace {np.trace(L[where]):.3g} 1/s; an incompressible "
            f"melt has none (bound {TRACE_TOLERANCE:g} of sum |L_ij|): remove it before"
        )
        raise HistoryError(msg)
    return L


def checked_unit(direction: ArrayLike, name: str = "direction") -> Array:
    """Return directions as an array, or refuse them.

    Parameters
    ----------
    direction : (..., 3) array_like
        Unit vectors [-].
    name : str
        What the message calls them.

    Raises
    ------
    ConfigError
        If the shape is another, or a squared length is not one within `UNIT_TOLERANCE`.
    """
    p = real_array(name, direction)
    if p.shape[-1:] != (3,):
        msg = f"{name} has shape {p.shape}, expected (..., 3)"
        raise ConfigError(msg)
    off = np.abs(np.einsum("...i,...i->...", p, p) - 1.0)
    fine = off <= UNIT_TOLERANCE
    if not np.all(fine):
        where = _first(~fine)
        msg = (
            f"{name}{_place(where)} = {p[where].tolist()} has length "
            f"{float(np.linalg.norm(p[where])):.12g}: must be a unit vector "
            f"(bound {UNIT_TOLERANCE:g} on its square); divide by the length before"
        )
        raise ConfigError(msg)
    return p


def checked_positive(name: str, value: float, unit: str, example: str) -> float:
    """Return a positive finite number, or refuse it with its name, unit and an example."""
    refuse_no_number(name, value)
    if not (np.isfinite(value) and value > 0):
        msg = f"{name} = {value:g} {unit}".rstrip() + f": must be positive, e.g. {example}"
        raise ConfigError(msg)
    return float(value)


def checked_number(name: str, value: float) -> float:
    """Return one finite number, or refuse it (`ConfigError`)."""
    refuse_no_number(name, value)
    return float(checked_finite(name, value))


def checked_finite(name: str, value: ArrayLike, *, duration: bool = False) -> Array:
    """Return numbers as an array, or refuse those that are not finite (`ConfigError`).

    ``duration`` as in `fibermelt.arrays.real_array`.
    """
    array = real_array(name, value, duration=duration)
    finite = np.isfinite(array)
    if not np.all(finite):
        where = _first(~finite)
        msg = f"{name}{_place(where)} = {array[where]:g}: must be finite"
        raise ConfigError(msg)
    return array


def refuse_too_slender(aspect_ratio: float, most: float) -> None:
    """Refuse a fiber whose tips take more points than a machine has room for (`ConfigError`).

    The points on the surface, and the elements around it, grow with the aspect ratio.
    """
    if aspect_ratio > most:
        msg = (
            f"fiber.aspect_ratio = {aspect_ratio:g}: must be at most {most:g}, or resolving the "
            "tips takes too much memory; no fiber is that slender"
        )
        raise ConfigError(msg)


def _first(marked: NDArray[np.bool_] | np.bool_) -> tuple[int, ...]:
    """Return the index of the first marked element; empty for a single one."""
    return tuple(int(k) for k in np.argwhere(marked)[0])


def _place(where: tuple[int, ...]) -> str:
    return f"[{', '.join(map(str, where))}]" if where else ""
