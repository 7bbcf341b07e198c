"""Directors in three dimensions along a path, Jeffery's orbits, sets of directions."""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber import (
    equal_area_directions,
    follow,
    follow_directors,
    jeffery_director,
    jeffery_factor,
    jeffery_period,
    orbit_constant,
    orbit_phase,
    paper_angles,
    planar_directions,
)
from fibermelt.fiber.expansion import exponential3
from fibermelt.history import FlowHistory, simple_shear

FEW = examples(20)
ANGLE = 1e-8  # what `follow_directors` promises
ROUNDING = 1e-11  # of a few hundred maps
XI = jeffery_factor(6.0)

seeds = st.integers(0, 2**31)
ratios = st.floats(0.05, 30.0)


def in_space(time: np.ndarray, gradient: np.ndarray) -> FlowHistory:
    still = np.zeros((len(time), 3))
    return FlowHistory(time, still, still, gradient, np.zeros(len(time)))


def winding(points: int, turn: np.ndarray | None = None) -> FlowHistory:
    """A gradient with all components, the whole flow turned."""
    t = np.linspace(0.0, 6.0, points)
    L = np.empty((points, 3, 3))
    for i in range(3):
        for j in range(3):
            L[:, i, j] = 0.3 * np.cos((1.0 + 0.3 * i) * t + j) + (i == 0 and j == 1)
    L -= np.trace(L, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    Q = np.eye(3) if turn is None else turn
    return in_space(t, Q @ L @ Q.T)


def planar(points: int, duration: float = 6.0) -> FlowHistory:
    t = np.linspace(0.0, duration, points)
    L = np.empty((points, 2, 2))
    L[:, 0, 0] = 0.3 * np.cos(2.0 * t)
    L[:, 1, 1] = -L[:, 0, 0]
    L[:, 0, 1] = 1.0 + 0.5 * np.sin(t)
    L[:, 1, 0] = 0.2 * np.cos(t)
    zero = np.zeros((points, 2))
    return FlowHistory(t, zero, zero, L, np.zeros(points))


@pytest.mark.parametrize("ratio", [0.2, 1.0, 2.0, 6.0, 20.0])
@pytest.mark.parametrize("points", [2, 301])
def test_jeffery_orbits(ratio: float, points: int) -> None:
    history = simple_shear(1.0, 3.0 * jeffery_period(ratio, 1.0), points)
    starts = np.vstack([equal_area_directions(7, whole_sphere=True), np.eye(3)])
    motion = follow_directors(history, jeffery_factor(ratio), starts)
    exact = np.array([jeffery_director(history.time, 1.0, ratio, p) for p in starts])
    assert motion.direction == pytest.approx(exact, abs=ANGLE)
    assert motion.direction[:, 0].tolist() == starts.tolist()
    assert motion.direction[:, -1] == pytest.approx(starts, abs=ANGLE)  # the orbit has closed
    assert motion.log_stretch[:, -1] == pytest.approx(0.0, abs=ANGLE)


@FEW
@given(seeds, ratios, st.floats(-20.0, 20.0))
def test_orbit_constant_and_phase(seed: int, ratio: float, time: float) -> None:
    rng = np.random.default_rng(seed)
    start = rng.normal(size=3)
    start /= np.linalg.norm(start)
    later = jeffery_director(time, 1.3, ratio, start)
    constant = float(orbit_constant(start, ratio))
    assert float(orbit_constant(later, ratio)) == pytest.approx(constant, rel=1e-9)
    way = float(orbit_phase(later, ratio) - orbit_phase(start, ratio))
    way -= 1.3 * time / (ratio + 1.0 / ratio)
    assert np.cos(way) == pytest.approx(1.0, abs=1e-12)
    turned = jeffery_director(jeffery_period(ratio, 1.3), 1.3, ratio, start)
    assert turned == pytest.approx(start, abs=1e-12)


def test_ends_of_the_orbits() -> None:
    assert orbit_constant(np.eye(3), 6.0).tolist() == [np.inf, np.inf, 0.0]
    assert orbit_phase(np.eye(3)[0], 6.0) == 0.0


@FEW
@given(st.floats(-1.4, 1.4))
def test_in_the_plane_it_is_the_planar_motion(factor: float) -> None:
    history = planar(81)
    flat = follow(history, factor, paper_angles())
    motion = follow_directors(history, factor, planar_directions(paper_angles()))
    assert motion.direction == pytest.approx(planar_directions(flat.angle), abs=ANGLE)
    assert np.all(motion.direction[..., 2] == 0.0)


def test_a_bundle_is_its_paths() -> None:
    paths = [planar(50, duration) for duration in (3.0, 5.0, 11.0)]
    starts = equal_area_directions(5)
    together = follow_directors(FlowHistory.stack(paths), 1.03, starts)
    assert together.direction.shape == (3, 5, 50, 3)
    assert together.log_stretch.shape == (3, 5, 50)
    for one, path in zip(together.direction, paths, strict=True):
        assert one == pytest.approx(follow_directors(path, 1.03, starts).direction, abs=ANGLE)


@FEW
@given(seeds, st.floats(-1.3, 1.3))
def test_frame_indifference(seed: int, factor: float) -> None:
    Q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    starts = equal_area_directions(6)
    here = follow_directors(winding(41), factor, starts)
    there = follow_directors(winding(41, Q), factor, starts @ Q.T)
    assert there.direction == pytest.approx(here.direction @ Q.T, abs=ANGLE)
    assert there.log_stretch == pytest.approx(here.log_stretch, abs=ANGLE)


@FEW
@given(st.floats(-1.3, 1.3))
def test_both_ends_of_a_fiber_move_alike(factor: float) -> None:
    starts = equal_area_directions(4)
    motion = follow_directors(winding(31), factor, np.vstack([starts, -starts]))
    assert motion.direction[4:].tolist() == (-motion.direction[:4]).tolist()


def test_density_is_conserved() -> None:
    """``exp(3 log_stretch)`` where the fibers are has the mean one over the sphere.

    Directions of equal area are therefore taken at the end and followed back on the reversed path.
    """
    whole = winding(61)
    path = in_space(whole.time[:31], whole.gradient[:31])
    back = in_space(path.time, -path.gradient[::-1])
    ends = equal_area_directions(20000)
    reversed_motion = follow_directors(back, XI, ends)
    density = np.exp(-3.0 * reversed_motion.log_stretch[:, -1])  # |F p_0| = 1/|F^-1 p|
    assert np.mean(density) == pytest.approx(
        1.0, abs=2e-4
    )  # the lattice leaves 5e-5 of a peak of 29
    starts = reversed_motion.direction[:500, -1]
    forward = follow_directors(path, XI, starts / np.linalg.norm(starts, axis=-1, keepdims=True))
    assert forward.direction[:, -1] == pytest.approx(ends[:500], abs=1e2 * ANGLE)
    assert np.exp(3.0 * forward.log_stretch[:, -1]) == pytest.approx(density[:500], rel=1e-5)


def test_long_and_strong_flows_overflow_nothing() -> None:
    """F grows by exp(3750) in the shear, by exp(300) in one interval of the stretching."""
    starts = np.vstack([planar_directions(np.array([0.3, -1.2])), equal_area_directions(5)])
    motion = follow_directors(simple_shear(1.0, 1e4, 2001), 1.25, starts)
    stall = 0.5 * np.arccos(0.8)
    along = np.abs(motion.direction[:, -1] @ [np.cos(stall), np.sin(stall), 0.0])
    assert along == pytest.approx(1.0, abs=ROUNDING)
    upright = follow_directors(simple_shear(1.0, 1e4, 2001), 1.25, np.array([[0.0, 0.0, 1.0]]))
    assert np.all(upright.direction == np.array([0.0, 0.0, 1.0]))
    assert np.max(np.abs(upright.log_stretch)) < 1e-9
    stretch = in_space(np.array([0.0, 1.0]), np.tile(np.diag([300.0, -100.0, -200.0]), (2, 1, 1)))
    ends = follow_directors(stretch, 1.0, np.vstack([starts, np.eye(3)])).direction[:, -1]
    assert np.abs(ends[:-2, 0]) == pytest.approx(1.0, abs=ROUNDING)
    assert ends[-2:].tolist() == np.eye(3)[1:].tolist()


@FEW
@given(seeds, st.floats(1e-12, 1.0))
def test_exponential(seed: int, size: float) -> None:
    A = np.random.default_rng(seed).normal(size=(4, 3, 3))
    A *= size / np.linalg.norm(A, axis=(1, 2), keepdims=True)
    term = np.tile(np.eye(3), (4, 1, 1))
    series = term.copy()
    for k in range(1, 30):
        term = term @ A / k
        series += term
    assert exponential3(A) == pytest.approx(series, abs=1e-14)


@pytest.mark.parametrize("whole", [False, True])
def test_directions_of_equal_area(whole: bool) -> None:
    p = equal_area_directions(5000, whole_sphere=whole)
    assert np.linalg.norm(p, axis=-1) == pytest.approx(1.0, abs=1e-14)
    assert np.all(p[:, 2] > 0.0) or whole
    second = p.T @ p / 5000
    assert second == pytest.approx(np.eye(3) / 3.0, abs=1e-3)  # like 1/count, some units
    fourth = np.mean(p[:, 0] ** 4)
    assert float(fourth) == pytest.approx(0.2, abs=1e-3)
    assert np.mean(p, axis=0) == pytest.approx([0.0, 0.0, 0.0 if whole else 0.5], abs=1e-3)


def test_bad_input() -> None:
    history, axis = planar(5), np.array([[1.0, 0.0, 0.0]])
    with pytest.raises(ConfigError, match=r"directions\[0\] = \[1.0, 1.0, 0.0\] has length 1.414"):
        follow_directors(history, XI, np.array([[1.0, 1.0, 0.0]]))
    with pytest.raises(ConfigError, match="at least one"):
        follow_directors(history, XI, np.empty((0, 3)))
    with pytest.raises(ConfigError, match="at least one"):
        follow_directors(history, XI, axis[0])
    with pytest.raises(ConfigError, match="shape_factor = nan"):
        follow_directors(history, np.nan, axis)
    with pytest.raises(ConfigError, match="tolerance = 0"):
        follow_directors(history, XI, axis, tolerance=0.0)
    with pytest.raises(ConfigError, match="path is of the type tuple, must be FlowHistory"):
        follow_directors((history.time, history.gradient), XI, axis)  # type: ignore[arg-type]
    with pytest.raises(ConvergenceError, match="more points"):
        follow_directors(simple_shear(1e6, 1.0, 2), XI, axis)
    fast = in_space(np.array([0.0, 1.0]), np.tile(np.diag([900.0, 0, -900.0]), (2, 1, 1)))
    with pytest.raises(ConvergenceError, match="to nothing"):
        follow_directors(fast, 1.0, np.array([[0.0, 0.0, 1.0]]))
    with pytest.raises(ConfigError, match="count = 0"):
        equal_area_directions(0)
    with pytest.raises(ConfigError, match=r"fiber\.aspect_ratio = 0"):
        orbit_constant(axis, 0.0)
