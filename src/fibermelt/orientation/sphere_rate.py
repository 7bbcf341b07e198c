"""The Fokker-Planck operator put together from a flow, and what is asked of that flow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.integrate import DOP853
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator
from scipy.sparse.csgraph import connected_components

from fibermelt.arrays import real_array
from fibermelt.errors import (
    ConfigError,
    ConvergenceError,
    HistoryError,
    refuse_no_count,
    refuse_no_number,
)
from fibermelt.orientation.distribution import UNIFORM
from fibermelt.orientation.flows import checked_gradient
from fibermelt.orientation.harmonics import (
    LOWEST_DEGREE,
    PAIRS,
    SphereOperators,
    sphere_operators,
)

__all__ = [
    "assemble_rate",
    "checked_degree",
    "checked_diffusivity",
    "checked_factor",
    "checked_history",
    "integrate_rate",
    "rate_weights",
]

Array = NDArray[np.float64]
Index = NDArray[np.intp]


def rate_weights(L: Array, shape_factor: float, diffusivity: ArrayLike) -> Array:
    """Return what multiplies each part of the operator, shape (..., 10)."""
    D, W = 0.5 * (L + L.swapaxes(-1, -2)), 0.5 * (L - L.swapaxes(-1, -2))
    strain = [shape_factor * D[..., i, j] for i, j in PAIRS]
    spin = [W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]]
    return np.stack([*strain, *spin, np.broadcast_to(diffusivity, L.shape[:-2])], axis=-1)


def _table(operators: SphereOperators) -> Array:
    """Return the parts of the operator in the order of `rate_weights`, shape (10, nnz)."""
    return np.concatenate([operators.strain, operators.spin, operators.laplacian[None]])


def assemble_rate(operators: SphereOperators, weights: Array) -> Any:
    """Return the operator without the zeros of its pattern."""
    size = operators.degrees.size
    values = weights @ _table(operators)
    matrix = sparse.csr_matrix((values, (operators.rows, operators.columns)), shape=(size, size))
    matrix.eliminate_zeros()
    return matrix


def integrate_rate(
    time: Array, weights: Array, start: Array, degree: int, tolerance: float, stability: float
) -> tuple[Array, int]:
    """Return the coefficients at the times, shape (n, N), and the evaluations of the rate.

    Parameters
    ----------
    time : (n,) array
        Times [s].
    weights : (n, 10) array
        `rate_weights` at the times.
    start : (N,) array
        Coefficients at the first.
    degree : int
        Largest degree.
    tolerance : float
        Relative, of a step.
    stability : float
        Bound of step times fastest rate ``|L| l + D_r l (l + 1)`` at the largest degree [-].

    Raises
    ------
    ConvergenceError
        If a step fails.
    """
    operators = sphere_operators(degree)
    kept, rows, columns, table, active = _reachable(operators, weights, start)
    path = _interpolant(time, weights[:, active])
    order = np.searchsorted(rows, np.arange(kept.size + 1))
    matrix = sparse.csr_matrix((table[0].copy(), columns, order), shape=(kept.size, kept.size))

    def rate(t: float, c: Array) -> Array:
        matrix.data[:] = path(t) @ table
        return np.asarray(matrix @ c)

    fastest = np.linalg.norm(weights[:, :-1], axis=1) * degree
    fastest += weights[:, -1] * degree * (degree + 1)
    solver = DOP853(rate, time[0], start[kept], time[-1], rtol=tolerance, atol=tolerance * UNIFORM)
    values = np.zeros((time.size, start.size))
    values[0, kept] = start[kept]
    done = 1
    while solver.status == "running":
        here = min(int(np.searchsorted(time, solver.t, side="right")), time.size - 1)
        rates = float(np.max(fastest[here - 1 : here + 1]))
        solver.max_step = stability / rates if rates > 0.0 else np.inf
        message = solver.step()
        reached = int(np.searchsorted(time, solver.t, side="right"))
        if reached > done:
            values[done:reached, kept] = solver.dense_output()(time[done:reached]).T
            done = reached
    if solver.status == "failed":
        msg = f"the distribution stopped at t = {solver.t:g} s: {message}"
        raise ConvergenceError(msg)
    return values, int(solver.nfev)


def _reachable(
    operators: SphereOperators, weights: Array, start: Array
) -> tuple[Index, Index, Index, Array, Index]:
    """Return the harmonics that the flow and the start can make non-zero, and their operator.

    The indices that are kept, rows and columns among them, the operator's parts there and which
    parts those are: in a planar flow half of the harmonics and of the parts are left out.
    """
    active = np.flatnonzero(np.any(weights != 0.0, axis=0))
    active = active if active.size else np.array([weights.shape[1] - 1])
    table = _table(operators)[active]
    used = np.any(table != 0.0, axis=0)
    graph = sparse.csr_matrix(
        (np.ones(int(used.sum())), (operators.rows[used], operators.columns[used])),
        shape=(start.size, start.size),
    )
    _, label = connected_components(graph, directed=False)
    kept = np.flatnonzero(np.isin(label, np.unique(label[start != 0.0])))
    place = np.full(start.size, -1)
    place[kept] = np.arange(kept.size)
    used &= place[operators.rows] >= 0
    rows, columns = place[operators.rows[used]], place[operators.columns[used]]
    return kept, rows, columns, table[:, used], active


def _interpolant(time: Array, values: Array) -> Callable[[float], Array]:
    """Return the local cubic through the values; monotone for the last column, ``D_r``."""
    if time.size == 2:
        slopes = np.repeat(np.diff(values, axis=0) / np.diff(time)[:, None], 2, axis=0)
    else:
        slopes = np.gradient(values, time, axis=0, edge_order=2)
        slopes[:, -1] = PchipInterpolator(time, values[:, -1]).derivative()(time)
    spline: Callable[[float], Array] = CubicHermiteSpline(time, values, slopes)
    return spline


def checked_degree(degree: int) -> int:
    """Return an even degree of at least four, or refuse it (`ConfigError`)."""
    refuse_no_count("degree", degree, 0)
    if degree < LOWEST_DEGREE or degree % 2:
        msg = f"degree = {degree}: must be even and at least {LOWEST_DEGREE}"
        raise ConfigError(msg)
    return degree


def checked_factor(shape_factor: float) -> float:
    """Return a finite shape factor, or refuse it (`ConfigError`)."""
    refuse_no_number("shape_factor", shape_factor)
    if not np.isfinite(shape_factor):
        msg = f"shape_factor = {shape_factor:g}: must be finite, e.g. (r_e^2 - 1)/(r_e^2 + 1)"
        raise ConfigError(msg)
    return float(shape_factor)


def checked_diffusivity(diffusivity: float) -> float:
    """Return a diffusivity that is not negative, or refuse it (`ConfigError`)."""
    refuse_no_number("diffusivity", diffusivity)
    if not (np.isfinite(diffusivity) and diffusivity >= 0.0):
        msg = f"diffusivity = {diffusivity:g} 1/s: must not be negative, e.g. C_I gamma_dot"
        raise ConfigError(msg)
    return float(diffusivity)


def checked_history(
    time: ArrayLike, gradient: ArrayLike, diffusivity: ArrayLike
) -> tuple[Array, Array, Array]:
    """Return times (n,), gradients (n, 3, 3) and diffusivities (n,), or refuse them."""
    t = real_array("time", time, error=HistoryError, duration=True)
    L = checked_gradient(gradient)
    if t.ndim != 1 or t.size < 2 or not np.all(np.diff(t) > 0.0) or not np.all(np.isfinite(t)):
        msg = f"time (shape {t.shape}) must increase strictly over at least 2 points"
        raise HistoryError(msg)
    if L.shape != (t.size, 3, 3):
        msg = f"gradient has shape {np.shape(gradient)}, expected one for each of {t.size} times"
        raise HistoryError(msg)
    D_r = real_array("diffusivity", diffusivity)
    if D_r.shape not in ((), t.shape):
        msg = f"diffusivity has shape {D_r.shape}, expected () or {t.shape} like time"
        raise HistoryError(msg)
    if not np.all(np.isfinite(D_r) & (D_r >= 0.0)):
        msg = f"diffusivity = {np.min(D_r):g} 1/s: must be finite and not negative"
        raise ConfigError(msg)
    return t, L, np.broadcast_to(D_r, t.shape).astype(np.float64)
