"""The flow around an unbounded fiber, against the equations and the walls that define it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.ellipse_field import ellipse_field
from fibermelt.fiber.ellipsoid import Ellipsoid
from fibermelt.fiber.ellipsoid_field import ellipsoid_field
from fibermelt.fiber.shape import Ellipse
from fibermelt.verify.averages import balances, circle_rule, sphere_rule
from fibermelt.verify.ladder import Rung, below

__all__ = ["RUNGS"]

Array = NDArray[np.float64]

JEFFERY = "Jeffery 1922, doi 10.1098/rspa.1922.0078"
STOKES = "Stokes's equations; averages over circles and spheres"

EXACT = 1e-12
"""Closed forms lose a few digits of rounding to the aspect ratio, no more."""

DIFFERENTIATED = 1e-10
"""Second derivatives of a closed form amplify its rounding by the square of size over radius."""

RATIO, ANGLE = 6.0, 0.7
PLANAR = np.array([[0.3, 1.4], [-0.5, -0.3]])
SPATIAL = np.array([[0.3, 1.1, -0.4], [-0.2, 0.5, 0.7], [0.6, -0.9, -0.8]])
TRIAXIAL = (1.0, 0.5, 0.25)


def _ellipse_surroundings() -> tuple[float, ...]:
    """Return slip, mass, momentum and torque balance of the flow around an ellipse."""
    fiber = Ellipse(1.0, RATIO)

    def flow(points: Array) -> tuple[Array, Array]:
        around = ellipse_field(fiber, PLANAR, ANGLE, points)
        return around.velocity, around.pressure

    s = 2.0 * np.pi * (np.arange(60) + 0.5) / 60
    turn = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
    outline = np.stack([np.cos(s), np.sin(s) / RATIO], axis=-1)
    surface = outline @ turn.T
    on_fiber = ellipse_field(fiber, PLANAR, ANGLE, surface)
    rigid = on_fiber.spin * np.stack([-surface[:, 1], surface[:, 0]], axis=-1)
    slip = float(np.max(np.abs(on_fiber.velocity - rigid)))

    away = np.tile([0.4, 1.0, 3.0], 20)
    points = (outline + away[:, None] * np.stack([np.cos(s), np.sin(s)], axis=-1)) @ turn.T
    found = balances(flow, points, 0.25 * away, circle_rule(128))

    normals, weights = circle_rule(128)
    ring = ellipse_field(fiber, PLANAR, ANGLE, 2.0 * normals)
    viscous = ring.gradient + np.swapaxes(ring.gradient, -1, -2)
    traction = np.einsum("nij,nj->ni", viscous, normals) - ring.pressure[:, None] * normals
    moment = normals[:, 0] * traction[:, 1] - normals[:, 1] * traction[:, 0]
    torque = abs(float(weights @ moment)) / float(np.max(np.abs(moment)))
    return slip, found.mass, found.momentum, torque


def _ellipsoid_surroundings() -> tuple[float, ...]:
    """Return slip, mass, momentum and torque balance of the flow around a triaxial ellipsoid."""
    body, axes = Ellipsoid(TRIAXIAL), np.array(TRIAXIAL)

    def flow(points: Array) -> tuple[Array, Array]:
        around = ellipsoid_field(body, SPATIAL, points)
        return around.velocity, around.pressure

    eccentric, _ = sphere_rule(4)
    surface = eccentric * axes
    on_body = ellipsoid_field(body, SPATIAL, surface)
    slip = float(np.max(np.abs(on_body.velocity - np.cross(on_body.angular_velocity, surface))))

    away = np.tile([0.4, 1.0, 3.0, 3.0], len(eccentric) // 4)
    points = surface + away[:, None] * eccentric
    found = balances(flow, points, 0.25 * away, sphere_rule(20))

    normals, weights = sphere_rule(20)
    disturbance = ellipsoid_field(body, SPATIAL, 3.0 * normals).velocity
    disturbance -= 3.0 * normals @ SPATIAL.T
    # the rotlet's share, T/(12 pi mu r^2): all other decaying solutions average to nothing
    rotlet = float(np.max(np.abs(weights @ np.cross(normals, disturbance))))
    return slip, found.mass, found.momentum, rotlet / float(np.max(np.abs(disturbance)))


RUNGS = (
    Rung(
        "fiber",
        (
            below(
                "ellipse: no slip",
                "Velocity on a turning ellipse against its rigid rotation, over a times a unit "
                "rate.",
                STOKES,
                EXACT,
                "a closed form on the surface: rounding",
            ),
            below(
                "ellipse: balance of mass",
                "Divergence of the velocity around an ellipse, over velocity by radius.",
                STOKES,
                EXACT,
                "averages are exact for a biharmonic velocity: rounding",
            ),
            below(
                "ellipse: balance of momentum",
                "Laplacian of the velocity less gradient of the pressure around an ellipse, over "
                "the latter.",
                STOKES,
                DIFFERENTIATED,
                "rounding, amplified by two derivatives",
            ),
            below(
                "ellipse: torque balance",
                "Torque of the traction over a circle around a freely turning ellipse, over that "
                "of its largest traction.",
                JEFFERY,
                EXACT,
                "a free fiber has none: rounding",
            ),
        ),
        _ellipse_surroundings,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            below(
                "ellipsoid: no slip",
                "Velocity on a free triaxial ellipsoid against its rigid rotation, over a times a "
                "unit rate.",
                STOKES,
                EXACT,
                "a closed form on the surface: rounding",
            ),
            below(
                "ellipsoid: balance of mass",
                "Divergence of the velocity around a triaxial ellipsoid, over velocity by radius.",
                STOKES,
                EXACT,
                "averages are exact for a biharmonic velocity: rounding",
            ),
            below(
                "ellipsoid: balance of momentum",
                "Laplacian of the velocity less gradient of the pressure around a triaxial "
                "ellipsoid, over the latter.",
                STOKES,
                DIFFERENTIATED,
                "rounding, amplified by two derivatives",
            ),
            below(
                "ellipsoid: torque balance",
                "Rotlet of the disturbance of a free triaxial ellipsoid, over the disturbance.",
                JEFFERY,
                EXACT,
                "a free fiber has none: rounding",
            ),
        ),
        _ellipsoid_surroundings,
        quick=True,
        brief=True,
    ),
)
