"""The Fokker-Planck equation of fiber orientation on the sphere: the yardstick of every closure.

    d psi/dt = -div_s(p_dot psi) + D_r lap_s psi,   p_dot = W p + xi (D p - (p.D p) p)

(Folgar and Tucker 1984, doi 10.1177/073168448400300201, in three dimensions; its second moment is
the paper's Eq. 26 with the true fourth moment). Galerkin's method with spherical harmonics of even
degree (after Montgomery-Smith, Jack and Smith 2010, doi 10.1016/j.compositesa.2010.03.012): the
operator couples a degree with its neighbours only and is linear in ``L`` and ``D_r``, its matrices
are exact and sparse, and the series converges faster than any power.

``D_r`` [1/s] is the caller's, ``C_I gamma_dot`` in whichever convention; ``xi`` is Jeffery's shape
factor or a confined fiber's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.orientation.distribution import (
    UNIFORM,
    Distribution,
    isotropic_distribution,
    tail,
)
from fibermelt.orientation.flows import checked_gradient
from fibermelt.orientation.harmonics import SphereOperators, sphere_operators
from fibermelt.orientation.sphere_rate import (
    assemble_rate,
    checked_degree,
    checked_diffusivity,
    checked_factor,
    checked_history,
    integrate_rate,
    rate_weights,
)

__all__ = [
    "DistributionHistory",
    "follow_distribution",
    "rate_operator",
    "steady_distribution",
]

Array = NDArray[np.float64]

TRUNCATION_TOLERANCE = 1e-8
"""Share of the highest degrees that is left: moments are then good to rounding."""

LARGEST_DEGREE = 240
"""Degree at which the search ends: directions 0.01 rad apart, a second for the matrices."""

DEGREE_GROWTH = 1.5
"""From one degree tried to the next: the cost is quadratic in it, so a miss costs a half."""

COARSE, FINE = (10.0, 5.0), (1.0, 4.0)
"""Two integrations whose difference is the error estimate: the tolerance of a step over the
truncation's, and the largest product of step and fastest rate. Up to five the highest degrees are
damped as they should be; at the method's bound of stability, near six, they fill with noise."""

TOLERANCES = (1e-12, 1e-2)
"""Truncations of a history: below, rounding decides; above, nothing is resolved."""


@dataclass(frozen=True, eq=False)
class DistributionHistory:
    """A distribution along a flow history.

    Parameters
    ----------
    time : (n,) array
        Times [s].
    distribution : Distribution
        A batch of n.
    error : float
        Largest change of a component of the second moment [-] against an integration with longer
        steps and ten times the tolerance: above the error of this one.
    evaluations : int
        Evaluations of the rate.
    """

    time: Array
    distribution: Distribution
    error: float
    evaluations: int


def rate_operator(gradient: ArrayLike, shape_factor: float, diffusivity: float, degree: int) -> Any:
    """Return the matrix ``A`` of ``dc/dt = A c`` for the coefficients of a distribution.

    Parameters
    ----------
    gradient : (3, 3) or (2, 2) array_like
        ``L[i, j] = d u_i/d x_j`` [1/s], without trace; a planar one has no flow along ``x_3``.
    shape_factor : float
        ``xi`` [-].
    diffusivity : float
        ``D_r`` [1/s], not negative.
    degree : int
        Largest degree of the series, even.

    Returns
    -------
    (N, N) sparse array
        [1/s]; its first row is zero, as no fiber is lost.

    Raises
    ------
    ConfigError, HistoryError
        If a value is not finite, ``D_r`` negative, the degree odd, or ``L`` has a trace.
    """
    L = checked_gradient(gradient)
    weights = rate_weights(L, checked_factor(shape_factor), checked_diffusivity(diffusivity))
    return assemble_rate(sphere_operators(checked_degree(degree)), weights)


def steady_distribution(
    gradient: ArrayLike,
    shape_factor: float,
    diffusivity: float,
    degree: int | None = None,
    tolerance: float = TRUNCATION_TOLERANCE,
) -> Distribution:
    """Return the steady distribution in a homogeneous flow.

    One sparse linear system: the constant's coefficient is fixed by ``int psi = 1``, and harmonics
    that the flow does not couple to it are zero and left out.

    Parameters
    ----------
    gradient, shape_factor
        As in `rate_operator`.
    diffusivity : float
        ``D_r`` [1/s], positive: without it there is none but for special flows.
    degree : int, optional
        Largest degree, even; by default it grows until ``truncation`` is below the tolerance.
        In simple shear at ``r_e = 6``: 50 for ``C_I = 0.0128``, 108 for ``1e-3``.
    tolerance : float
        Of ``truncation`` [-]; without effect if the degree is given.

    Raises
    ------
    ConfigError, HistoryError
        As `rate_operator`, and if ``D_r`` is zero.
    ConvergenceError
        If the degree would have to exceed 240: elongation below ``C_I`` of about 6e-4.
    """
    L = checked_gradient(gradient)
    xi = checked_factor(shape_factor)
    D_r = checked_diffusivity(diffusivity)
    if D_r == 0.0:
        msg = "diffusivity = 0 1/s: a steady distribution needs a positive one, e.g. C_I gamma_dot"
        raise ConfigError(msg)
    scale = float(np.linalg.norm(L)) + D_r
    weights = rate_weights(L, xi, D_r)

    def attempt(size: int) -> Distribution:
        coefficients, residual = _solve_steady(sphere_operators(size), weights)
        return Distribution(coefficients, size, tail(coefficients, size), residual / scale)

    if degree is not None:
        return attempt(checked_degree(degree))
    start = _first_degree(scale, D_r)
    return _grow(attempt, start, tolerance, f"steady state at D_r/|L| = {D_r / scale:.3g}")


def follow_distribution(
    time: ArrayLike,
    gradient: ArrayLike,
    shape_factor: float,
    diffusivity: ArrayLike,
    initial: Distribution | None = None,
    degree: int | None = None,
    tolerance: float = TRUNCATION_TOLERANCE,
) -> DistributionHistory:
    """Return the distribution along a flow history.

    Dormand and Prince's explicit method of order eight, with steps well inside its stability: the
    degree that resolves ``psi`` goes with ``D_r^(-1/3)``, so that diffusion is hardly stiff there.
    ``L`` is the local cubic between the points, ``D_r`` the monotone one, which cannot fall below
    zero. Fifty units of shear at ``r_e = 6`` take half a second at ``C_I = 0.0128``, six at 1e-3.

    Parameters
    ----------
    time : (n,) array_like
        Times [s], strictly increasing, at least two.
    gradient : (n, 3, 3) or (n, 2, 2) array_like
        Velocity gradient at the times [1/s], without trace.
    shape_factor : float
        ``xi`` [-].
    diffusivity : float or (n,) array_like
        ``D_r`` at the times [1/s], not negative. At zero, ``psi`` sharpens for ever and the degree
        with it.
    initial : Distribution, optional
        Where it begins (a single one); isotropic by default.
    degree : int, optional
        Largest degree, even; by default as in `steady_distribution`, at all times.
    tolerance : float
        Of ``truncation`` [-] if the degree is not given, and of a step of the integration.

    Raises
    ------
    ConfigError, HistoryError
        As `rate_operator`, if time does not increase, shapes disagree, or the initial distribution
        is a batch.
    ConvergenceError
        If the degree would have to exceed 240, or a step fails.
    """
    t, L, D_r = checked_history(time, gradient, diffusivity)
    weights = rate_weights(L, checked_factor(shape_factor), D_r)
    start = isotropic_distribution() if initial is None else initial
    _check_start(start, degree, tolerance)
    calls = 0

    def attempt(size: int, accuracy: tuple[float, float]) -> Distribution:
        nonlocal calls
        step, bound = accuracy[0] * tolerance, accuracy[1]
        values, evaluations = integrate_rate(t, weights, start.raised(size), size, step, bound)
        calls += evaluations
        return Distribution(values, size, tail(values, size))

    if degree is None:
        scale = float(np.max(np.linalg.norm(L, axis=(-2, -1)) + D_r))
        first = max(_first_degree(scale, float(np.max(D_r))), start.degree)
        coarse = _grow(lambda size: attempt(size, COARSE), first, tolerance, "the history")
    else:
        coarse = attempt(checked_degree(degree), COARSE)
    fine = attempt(coarse.degree, FINE)
    error = float(np.max(np.abs(fine.second() - coarse.second())))
    return DistributionHistory(t, fine, error, calls)


def _check_start(start: Distribution, degree: int | None, tolerance: float) -> None:
    """Refuse what a history cannot begin with, and a tolerance that means nothing."""
    if start.coefficients.ndim != 1:
        msg = f"initial has coefficients {start.coefficients.shape}: must be a single distribution"
        raise ConfigError(msg)
    if not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
        msg = f"tolerance = {tolerance:g}: must lie in {TOLERANCES[0]:g}..{TOLERANCES[1]:g}"
        raise ConfigError(msg)
    if degree is not None and degree < start.degree:
        msg = f"degree = {degree}: must not be below the initial distribution's {start.degree}"
        raise ConfigError(msg)


def _solve_steady(operators: SphereOperators, weights: Array) -> tuple[Array, float]:
    """Return the coefficients of the steady state and the norm of what is left of the rate."""
    matrix = assemble_rate(operators, weights)
    _, label = connected_components(matrix, directed=False)
    coupled = np.flatnonzero(label == label[0])[1:]
    coefficients = np.zeros(operators.degrees.size)
    coefficients[0] = UNIFORM
    if coupled.size:
        rows = matrix[coupled]
        load = -UNIFORM * rows[:, [0]].toarray().ravel()
        coefficients[coupled] = splu(rows[:, coupled].tocsc()).solve(load)
    residual = np.linalg.norm(matrix @ coefficients) / np.linalg.norm(coefficients)
    return coefficients, float(residual)


def _first_degree(scale: float, diffusivity: float) -> int:
    """Return the degree to begin with: the layer's width goes with ``(D_r/|L|)^(1/3)``."""
    ratio = scale / diffusivity if diffusivity > 0.0 else math.inf
    return int(min(8 + 2 * round(5.0 * min(ratio, 1e6) ** (1.0 / 3.0)), LARGEST_DEGREE // 2))


def _grow(
    attempt: Callable[[int], Distribution], degree: int, tolerance: float, what: str
) -> Distribution:
    """Return the first attempt whose truncation is below the tolerance, degree by degree."""
    while True:
        result = attempt(degree)
        if result.truncation <= tolerance:
            return result
        if degree >= LARGEST_DEGREE:
            msg = (
                f"orientation distribution of {what}: {result.truncation:.2g} of it is left at "
                f"degree {degree} (bound {tolerance:g}): take a larger diffusivity or tolerance, "
                "or name a degree"
            )
            raise ConvergenceError(msg)
        degree = min(2 * math.ceil(0.5 * DEGREE_GROWTH * degree), LARGEST_DEGREE)
