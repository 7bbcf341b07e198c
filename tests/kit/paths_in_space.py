"""Paths through space, and the fibers that are followed along them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fibermelt.fiber import Ellipsoid, Spheroid, unbounded_ellipsoid, unbounded_spheroid
from fibermelt.history import FlowHistory

Array = np.ndarray

ANGLE = 1e-8  # what `follow_spatial` promises
ROUNDING = 1e-12
RATIO = 6.0
VISCOSITY = 817.0
TRIAXIAL = (6.0, 2.0, 1.0)


def history(gradient: Array, duration: float, points: int = 201) -> FlowHistory:
    """A path through the origin of a linear flow, or along given gradients."""
    L = np.broadcast_to(gradient, (points, 3, 3))
    zero = np.zeros((points, 3))
    return FlowHistory(np.linspace(0.0, duration, points), zero, zero, L, np.zeros(points))


def turn(seed: int) -> Array:
    """Return a rotation that leaves no axis where it was."""
    Q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return Q * np.sign(np.linalg.det(Q))


def winding(Q: Array, points: int = 121) -> FlowHistory:
    """A planar path through shear, extension and turning, its plane turned."""
    t = np.linspace(0.0, 1.5, points)
    L = np.zeros((points, 3, 3))
    L[:, 0, 0], L[:, 1, 1] = 4.0 * np.sin(3.0 * t), -4.0 * np.sin(3.0 * t)
    L[:, 0, 1], L[:, 1, 0] = 9.0 * np.cos(2.0 * t), 2.0 - 5.0 * t
    u = np.stack([np.ones(points), 2.0 * t, 0.0 * t], axis=-1)
    x = np.stack([t, t**2, 0.0 * t], axis=-1)
    return FlowHistory(t, x @ Q.T, u @ Q.T, Q @ L @ Q.T, 1e5 * t)


def spatial(points: int = 121) -> FlowHistory:
    """A path with all components of the gradient."""
    flat = winding(np.eye(3), points)
    L = flat.gradient.copy()
    L[:, 2, 0], L[:, 1, 2] = 3.0, 2.0 * np.sin(5.0 * flat.time)
    L[:, 2, 2], L[:, 1, 1] = 1.5, L[:, 1, 1] - 1.5
    u = flat.velocity + np.array([0.0, 0.0, 0.5])
    return replace(flat, gradient=L, velocity=u)


SPHEROID = unbounded_spheroid(Spheroid(1.0, RATIO))
ELLIPSOID = unbounded_ellipsoid(Ellipsoid(TRIAXIAL))
SHEAR = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
