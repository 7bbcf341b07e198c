"""Spheroids and ellipsoids of three axes on paths that leave the plane, against exact motions."""

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

from fibermelt.errors import ConfigError, HistoryError
from fibermelt.fiber import (
    Ellipse,
    Ellipsoid,
    EllipsoidResponse,
    LocalViscosity,
    Spheroid,
    equal_area_directions,
    even_frames,
    extremes,
    follow,
    follow_ellipsoids,
    follow_spatial,
    half_sphere,
    jeffery_director,
    jeffery_period,
    orbit_constant,
    pressure_bounds,
    spatial_bounds,
    spatial_pressure,
    unbounded_ellipsoid,
    unbounded_model,
    unbounded_spheroid,
)
from fibermelt.fiber.motion import angle_to_stream, angle_to_stream_at
from fibermelt.fiber.section import planar_section
from fibermelt.fiber.surroundings import surroundings
from fibermelt.history import FlowHistory
from fibermelt.melt import PowerLaw


@pytest.mark.parametrize("seed", [1, 2])
def test_jeffery_in_a_shear_of_any_direction(seed: int) -> None:
    Q, period = turn(seed), jeffery_period(RATIO, 1.0)
    path = history(Q @ SHEAR @ Q.T, period)
    assert not path.planar
    starts = equal_area_directions(6)
    motion = follow_spatial(path, SPHEROID.shape_factor, starts @ Q.T)
    p = motion.direction @ Q  # along the axes of the shear
    exact = np.array([jeffery_director(path.time, 1.0, RATIO, start) for start in starts])
    assert p == pytest.approx(exact, abs=ANGLE)
    assert p[:, -1] == pytest.approx(starts, abs=ANGLE)
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    constant = np.array([orbit_constant(one, RATIO) for one in p])
    assert constant / constant[:, :1] == pytest.approx(1.0, abs=1e-6)  # of 1e-8 at small heights
    assert motion.initial_directions.tolist() == (starts @ Q.T).tolist()


def test_uniaxial_stretching() -> None:
    """``tan(angle to the axis) ~ exp(-3 xi e t/2)``; at the tips ``-(c_a - c_o) mu p.D p``."""
    path = history(np.diag([-0.5, -0.5, 1.0]), 3.0)
    start = np.array([[0.8, 0.0, 0.6], [0.0, 0.6, 0.8], [0.6, 0.0, 0.8]])
    motion = follow_spatial(path, SPHEROID.shape_factor, start)
    slope = np.array([0.8 / 0.6, 0.6 / 0.8, 0.6 / 0.8])
    slope = slope[:, None] * np.exp(-1.5 * SPHEROID.shape_factor * path.time)
    assert np.tan(motion.elevation) == pytest.approx(1.0 / slope, rel=1e-7)
    assert motion.angle == pytest.approx(np.repeat([[0.0], [np.pi / 2], [0.0]], 201, 1), abs=ANGLE)
    assert motion.spin == pytest.approx(0.0, abs=ANGLE)
    pressure = spatial_pressure(path, SPHEROID, VISCOSITY, motion)
    stretch = 1.5 * np.sin(motion.elevation) ** 2 - 0.5
    tips = -VISCOSITY * (SPHEROID.axial - SPHEROID.offset) * stretch
    near = np.abs(motion.elevation[:, -1] - np.pi / 2) < 0.1
    assert np.all(near)
    # the lowest is at the tips of an aligned fiber but for the square of its angle
    assert pressure.lowest[:, -1] == pytest.approx(tips[:, -1], rel=2e-2)
    along = follow_spatial(path, SPHEROID.shape_factor, [[0.0, 0.0, 1.0]])
    found = spatial_pressure(path, SPHEROID, VISCOSITY, along)
    exact = -VISCOSITY * (SPHEROID.axial - SPHEROID.offset)
    assert found.lowest == pytest.approx(exact, rel=ROUNDING)
    bounds = spatial_bounds(path, SPHEROID, VISCOSITY)
    assert bounds.lowest == pytest.approx(exact, rel=ROUNDING)


@pytest.mark.parametrize("seed", [3, 4])
def test_a_turned_plane_turns_the_answers(seed: int) -> None:
    Q = turn(seed)
    flat, turned = winding(np.eye(3)), winding(Q)
    assert flat.planar
    assert not turned.planar
    starts = equal_area_directions(9)
    one = follow_spatial(flat, SPHEROID.shape_factor, starts)
    two = follow_spatial(turned, SPHEROID.shape_factor, starts @ Q.T)
    assert two.direction == pytest.approx(one.direction @ Q.T, abs=2 * ANGLE)
    here, there = (
        spatial_pressure(path, SPHEROID, VISCOSITY, motion)
        for path, motion in ((flat, one), (turned, two))
    )
    size = np.max(here.highest)
    assert there.lowest == pytest.approx(here.lowest, abs=1e-7 * size)
    assert there.highest == pytest.approx(here.highest, abs=1e-7 * size)
    plane = pressure_bounds(flat, planar_section(SPHEROID), VISCOSITY)
    space = spatial_bounds(turned, SPHEROID, VISCOSITY)
    for name in ("lowest", "highest", "mildest_lowest", "mildest_highest"):
        assert getattr(space, name) == pytest.approx(getattr(plane, name), abs=1e-7 * size)
    first, second = extremes(flat, here, one), extremes(turned, there, two)
    assert second.value == pytest.approx(first.value, abs=1e-7 * size)
    # seen from the streamline, which is in the plane of the flow: over the elevation's cosine
    p = one.direction
    stream = flat.velocity / np.linalg.norm(flat.velocity, axis=-1, keepdims=True)
    along = np.abs(np.einsum("kni,ni->kn", p, stream))
    assert np.cos(angle_to_stream(turned, two)) == pytest.approx(along, abs=1e-7)


def test_angles_between_the_points_of_a_path_in_space() -> None:
    path = spatial(401)
    motion = follow_spatial(path, SPHEROID.shape_factor, equal_area_directions(3))
    there = angle_to_stream(path, motion)
    assert np.all((there >= 0.0) & (there <= 0.5 * np.pi))
    at = angle_to_stream_at(path, motion, path.time[[7, 100, -1]])
    assert at == pytest.approx(there[:, [7, 100, -1]], abs=1e-12)
    coarse = spatial(201)  # every second point: those between are told
    rough = follow_spatial(coarse, SPHEROID.shape_factor, equal_area_directions(3))
    between = angle_to_stream_at(coarse, rough, path.time[1::2])
    # a chord of at most 0.1 rad misses by its square over eight, and the points by theirs
    assert between == pytest.approx(there[:, 1::2], abs=2e-3)
    stacked = FlowHistory.stack([coarse, coarse])
    both = follow_spatial(stacked, SPHEROID.shape_factor, equal_area_directions(3))
    times = np.stack([path.time[1::2], path.time[1::2]])
    assert angle_to_stream_at(stacked, both, times)[1] == pytest.approx(between, abs=ROUNDING)
    still = replace(coarse, velocity=np.zeros((201, 3)))
    resting = follow_spatial(still, SPHEROID.shape_factor, [[1.0, 0.0, 0.0]])
    assert angle_to_stream(still, resting)[0, 0] == 0.0


def test_paths_together_and_many_bodies_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    frames = even_frames(7)
    alone = follow_ellipsoids(spatial(61), ELLIPSOID, frames)
    stacked = FlowHistory.stack([winding(np.eye(3), 61), spatial(61)])
    together = follow_ellipsoids(stacked, ELLIPSOID, frames)
    assert together.direction.shape == (2, 7, 61, 3)
    # each within the tolerance, with sub-steps of its own
    assert together.direction[1] == pytest.approx(alone.direction, abs=1e-8)
    assert together.second[1] == pytest.approx(alone.second, abs=1e-8)
    monkeypatch.setattr("fibermelt.fiber.frames.BLOCK", 3)
    assert follow_ellipsoids(spatial(61), ELLIPSOID, frames).direction == pytest.approx(
        alone.direction, abs=1e-8
    )


def test_places_see_the_extremes() -> None:
    frames = even_frames(50)
    L = spatial().gradient[60]
    found = ELLIPSOID.turned_extremes(L, frames[..., 0], frames[..., 1])
    back = np.swapaxes(frames, -1, -2)
    for value, place in (
        (found.lowest, found.where_lowest),
        (found.highest, found.where_highest),
    ):
        e = np.einsum("kij,kj->ki", back, place)
        assert ELLIPSOID.surface_pressure(back @ L @ frames, e) == pytest.approx(value, abs=1e-9)
    lowest, highest = ELLIPSOID.turned_values(L, frames[..., 0], frames[..., 1])
    assert lowest.tolist() == found.lowest.tolist()
    assert highest.tolist() == found.highest.tolist()


def strains(count: int) -> Array:
    """Return kinds of strain, from stretching along an axis to compressing along one."""
    lode = np.linspace(0.0, np.pi / 3, count)
    parts = [np.cos(lode), np.cos(lode - 2 * np.pi / 3), np.cos(lode + 2 * np.pi / 3)]
    return np.stack(parts, axis=-1)[:, :, None] * np.eye(3)


@pytest.mark.parametrize("ratio", [0.1, 0.7, 1.0, 1.4, 6.0, 30.0])
def test_bounds_of_a_spheroid_hold_over_all_directions_of_any_strain(ratio: float) -> None:
    fiber = unbounded_spheroid(Spheroid(1.0, ratio))
    D = strains(7)
    directions = np.vstack([equal_area_directions(3000), np.eye(3)])
    lowest, highest = fiber.extreme_values(D[:, None], directions)
    low, high = fiber.bounds(D)
    assert low == pytest.approx(lowest.min(axis=1), rel=ROUNDING)  # met along an axis
    assert high == pytest.approx(highest.max(axis=1), rel=ROUNDING)
    mild_low, mild_high = fiber.mildest(D)
    size = np.max(high)
    for mild, sampled in ((mild_high, highest.min(axis=1)), (-mild_low, -lowest.max(axis=1))):
        assert np.all(mild <= sampled + ROUNDING * size)
        # 3000 directions are 0.03 rad apart; the pressure is steep beside its least
        assert np.all(sampled <= mild + 0.03 * size)


@pytest.mark.parametrize("seed", range(6))
def test_bounds_of_an_ellipsoid_hold_over_all_frames_of_any_strain(seed: int) -> None:
    """And a normal along an axis is the worst of all normals, of a body of any axes."""
    axes = np.exp(np.random.default_rng(seed).uniform(-3.0, 0.0, 3))
    body = unbounded_ellipsoid(Ellipsoid((axes[0], axes[1], axes[2])))
    D = strains(7)
    low, high = body.bounds(D)
    frames = np.concatenate([even_frames(2000), permutations()])
    lowest, highest = body.turned_values(D[:, None], frames[..., 0], frames[..., 1])
    assert low == pytest.approx(lowest.min(axis=1), rel=ROUNDING)  # met by an aligned body
    assert high == pytest.approx(highest.max(axis=1), rel=ROUNDING)
    n = equal_area_directions(2000)
    own = np.diag(body.stiffness)
    G = -body.stiffness * n[:, :, None] * n[:, None, :]
    G[:, range(3), range(3)] += body.depolarisation * own
    best = np.linalg.eigvalsh(G) @ np.sort(np.diagonal(D, axis1=1, axis2=2), axis=-1).T
    assert np.all(best.max(axis=0) <= high * (1.0 + ROUNDING))


def permutations() -> Array:
    """Return the six ways to lay a body's axes along those of the strain."""
    found = []
    for i in range(3):
        for j in range(3):
            if i != j:
                p, q = np.eye(3)[i], np.eye(3)[j]
                found.append(np.stack([p, q, np.cross(p, q)], axis=-1))
    return np.array(found)


def test_what_happens_lies_within_the_bounds() -> None:
    path = spatial()
    for name, fiber in (("spheroid", Ellipse(1.0, RATIO)), ("ellipsoid", Ellipsoid(TRIAXIAL))):
        model = unbounded_model(name, fiber)
        motion = model.follow_in_space(path, model.directions(30, planar=False))
        pressure = spatial_pressure(path, model.in_space, VISCOSITY, motion)
        bounds = model.bounds(path, VISCOSITY)
        slack = ROUNDING * np.max(bounds.highest)
        assert np.all(pressure.lowest >= bounds.lowest - slack)
        assert np.all(pressure.highest <= bounds.highest + slack)
        if name == "spheroid":
            assert np.all(pressure.highest >= bounds.mildest_highest - slack)
            assert np.all(pressure.lowest <= bounds.mildest_lowest + slack)
        assert np.all(np.diff(motion.angle[:, 0]) >= 0.0)


def test_quantiles_of_an_isotropic_start() -> None:
    path, levels = FlowHistory.stack([spatial(61), spatial(61)]), (0.1, 0.5)
    model = unbounded_model("spheroid", Ellipse(1.0, RATIO))
    found = model.isotropic_pressure(path, VISCOSITY, None, 40, levels)
    motion = follow_spatial(spatial(61), SPHEROID.shape_factor, equal_area_directions(40))
    pressure = spatial_pressure(spatial(61), SPHEROID, VISCOSITY, motion)
    exact = np.quantile(pressure.lowest, levels, axis=0).T
    assert found.lowest[1] == pytest.approx(exact, rel=1e-7)
    lows = np.quantile(pressure.lowest.min(axis=1), levels)
    assert found.extremes[1, 0, 0] == pytest.approx(lows, rel=1e-7)
    body = unbounded_model("ellipsoid", Ellipsoid((RATIO, 1.0, 1.0)))
    same = body.isotropic_pressure(path, VISCOSITY, None, 40, levels)
    assert same.lowest == pytest.approx(found.lowest, rel=1e-6)
    assert same.extremes == pytest.approx(found.extremes, rel=1e-6)


def test_the_local_viscosity_in_space() -> None:
    """Of a power law: ``K gamma_dot^(n - 1)`` at the whole rate of deformation."""
    path, law = spatial(), PowerLaw(1000.0, 0.5)
    motion = follow_spatial(path, SPHEROID.shape_factor, equal_area_directions(4))
    thin = spatial_pressure(path, SPHEROID, LocalViscosity(law), motion)
    unit = spatial_pressure(path, SPHEROID, 1.0, motion)
    assert thin.lowest == pytest.approx(law.viscosity_at(path.shear_rate) * unit.lowest, rel=1e-12)
    bounds = spatial_bounds(path, SPHEROID, LocalViscosity(law))
    one = spatial_bounds(path, SPHEROID, 1.0)
    assert bounds.highest == pytest.approx(law.viscosity_at(path.shear_rate) * one.highest)


def test_sets_of_directions_and_frames_are_even() -> None:
    p = half_sphere(2000, planar=False)
    assert np.all(p[:, 2] > 0.0)
    assert np.all(np.diff(np.arctan2(p[:, 1], p[:, 0])) >= 0.0)
    # averages over the lattice converge like 1/count
    assert p.T @ p / 2000 == pytest.approx(np.eye(3) / 3.0, abs=2e-3)
    frames = even_frames(2000)
    assert np.swapaxes(frames, 1, 2) @ frames == pytest.approx(np.tile(np.eye(3), (2000, 1, 1)))
    assert np.linalg.det(frames) == pytest.approx(1.0)
    for axis in range(3):
        e = frames[..., axis]
        assert e.T @ e / 2000 == pytest.approx(np.eye(3) / 3.0, abs=1e-2)


def test_the_flow_around_an_ellipsoid_is_its_own() -> None:
    model = unbounded_model("ellipsoid", Ellipsoid(TRIAXIAL))
    found = surroundings(model)
    x, y = found.points.T
    ratio = model.response.aspect_ratio
    surface = np.abs(x**2 + (ratio * y) ** 2 - 1.0) < 1e-9
    at = np.arctan2(ratio * y[surface], x[surface])
    assert found.pressure[surface] == pytest.approx(
        model.response.curve.point(at), abs=1e-9 * model.response.tip_pressure
    )


def test_what_is_refused() -> None:
    path = spatial()
    with pytest.raises(HistoryError, match=r'fiber\.model = "spheroid" or "ellipsoid"'):
        follow(path, 0.9, [0.0])
    ellipse = unbounded_model("ellipse", Ellipse(1.0, RATIO))
    with pytest.raises(ConfigError, match="a cylinder across the flow"):
        ellipse.follow_in_space(path, equal_area_directions(3))
    with pytest.raises(ConfigError, match="must fall from the first to the third"):
        unbounded_model("ellipsoid", Ellipsoid((1.0, 2.0, 3.0)))
    with pytest.raises(ConfigError, match="must be Ellipsoid"):
        unbounded_model("ellipsoid", Ellipse(1.0, RATIO))
    turned = even_frames(2)
    with pytest.raises(ConfigError, match="right-handed"):
        follow_ellipsoids(path, ELLIPSOID, turned[..., ::-1])
    with pytest.raises(ConfigError, match="expected \\(n_directions, 3, 3\\)"):
        follow_ellipsoids(path, ELLIPSOID, turned[0])
    with pytest.raises(ConfigError, match="path is of the type"):
        follow_ellipsoids([path], ELLIPSOID, turned)
    spheroids = follow_spatial(path, SPHEROID.shape_factor, [[1.0, 0.0, 0.0]])
    with pytest.raises(ConfigError, match="must be EllipsoidMotion"):
        spatial_pressure(path, ELLIPSOID, 1.0, spheroids)
    assert isinstance(ELLIPSOID, EllipsoidResponse)
