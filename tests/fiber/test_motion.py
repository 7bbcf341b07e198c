"""Directions along a path: exact solutions and symmetries."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError, ConvergenceError, HistoryError
from fibermelt.fiber import (
    angle_to_stream,
    angle_to_stream_at,
    follow,
    isotropic_angles,
    jeffery_angle,
    jeffery_factor,
    jeffery_period,
    paper_angles,
)
from fibermelt.history import FlowHistory, simple_shear

ANGLE = 1e-8  # what `follow` promises
ROUNDING = 1e-11  # of a few hundred propagators

components = st.floats(-3.0, 3.0)


def winding(points: int, duration: float = 6.0, turn: float = 0.0) -> FlowHistory:
    """A gradient that changes in every component, the whole flow turned by an angle."""
    t = np.linspace(0.0, duration, points)
    L = np.empty((points, 2, 2))
    L[:, 0, 0] = 0.3 * np.cos(2.0 * t)
    L[:, 1, 1] = -L[:, 0, 0]
    L[:, 0, 1] = 1.0 + 0.5 * np.sin(t)
    L[:, 1, 0] = 0.2 * np.cos(t)
    c, s = np.cos(turn), np.sin(turn)
    Q = np.array([[c, -s], [s, c]])
    velocity = np.stack([1.0 + 0.1 * np.sin(t), 0.3 * np.cos(t)], axis=-1) @ Q.T
    return FlowHistory(t, np.zeros((points, 2)), velocity, Q @ L @ Q.T, np.zeros(points))


def steady(gradient: np.ndarray, duration: float, points: int = 2) -> FlowHistory:
    zero = np.zeros((points, 2))
    time = np.linspace(0.0, duration, points)
    return FlowHistory(time, zero, zero, np.tile(gradient, (points, 1, 1)), np.zeros(points))


@pytest.mark.parametrize("ratio", [1.0, 2.0, 6.0, 20.0])
@pytest.mark.parametrize("points", [2, 301])
def test_jeffery_orbit(ratio: float, points: int) -> None:
    history = simple_shear(1.0, 3.0 * jeffery_period(ratio, 1.0), points)
    motion = follow(history, jeffery_factor(ratio), paper_angles())
    exact = np.array([jeffery_angle(history.time, 1.0, ratio, a) for a in paper_angles()])
    assert motion.angle == pytest.approx(exact, abs=ANGLE)
    assert motion.angle[:, 0].tolist() == paper_angles().tolist()
    assert motion.angle[:, -1] == pytest.approx(paper_angles() - 6.0 * np.pi, abs=ANGLE)


def test_a_transposed_gradient_turns_a_fiber_the_other_way() -> None:
    """u_x = y turns clockwise, and slowly while the fiber lies along the flow."""
    xi = jeffery_factor(6.0)
    motion = follow(simple_shear(1.0, 0.1, 11), xi, np.array([0.0, 0.5 * np.pi]))
    assert motion.spin[:, 0] == pytest.approx([0.5 * (xi - 1.0), -0.5 * (xi + 1.0)])
    assert motion.angle[0, -1] == pytest.approx(0.05 * (xi - 1.0), rel=1e-3)


def test_stalled_fiber_stays_where_it_stalls() -> None:
    factor = 1.25
    stall = 0.5 * np.arccos(1.0 / factor)
    motion = follow(simple_shear(1.0, 50.0, 101), factor, np.array([stall, 0.3, -0.2, 1.5]))
    assert motion.angle[0] == pytest.approx(stall, abs=ROUNDING)
    # a start above the unstable angle -stall ends at the stall, after exp(-0.75 * 50)
    assert motion.angle[1:, -1] == pytest.approx(stall, abs=ANGLE)


def test_a_long_shear_overflows_nothing() -> None:
    """F grows by exp(3750)."""
    motion = follow(simple_shear(1.0, 1e4, 2001), 1.25, isotropic_angles(7))
    stall = 0.5 * np.arccos(0.8)
    ends = motion.angle[:, -1]
    assert (ends - stall) / np.pi == pytest.approx(np.round((ends - stall) / np.pi), abs=ROUNDING)


def test_one_coarse_interval_with_strong_stretch() -> None:
    motion = follow(steady(np.diag([300.0, -300.0]), 1.0), 1.0, np.array([0.3, -1.2, 0.0]))
    assert motion.angle[:, -1] == pytest.approx(0.0, abs=ROUNDING)


@given(components, components, components, st.floats(-2.0, 2.0))
def test_steady_gradient_against_its_exponential(a: float, b: float, c: float, factor: float):
    """p = exp(A t) p_0, at times short enough for no full turn."""
    gradient = np.array([[a, b], [c, -a]])
    D, W = 0.5 * (gradient + gradient.T), 0.5 * (gradient - gradient.T)
    A = W + factor * D
    starts = isotropic_angles(5)
    motion = follow(steady(gradient, 0.2), factor, starts)
    term, series = np.eye(2), np.eye(2)
    for k in range(1, 30):
        term = term @ A * (0.2 / k)
        series = series + term
    image = series @ np.stack([np.cos(starts), np.sin(starts)])
    cross = np.cos(motion.angle[:, -1]) * image[1] - np.sin(motion.angle[:, -1]) * image[0]
    assert cross / np.linalg.norm(image, axis=0) == pytest.approx(0.0, abs=ANGLE)


@given(st.floats(-np.pi, np.pi), st.floats(-1.4, 1.4))
def test_frame_indifference(turn: float, factor: float) -> None:
    starts = isotropic_angles(4)
    here = follow(winding(61), factor, starts)
    there = follow(winding(61, turn=turn), factor, starts + turn)
    assert there.angle - turn == pytest.approx(here.angle, abs=ANGLE)


@given(st.floats(-np.pi, np.pi), st.floats(-1.4, 1.4))
def test_both_ends_of_a_fiber_move_alike(start: float, factor: float) -> None:
    motion = follow(winding(41), factor, np.array([start, start + np.pi, start - 3.0 * np.pi]))
    assert motion.angle[1] - np.pi == pytest.approx(motion.angle[0], abs=ROUNDING)
    assert motion.angle[2] + 3.0 * np.pi == pytest.approx(motion.angle[0], abs=ROUNDING)


@given(st.floats(-1.4, 1.4))
def test_fibers_never_overtake(factor: float) -> None:
    motion = follow(winding(41), factor, isotropic_angles(40))
    assert np.all(np.diff(motion.angle, axis=0) > 0)
    assert np.all(motion.angle[-1] - motion.angle[0] < np.pi)


def test_a_bundle_is_its_paths() -> None:
    paths = [winding(50, duration) for duration in (3.0, 5.0, 11.0)]
    together = follow(FlowHistory.stack(paths), 1.03, paper_angles())
    assert together.angle.shape == (3, 13, 50)
    for one, path in zip(together.angle, paths, strict=True):
        assert one == pytest.approx(follow(path, 1.03, paper_angles()).angle, abs=ANGLE)


def test_angle_to_the_streamline_between_points() -> None:
    history = winding(401)
    motion = follow(history, 0.95, paper_angles())
    whole = angle_to_stream(history, motion)
    assert np.all((whole > -0.5 * np.pi) & (whole <= 0.5 * np.pi))
    at_points = angle_to_stream_at(history, motion, history.time[[0, 17, 400]])
    assert at_points == pytest.approx(whole[:, [0, 17, 400]], abs=ROUNDING)
    coarse = winding(201)
    between = angle_to_stream_at(
        coarse, follow(coarse, 0.95, paper_angles()), history.time[101:104:2]
    )
    # the direction is linear in between: curvature 0.4 times (0.03 s)^2 / 8
    difference = (between - whole[:, 101:104:2] + 0.5 * np.pi) % np.pi - 0.5 * np.pi
    assert difference == pytest.approx(0.0, abs=1e-4)


def test_named_angles() -> None:
    assert np.degrees(paper_angles()) == pytest.approx(np.arange(-90.0, 91.0, 15.0))
    assert np.degrees(isotropic_angles(4)) == pytest.approx([-67.5, -22.5, 22.5, 67.5])


def test_bad_input() -> None:
    history = winding(5)
    with pytest.raises(ConfigError, match="initial_angles"):
        follow(history, 1.0, np.array([np.nan]))
    with pytest.raises(ConfigError, match="initial_angles"):
        follow(history, 1.0, np.array([]))
    with pytest.raises(ConfigError, match="shape_factor"):
        follow(history, np.inf, paper_angles())
    with pytest.raises(ConfigError, match="count = 0"):
        isotropic_angles(0)
    with pytest.raises(HistoryError, match="cannot be stacked"):
        FlowHistory.stack([winding(5), winding(6)])
    with pytest.raises(ConfigError, match="outside the path"):
        angle_to_stream_at(history, follow(history, 1.0, paper_angles()), np.array([99.0]))
    with pytest.raises(ConvergenceError, match="more points"):
        follow(steady(np.array([[0.0, 1e6], [0.0, 0.0]]), 1.0), 1.0, paper_angles())


def test_angles_at_a_time_that_is_no_list() -> None:
    history = simple_shear(1.0, 2.0, 5)
    motion = follow(history, 0.9, np.array([0.1, 0.3]))
    with pytest.raises(ConfigError, match=r"times = 1\.0: must be a list"):
        angle_to_stream_at(history, motion, np.array(1.0))
