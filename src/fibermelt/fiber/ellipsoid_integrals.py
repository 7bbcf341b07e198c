"""The integrals of an ellipsoid's potentials, at the surface and on the confocal ones outside.

With ``x_i = a_i^2 + lambda`` and ``V = a_1 a_2 a_3``, all over ``s`` from 0 to infinity,

    I_i  = V int ds / ((x_i + s) Delta),             Delta = sqrt((x_1 + s)(x_2 + s)(x_3 + s)),
    I_ij = V int ds / ((x_i + s)(x_j + s) Delta),
    K_ij = V int (lambda + s) ds / ((x_i + s)(x_j + s) Delta) = I_j - a_i^2 I_ij.

On the surface ``I_i/2`` are the depolarisation factors, and Jeffery's ``alpha_0``, ``gamma_0'`` and
``gamma_0''`` are ``I_1/V``, ``I_12/V`` and ``K_12/V``. ``I_i = (2 V/3) R_D(x_j, x_k, x_i)`` is
Carlson's (1979, doi 10.1007/BF01396491), free of cancellation. ``I_ij = (I_i - I_j)/(x_j - x_i)``
is not: near the sphere, and far from any ellipsoid, the difference loses all digits. It is summed
by panels of Gauss-Legendre in ``w = ln(1 + s/min x)``, where the integrand is positive and its
nearest singularities lie about ``pi`` off the axis for any ratio of the axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["EllipsoidIntegrals", "ellipsoid_integrals"]

Array = NDArray[np.float64]

TAIL = 15.0
"""Where the sum over ``w`` ends beyond the logarithm of the axes' ratio: the integrand falls like
``exp(-5 w/2)``, to 5e-17 there."""

PANEL = 3.0
PANEL_NODES = 14
"""Panels of three units with the singularities ``pi`` away: Bernstein's ellipse has ``rho = 4.4``,
and ``rho^-28`` is below rounding. One long rule would carry the rounding of its weights, 1e-13."""

BLOCK = 4096
"""Points taken at a time: a few megabytes."""


@dataclass(frozen=True, eq=False)
class EllipsoidIntegrals:
    """The integrals of the module's docstring, without unit times powers of the length.

    Parameters
    ----------
    single : (..., 3) array
        ``I_i`` [-]; their sum is 2 on the surface.
    double : (..., 3, 3) array
        ``I_ij`` [1/m2], positive and symmetric.
    moment : (..., 3, 3) array
        ``K_ij`` [-], positive and symmetric.
    """

    single: Array
    double: Array
    moment: Array


def ellipsoid_integrals(semi_axes: Array, shift: Array) -> EllipsoidIntegrals:
    """Return the integrals on the confocal ellipsoids of parameter ``lambda``.

    Parameters
    ----------
    semi_axes : (3,) array
        ``a_i`` [m], positive, in any order.
    shift : (...) array
        ``lambda`` [m2], zero on the surface.
    """
    from scipy.special import elliprd  # noqa: PLC0415  # a tenth of a second, on demand only

    square = np.square(semi_axes)
    x = square + np.asarray(shift, dtype=np.float64)[..., None]
    volume = float(np.prod(semi_axes))
    single = 2.0 / 3.0 * volume * elliprd(np.roll(x, -1, axis=-1), np.roll(x, -2, axis=-1), x)
    flat = x.reshape(-1, 3)
    length = TAIL + math.log(float(np.max(square) / np.min(square)))
    nodes, weights = _rule(math.ceil(length / PANEL))
    double = np.empty((flat.shape[0], 3, 3))
    for at in range(0, flat.shape[0], BLOCK):
        double[at : at + BLOCK] = _pairs(flat[at : at + BLOCK], nodes, weights)
    double = volume * double.reshape(*x.shape, 3)
    # K_ij = I_j - a_i^2 I_ij with i the shorter axis of the pair, where the two do not cancel
    longer = square[:, None] <= square
    moment = np.where(longer, single[..., None, :], single[..., :, None])
    moment = moment - np.minimum(square[:, None], square) * double
    return EllipsoidIntegrals(single, double, moment)


def _pairs(x: Array, nodes: Array, weights: Array) -> Array:
    """Return ``int ds/((x_i + s)(x_j + s) Delta)`` for ``x`` of shape (n, 3), as (n, 3, 3)."""
    least = np.min(x, axis=-1)
    y = np.expm1(nodes)[:, None] + (x / least[:, None])[:, None, :]
    base = weights * np.exp(nodes) / np.sqrt(y[..., 0] * y[..., 1] * y[..., 2])
    inverse = 1.0 / y
    pairs = np.swapaxes(inverse * base[..., None], -1, -2) @ inverse
    scaled: Array = pairs * (least**-2.5)[:, None, None]
    return 0.5 * (scaled + np.swapaxes(scaled, -1, -2))


@cache
def _rule(panels: int) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss-Legendre on the first panels of the ``w`` axis."""
    nodes, weights = np.polynomial.legendre.leggauss(PANEL_NODES)
    starts = PANEL * np.arange(panels)[:, None]
    return (starts + 0.5 * PANEL * (nodes + 1.0)).ravel(), np.tile(0.5 * PANEL * weights, panels)
