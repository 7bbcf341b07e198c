"""The fiber's motion: exact orbits, orders in the history's spacing, the paper's Runge-Kutta."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from fibermelt.fiber.cell import build_system
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.directions import equal_area_directions, jeffery_director
from fibermelt.fiber.directors import follow_directors
from fibermelt.fiber.jeffery import jeffery_angle, jeffery_period
from fibermelt.fiber.motion import follow, paper_angles
from fibermelt.fiber.newton_motion import follow_newton
from fibermelt.fiber.shape import Ellipse, jeffery_factor
from fibermelt.history import FlowHistory, simple_shear
from fibermelt.verify.ladder import Rung, below, order

__all__ = [
    "RUNGS",
    "reference_angles",
    "reference_directors",
    "spatial_path",
    "swinging",
]

Array = NDArray[np.float64]

JEFFERY = "Jeffery 1922, doi 10.1098/rspa.1922.0078"
RUNGE_KUTTA = "Hairer, Norsett and Wanner 1993, doi 10.1007/978-3-540-78862-1 (DOP853)"

RATIO = 6.0
DURATION = 20.0
"""Of the swinging history [s]: some three turns."""

SPATIAL_DURATION = 12.0
POINTS = (129, 257, 513)
"""Each spacing half the last; the coarsest still follows the gradient's fastest part."""


def swinging(points: int) -> FlowHistory:
    """Return a smooth history whose gradient changes in every component, from a formula."""
    t = np.linspace(0.0, DURATION, points)
    L = np.empty((points, 2, 2))
    L[:, 0, 0] = 0.3 * np.cos(2.0 * t)
    L[:, 1, 1] = -L[:, 0, 0]
    L[:, 0, 1] = 1.0 + 0.5 * np.sin(t)
    L[:, 1, 0] = 0.2 * np.cos(t)
    zero = np.zeros((points, 2))
    return FlowHistory(t, zero, zero, L, np.zeros(points))


def reference_angles(factor: float) -> Array:
    """Return where the paper's 13 starts end up [rad], by a Runge-Kutta method of order eight.

    On the angle's own nonlinear equation with the formula of `swinging`, not its points.
    """

    def rate(t: float, theta: Array) -> Array:
        shear, up, normal = 1.0 + 0.5 * np.sin(t), 0.2 * np.cos(t), 0.3 * np.cos(2.0 * t)
        local = 0.5 * (shear + up) * np.cos(2.0 * theta) - normal * np.sin(2.0 * theta)
        return np.asarray(0.5 * (up - shear) + factor * local)

    run = solve_ivp(rate, (0.0, DURATION), paper_angles(), "DOP853", rtol=1e-12, atol=1e-13)
    return np.asarray(run.y[:, -1])


def _spatial_gradient(t: ArrayLike) -> Array:
    """Return all nine components, none in step with another; the shear rules."""
    time = np.asarray(t, dtype=np.float64)[..., None, None]
    rate = 1.0 + 0.3 * np.arange(3)[:, None] + 0.17 * np.arange(3)
    shear = np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0]])
    L = 0.3 * np.cos(rate * time + np.arange(3)) + shear
    trace = np.trace(L, axis1=-2, axis2=-1)
    return np.asarray(L - trace[..., None, None] / 3.0 * np.eye(3))


def spatial_path(points: int) -> FlowHistory:
    """Return a smooth path in three dimensions, from a formula."""
    time = np.linspace(0.0, SPATIAL_DURATION, points)
    still = np.zeros((points, 3))
    return FlowHistory(time, still, still, _spatial_gradient(time), np.zeros(points))


def reference_directors(factor: float, starts: Array) -> Array:
    """Return where directors (n, 3) end up on `spatial_path`, as `reference_angles` does."""

    def rate(t: float, flat: Array) -> Array:
        p, L = flat.reshape(-1, 3), _spatial_gradient(t)
        D, W = 0.5 * (L + L.T), 0.5 * (L - L.T)
        stretch = np.einsum("ni,ij,nj->n", p, D, p)[:, None]
        return np.ravel(p @ W.T + factor * (p @ D - stretch * p))

    span = (0.0, SPATIAL_DURATION)
    run = solve_ivp(rate, span, starts.ravel(), "DOP853", rtol=1e-12, atol=1e-13)
    return np.asarray(run.y[:, -1].reshape(-1, 3))


def _observed(errors: Sequence[float]) -> float:
    """Return the order on the finest pair, each spacing half of the one before."""
    return float(np.log2(errors[-2] / errors[-1]))


def _jeffery_orbits() -> tuple[float, float]:
    """Return the largest errors over ten turns of an ellipse and of a spheroid."""
    history = simple_shear(1.0, 10.0 * jeffery_period(RATIO, 1.0), 1001)
    starts = paper_angles()
    motion = follow(history, jeffery_factor(RATIO), starts)
    exact = np.array([jeffery_angle(history.time, 1.0, RATIO, start) for start in starts])
    planar = float(np.max(np.abs(motion.angle - exact)))

    directions = equal_area_directions(7)
    found = follow_directors(history, jeffery_factor(RATIO), directions).direction
    orbits = np.array([jeffery_director(history.time, 1.0, RATIO, p) for p in directions])
    # one-to-one in the director, but a spheroid's two ends are alike
    ends = np.minimum(
        np.max(np.abs(found - orbits), axis=-1), np.max(np.abs(found + orbits), axis=-1)
    )
    return planar, float(np.max(ends))


def _against_runge_kutta() -> tuple[float, float]:
    """Return the errors of angles and directors at fine spacing."""
    factor, starts = jeffery_factor(RATIO), equal_area_directions(5)
    angles = follow(swinging(2049), factor, paper_angles()).angle[:, -1]
    directors = follow_directors(spatial_path(2049), factor, starts).direction[:, -1]
    return (
        float(np.max(np.abs(angles - reference_angles(factor)))),
        float(np.max(np.abs(directors - reference_directors(factor, starts)))),
    )


def _orders_in_spacing() -> tuple[float, float]:
    """Return the observed orders in the history's spacing, in the plane and in space."""
    factor, starts = jeffery_factor(RATIO), equal_area_directions(5)
    angles, directors = reference_angles(factor), reference_directors(factor, starts)
    planar, spatial = [], []
    for points in POINTS:
        found = follow(swinging(points), factor, paper_angles()).angle[:, -1]
        planar.append(float(np.max(np.abs(found - angles))))
        ends = follow_directors(spatial_path(points), factor, starts).direction[:, -1]
        spatial.append(float(np.max(np.abs(ends - directors))))
    return _observed(planar), _observed(spatial)


def _papers_runge_kutta() -> tuple[float]:
    """Return the order of the paper's Runge-Kutta steps towards the linear system's angles."""
    fiber = Ellipse(1.0, RATIO)
    system = build_system(fiber, 4.0, CellNumerics(order=2))
    errors = []
    for points in POINTS[:2]:  # every step costs eight linear solves
        history = swinging(points)
        run = follow_newton(system, fiber, history, 1.0, np.array([0.7]))
        exact = follow(history, system.response.shape_factor, np.array([0.7]), 1e-12)
        errors.append(float(np.max(np.abs(run.angle - exact.angle))))
    return (_observed(errors),)


RUNGS = (
    Rung(
        "fiber",
        (
            below(
                "motion: Jeffery's orbits",
                "Angles of ellipses by the director's linear system over ten turns in simple "
                "shear against Jeffery's formula and its period, 13 starts.",
                JEFFERY,
                1e-11,
                "a steady gradient has an exact propagator: rounding of ten turns",
                "rad",
            ),
            below(
                "motion: Jeffery's orbits in space",
                "Directors of spheroids over ten turns in simple shear against Jeffery's orbits, "
                "7 starts.",
                JEFFERY,
                1e-11,
                "a steady gradient has an exact propagator: rounding of ten turns",
            ),
        ),
        _jeffery_orbits,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            below(
                "motion: angles by Runge-Kutta",
                "Angles by the director's linear system against a Runge-Kutta method on the "
                "angle's own equation, a flow that changes in every component.",
                RUNGE_KUTTA,
                1e-8,
                "the interpolation between 2049 points is good to 1e-9",
                "rad",
            ),
            below(
                "motion: directors by Runge-Kutta",
                "Directors by their linear system against a Runge-Kutta method on Jeffery's "
                "equation, a flow that changes in all nine components.",
                RUNGE_KUTTA,
                1e-8,
                "the interpolation between 2049 points is good to 1e-9",
            ),
        ),
        _against_runge_kutta,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            order(
                "motion: order of the angles",
                "Observed order of the angles in the spacing of the history, 257 to 513 points.",
                RUNGE_KUTTA,
                (3.8, 4.2),
                "the gradient is interpolated at fourth order, and the propagator follows it",
            ),
            order(
                "motion: order of the directors",
                "Observed order of the directors in the spacing of the history, 257 to 513 points.",
                RUNGE_KUTTA,
                (3.75, 4.25),
                "as for the angles; five starts scatter a little more than thirteen",
            ),
        ),
        _orders_in_spacing,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            order(
                "motion: order of the paper's steps",
                "Observed order of Runge-Kutta steps on force and torque balances towards the "
                "director's linear system, 129 to 257 points.",
                "Awenlimobor, Smith and Wang 2024, doi 10.1016/j.addma.2024.103980",
                (3.8, 4.2),
                "the classical method is of fourth order",
            ),
        ),
        _papers_runge_kutta,
        quick=False,
    ),
)
