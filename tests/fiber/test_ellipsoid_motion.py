"""Ellipsoids of three axes along paths, against other ways to follow them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from paths_in_space import (
    ANGLE,
    ELLIPSOID,
    RATIO,
    ROUNDING,
    SHEAR,
    SPHEROID,
    TRIAXIAL,
    VISCOSITY,
    Array,
    history,
    spatial,
    turn,
    winding,
)
from scipy.integrate import solve_ivp

from fibermelt.fiber import (
    Ellipsoid,
    even_frames,
    follow,
    follow_ellipsoids,
    follow_spatial,
    spatial_bounds,
    spatial_pressure,
    surface_pressure,
    unbounded_ellipsoid,
)
from fibermelt.fiber.section import planar_section

pytestmark = pytest.mark.verification


def test_equal_axes_are_a_spheroid() -> None:
    body = unbounded_ellipsoid(Ellipsoid((RATIO, 1.0, 1.0)))
    frames = even_frames(5)
    for path in (spatial(), winding(np.eye(3))):
        one = follow_spatial(path, SPHEROID.shape_factor, frames[..., 0], 1e-11)
        two = follow_ellipsoids(path, body, frames, 1e-9)
        assert two.direction == pytest.approx(one.direction, abs=1e-10)
        assert two.spin == pytest.approx(one.spin, abs=1e-9 * np.max(np.abs(one.spin)))
        assert two.elevation == pytest.approx(one.elevation, abs=1e-9)
        here, there = (
            spatial_pressure(path, fiber, VISCOSITY, motion)
            for fiber, motion in ((SPHEROID, one), (body, two))
        )
        size = np.max(here.highest)
        assert there.lowest == pytest.approx(here.lowest, abs=1e-10 * size)
        assert there.highest == pytest.approx(here.highest, abs=1e-10 * size)
        index = np.tile([[3, 40], [80, 120]], (5, 1, 1))
        # the two ends of the range are one place; a tip's own is known to the root of rounding
        assert np.sin(there.where_at(index) - here.where_at(index)) == pytest.approx(0.0, abs=1e-6)
        a, b = (spatial_bounds(path, fiber, VISCOSITY) for fiber in (SPHEROID, body))
        for name in ("lowest", "highest"):
            assert getattr(a, name) == pytest.approx(getattr(b, name), rel=ROUNDING)
        for name in ("mildest_lowest", "mildest_highest"):  # sought, and between kinds of strain
            assert getattr(b, name) == pytest.approx(getattr(a, name), rel=3e-2)


def test_an_ellipsoid_in_the_plane_is_its_section() -> None:
    path, angles = winding(np.eye(3)), np.array([-1.2, -0.3, 0.4, 1.3])
    section = planar_section(ELLIPSOID)
    flat = follow(path, section.shape_factor, angles)
    zero, one = np.zeros(4), np.ones(4)
    c, s = np.cos(angles), np.sin(angles)
    frames = np.stack([[c, -s, zero], [s, c, zero], [zero, zero, one]]).transpose(2, 0, 1)
    motion = follow_ellipsoids(path, ELLIPSOID, frames, 1e-9)
    assert motion.angle == pytest.approx(flat.angle, abs=2 * ANGLE)
    assert motion.elevation == pytest.approx(0.0, abs=ROUNDING)
    whole = spatial_pressure(path, ELLIPSOID, VISCOSITY, motion)
    plane = surface_pressure(path, section, VISCOSITY, flat)
    size = np.max(plane.highest)
    assert whole.lowest == pytest.approx(plane.lowest, abs=1e-7 * size)
    assert whole.highest == pytest.approx(plane.highest, abs=1e-7 * size)


@pytest.mark.parametrize("axes", [TRIAXIAL, (1.0, 0.7, 0.1)])
def test_three_axes_against_rotation_matrices(axes: tuple[float, float, float]) -> None:
    """An independent way: ``Q_dot = Q [omega]`` in body axes, of order eight."""
    body, period = unbounded_ellipsoid(Ellipsoid(axes)), 20.0
    path = history(turn(5) @ SHEAR @ turn(5).T, period, 301)
    frames = even_frames(3)

    def rate(_: float, flat: Array) -> Array:
        Q = flat.reshape(3, 3)
        x, y, z = body.angular_velocity(np.linalg.solve(Q, path.gradient[0] @ Q))
        return np.ravel(Q @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]))

    motion = follow_ellipsoids(path, body, frames, 1e-8)
    for k, frame in enumerate(frames):
        exact = solve_ivp(
            rate,
            (0.0, period),
            frame.ravel(),
            method="DOP853",
            t_eval=path.time,
            rtol=1e-12,
            atol=1e-13,
        ).y.T.reshape(-1, 3, 3)
        assert motion.direction[k] == pytest.approx(exact[..., 0], abs=ANGLE)
        assert motion.second[k] == pytest.approx(exact[..., 1], abs=ANGLE)


def test_turned_frames_turn_the_answers() -> None:
    Q, frames = turn(6), even_frames(4)
    here = follow_ellipsoids(spatial(), ELLIPSOID, frames, 1e-9)
    flat = spatial()
    turned = replace(flat, gradient=Q @ flat.gradient @ Q.T, velocity=flat.velocity @ Q.T)
    there = follow_ellipsoids(turned, ELLIPSOID, Q @ frames, 1e-9)
    assert there.direction == pytest.approx(here.direction @ Q.T, abs=1e-10)
    assert there.second == pytest.approx(here.second @ Q.T, abs=1e-10)
    one = spatial_pressure(flat, ELLIPSOID, VISCOSITY, here)
    two = spatial_pressure(turned, ELLIPSOID, VISCOSITY, there)
    size = np.max(one.highest)
    assert two.lowest == pytest.approx(one.lowest, abs=1e-9 * size)
    # the two ends of a diameter see the same
    same = np.abs(np.sum(two.place_lowest * (one.place_lowest @ Q.T), axis=-1))
    assert same == pytest.approx(1.0, abs=1e-9)
