"""The exact closure: fourth moment of fibers that a flow turned from random orientation.

A slender fiber that Jeffery's equation turns from an isotropic start is distributed as the angular
central Gaussian ``psi(p) = (p.B p)^(-3/2)/(4 pi)``, ``det B = 1``, whatever the flow was
(Montgomery-Smith, He, Jack and Smith 2011, doi:10.1017/jfm.2011.165; Verleye and Dupret's natural
closure is the same function). Its moments are

    a    = 1/2 int_0^inf (B + s)^-1 det(B + s)^(-1/2) ds
    A    = 3/4 int_0^inf s S((B + s)^-1, (B + s)^-1) det(B + s)^(-1/2) ds

in principal axes Carlson's R_D: ``a_i = R_D(b_j, b_k, b_i)/3``. The closure inverts the first
for b, three equations, and evaluates the second. ``tr a = det(B)^(-1/2)`` holds identically, so
that det B = 1 follows from the trace and needs no equation.

The integrals are computed as they stand, by the trapezoidal rule in ``log s``: the integrand is
analytic within ``|Im log s| < pi``, so that the error is ``exp(-2 pi^2/step)``, and no formula
changes where eigenvalues coincide, which the differences of R_D would need.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, ConvergenceError

__all__ = ["FLOOR", "ExactDeviation", "central_gaussian", "second_moments"]

Array = NDArray[np.float64]

FLOOR = 1e-12
"""Smallest eigenvalue that is inverted.

Planar and aligned states (an eigenvalue of 0, and rounding on both sides of it) are evaluated
here: the closed tensor is continuous there, and off by about as much.
"""

STEP = 0.4
"""Step of the trapezoidal rule in log s: its error is exp(-2 pi^2/0.4) = 4e-22, times 1e4 at most
for the higher powers in the derivatives."""

BELOW, ABOVE = 37.0, 25.0
"""What is left out: below s = b_min e^-37 a part of 1e-16, above b_max e^25 one of e^(-1.5 25)."""

CHUNK = 64
"""Tensors integrated together: some 200 nodes each, arrays that stay in the cache."""

EXPONENT = 1.8
"""First guess ``b ~ lambda^-1.8``: 5/3 is right near random, 2 near planar orientation."""

CONVERGED = 1e-13
"""Largest relative error of the eigenvalues when b is taken."""

ITERATIONS = 30
"""Newton steps allowed: 3 to 8 are usual, from random to perfectly aligned."""

LARGEST_STEP = 3.0
"""Largest change of log b in one step: the linearisation is good for a factor of about e^3."""

_EYE = np.eye(3)
_OTHER_PAIRS = 1.0 - _EYE


@dataclass(frozen=True)
class _Nodes:
    """Quadrature of one batch: ``1/(b_i + s)`` (n, 3, q) and weights ``s ds/sqrt(det)`` (n, q)."""

    s: Array
    inverse: Array
    weight: Array


def central_gaussian(values: Array) -> Array:
    """Return the principal values b of B for eigenvalues of a.

    Parameters
    ----------
    values : (n, 3) array
        Positive eigenvalues of orientation tensors, in any order.

    Returns
    -------
    (n, 3) array
        b, with ``second_moments(b) = values`` to 1e-13; its product is 1 if the trace is.

    Raises
    ------
    ConvergenceError
        If Newton's method does not get there in 30 steps.
    """
    target = np.log(values)
    x = -EXPONENT * target
    x -= x.mean(axis=1, keepdims=True)
    for _ in range(ITERATIONS):
        b = np.exp(x)
        a, slopes = _moments(b)
        error = np.log(a) - target
        if np.max(np.abs(error), initial=0.0) <= CONVERGED:
            return b
        jacobian = slopes * b[:, None, :] / a[:, :, None]
        step = np.linalg.solve(jacobian, -error[..., None])[..., 0]
        size = np.max(np.abs(step), axis=1, keepdims=True)
        x = x + step * np.minimum(1.0, LARGEST_STEP / np.maximum(size, LARGEST_STEP))
    worst = int(np.abs(error).max(axis=1).argmax())
    msg = (
        f"exact closure: no distribution found for eigenvalues {values[worst]} in {ITERATIONS} "
        f"steps (relative error {np.abs(error[worst]).max():.1e}, bound {CONVERGED:g}): "
        "use the closure ORE, its fit"
    )
    raise ConvergenceError(msg)


def second_moments(b: Array) -> Array:
    """Return the eigenvalues of a for principal values b of B, both (n, 3)."""
    return _moments(b)[0]


@dataclass(frozen=True)
class ExactDeviation:
    """The exact closure's ``h_i = A_iiii - (6/7 lambda_i - 3/35)``.

    Valid for every true orientation tensor. Eigenvalues within 1e-12 of 0 are evaluated at 1e-12.
    """

    def value(self, values: Array) -> Array:
        """Return h at sorted eigenvalues, shape (n, 3)."""
        values = _positive(values)
        h = np.empty_like(values)
        for part in _chunks(len(values)):
            nodes = _nodes(central_gaussian(values[part]))
            h[part] = _deviation(nodes, values[part])
        return h

    def value_and_slopes(self, values: Array) -> tuple[Array, Array]:
        """Return h and ``d h_i / d lambda_j = (d A_iiii / d b) (d lambda / d b)^-1``."""
        values = _positive(values)
        h, slopes = np.empty_like(values), np.empty((len(values), 3, 3))
        for part in _chunks(len(values)):
            b = central_gaussian(values[part])
            nodes = _nodes(b)
            h[part] = _deviation(nodes, values[part])
            mixed = _mixed_slopes(nodes) * b[:, None, :]
            second = _moments(b)[1] * b[:, None, :] / values[part][:, :, None]
            # Scaled by lambda on both sides, so that small eigenvalues keep their digits.
            by_log = np.linalg.solve(second.swapaxes(-1, -2), mixed.swapaxes(-1, -2))
            mixed = by_log.swapaxes(-1, -2) / values[part][:, None, :]
            # A_1111 = lambda_1 - A_1122 - A_1133 and so on.
            slopes[part] = _EYE / 7.0 - _OTHER_PAIRS @ mixed
        return h, slopes


def _positive(values: Array) -> Array:
    """Return eigenvalues with those at the edge put on the floor, refuse negative ones."""
    smallest = float(np.min(values, initial=1.0))
    if not smallest >= -FLOOR:
        msg = (
            f"exact closure: an orientation tensor has the eigenvalue {smallest:.6g}; no "
            f"distribution has one below 0 (bound {-FLOOR:g}): take smaller steps, a start that is "
            "not perfectly aligned, or the closure ORE, its fit"
        )
        raise ConfigError(msg)
    return np.maximum(values, FLOOR)


def _chunks(n: int) -> list[slice]:
    """Return the parts of a batch."""
    return [slice(start, start + CHUNK) for start in range(0, n, CHUNK)]


def _nodes(b: Array) -> _Nodes:
    """Return the quadrature for principal values b (n, 3)."""
    low, high = np.log(b.min(axis=1)) - BELOW, np.log(b.max(axis=1)) + ABOVE
    count = int(np.ceil(np.max(high - low, initial=0.0) / STEP)) + 1
    s = np.exp(low[:, None] + STEP * np.arange(count))
    inverse = 1.0 / (b[:, :, None] + s[:, None, :])
    weight = STEP * s * np.sqrt(inverse[:, 0] * inverse[:, 1] * inverse[:, 2])
    return _Nodes(s, inverse, weight)


def _moments(b: Array) -> tuple[Array, Array]:
    """Return ``a_i(b)`` (n, 3) and ``d a_i / d b_j`` (n, 3, 3)."""
    nodes = _nodes(b)
    weighted = nodes.inverse * nodes.weight[:, None, :]
    moments = 0.5 * weighted.sum(axis=-1)
    slopes = -0.25 * (1.0 + 2.0 * _EYE) * (weighted @ nodes.inverse.swapaxes(-1, -2))
    return moments, slopes


def _deviation(nodes: _Nodes, values: Array) -> Array:
    """Return ``3/4 int s (b_i + s)^-2 / sqrt(det) ds`` less the linear closure."""
    fourth = 0.75 * np.sum((nodes.s * nodes.weight)[:, None, :] * nodes.inverse**2, axis=-1)
    result: Array = fourth - (6.0 / 7.0 * values - 3.0 / 35.0)
    return result


def _mixed_slopes(nodes: _Nodes) -> Array:
    """Return the derivatives of ``(A_2233, A_1133, A_1122)`` by b_j, shape (n, 3, 3)."""
    first, second, third = (nodes.inverse[:, i] for i in range(3))
    products = np.stack([second * third, first * third, first * second], axis=1)
    weighted = (nodes.s * nodes.weight)[:, None, :] * products
    result: Array = (
        -0.125 * (1.0 + 2.0 * _OTHER_PAIRS) * (weighted @ nodes.inverse.swapaxes(-1, -2))
    )
    return result
