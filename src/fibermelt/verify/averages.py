"""Balances of a Stokes flow at a point, from averages over circles or spheres around it.

Velocities of a Stokes flow are biharmonic and pressures harmonic, so that averages over a circle
(``d = 2``) or a sphere (``d = 3``) of radius ``rho`` are exact for any radius (Pizzetti 1909):

    mean(u) - u = rho^2/(2 d) lap u,   mean(p n) = (rho/d) grad p,   mean(u.n) = (rho/d) div u,
    mean(p) = p.

No difference quotient, no small step: what is left is rounding, and what the flow gets wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Balances", "Rule", "balances", "circle_rule", "sphere_rule"]

Array = NDArray[np.float64]

Rule = tuple[Array, Array]
"""Unit vectors (n, d) and their weights (n,), which sum to one."""


def circle_rule(count: int) -> Rule:
    """Return a rule that averages harmonics below ``count`` over a circle exactly."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1), np.full(count, 1.0 / count)


def sphere_rule(count: int) -> Rule:
    """Return a rule that averages polynomials of degree ``2 count - 1`` over a sphere exactly."""
    z, weight = np.polynomial.legendre.leggauss(count)
    azimuth = np.pi * np.arange(2 * count) / count
    height, turn = (part.ravel() for part in np.meshgrid(z, azimuth, indexing="ij"))
    across = np.sqrt(1.0 - height**2)
    normals = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=-1)
    return normals, np.repeat(weight, 2 * count) / (4.0 * count)


@dataclass(frozen=True)
class Balances:
    """Largest errors over all points, each over what it is a balance of.

    Parameters
    ----------
    mass : float
        ``div u`` over the largest of ``|u|/rho``.
    momentum : float
        ``lap u - grad p`` over the largest ``grad p``; unit viscosity.
    harmonic : float
        ``mean(p) - p`` over the largest ``|p|``.
    """

    mass: float
    momentum: float
    harmonic: float


def balances(
    flow: Callable[[Array], tuple[Array, Array]], points: Array, rho: Array, rule: Rule
) -> Balances:
    """Return how well a flow keeps the balances of mass and momentum.

    Parameters
    ----------
    flow : callable
        From points (..., d) [m] to velocity (..., d) [m/s] and pressure over viscosity (...) [1/s].
    points : (n, d) array
        Where [m].
    rho : (n,) array
        Radii [m]; the circles or spheres must lie in the melt.
    rule : Rule
        Of the same dimension.
    """
    normals, weights = rule
    d = points.shape[-1]
    velocity, pressure = flow(points)
    u, p = flow(points[:, None, :] + rho[:, None, None] * normals)
    divergence = d * np.einsum("kni,ni,n->k", u, normals, weights) / rho
    mean = np.einsum("kni,n->ki", u, weights)
    laplacian = 2.0 * d * (mean - velocity) / rho[:, None] ** 2
    slope = d * np.einsum("kn,ni,n->ki", p, normals, weights) / rho[:, None]
    speed = np.max(np.abs(u), axis=(1, 2))
    return Balances(
        mass=float(np.max(np.abs(divergence)) / np.max(speed / rho)),
        momentum=float(np.max(np.abs(laplacian - slope)) / np.max(np.abs(slope))),
        harmonic=float(np.max(np.abs(p @ weights - pressure)) / np.max(np.abs(p))),
    )
