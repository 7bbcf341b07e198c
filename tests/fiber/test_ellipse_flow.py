"""The flow around an ellipse: symmetries and refusals (the balances are verified elsewhere)."""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError, HistoryError
from fibermelt.fiber import Ellipse, Ellipsoid, ellipse_field, ellipse_spin, ellipsoid_field

FEW = examples(60)
EXACT = 1e-11  # rounding, times the aspect ratio
POINTS = np.array([[1.1, 0.3], [-0.4, 2.0], [3.0, -5.0], [-40.0, 1.0]])

components = st.floats(-3.0, 3.0)
angles = st.floats(-np.pi, np.pi)
ratios = st.floats(1.0, 30.0)


def rotation(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


@FEW
@given(components, components, components, angles, angles, ratios)
def test_frame_indifference(
    a: float, b: float, c: float, angle: float, turn: float, ratio: float
) -> None:
    fiber, L, Q = Ellipse(1.0, ratio), np.array([[a, b], [c, -a]]), rotation(turn)
    here = ellipse_field(fiber, L, angle, POINTS)
    there = ellipse_field(fiber, Q @ L @ Q.T, angle + turn, POINTS @ Q.T)
    scale = EXACT * 400.0  # velocities up to |L| 40
    assert there.velocity == pytest.approx(here.velocity @ Q.T, abs=scale)
    assert there.pressure == pytest.approx(here.pressure, abs=scale)
    assert there.gradient == pytest.approx(Q @ here.gradient @ Q.T, abs=scale)
    assert there.spin == pytest.approx(here.spin, abs=EXACT)


@FEW
@given(components, components, components, angles, ratios)
def test_half_a_turn_and_scale(a: float, b: float, c: float, angle: float, ratio: float) -> None:
    """The ends are alike, and Stokes flow has no length of its own."""
    L = np.array([[a, b], [c, -a]])
    here = ellipse_field(Ellipse(1.0, ratio), L, angle, POINTS)
    there = ellipse_field(Ellipse(42e-6, ratio), L, angle + np.pi, 42e-6 * POINTS)
    scale = EXACT * 400.0
    assert there.velocity / 42e-6 == pytest.approx(here.velocity, abs=scale)
    assert there.pressure == pytest.approx(here.pressure, abs=scale)
    twice = ellipse_field(Ellipse(1.0, ratio), 2.0 * L, angle, POINTS)
    assert twice.velocity == pytest.approx(2.0 * here.velocity, abs=scale)
    assert twice.pressure == pytest.approx(2.0 * here.pressure, abs=scale)


def test_a_fiber_in_a_turning_melt_is_not_felt() -> None:
    L = np.array([[0.0, -1.5], [1.5, 0.0]])
    flow = ellipse_field(Ellipse(1.0, 6.0), L, 0.4, POINTS)
    assert flow.spin == pytest.approx(1.5)
    assert flow.velocity == pytest.approx(POINTS @ L.T, abs=EXACT)
    assert flow.pressure == pytest.approx(0.0, abs=EXACT)


def test_bad_input() -> None:
    fiber, L = Ellipse(1.0, 6.0), np.array([[0.0, 1.0], [0.0, 0.0]])
    with pytest.raises(ConfigError, match=r"point \[0.9, 0.0\] m lies inside the fiber"):
        ellipse_field(fiber, L, 0.0, np.array([[2.0, 0.0], [0.9, 0.0]]))
    with pytest.raises(ConfigError, match="must be finite"):
        ellipse_field(fiber, L, 0.0, np.array([[np.nan, 0.0]]))
    with pytest.raises(ConfigError, match="spin = nan"):
        ellipse_field(fiber, L, 0.0, POINTS, spin=np.nan)
    with pytest.raises(ConfigError, match="angle = inf"):
        ellipse_spin(fiber, L, np.inf)
    with pytest.raises(HistoryError, match="gradient has trace 1 1/s"):
        ellipse_spin(fiber, np.diag([1.0, 0.0]), 0.0)
    with pytest.raises(HistoryError, match=r"gradient = .*nan.* is not finite"):
        ellipse_spin(fiber, np.diag([np.nan, 0.0]), 0.0)
    body, zero = Ellipsoid((1.0, 0.5, 0.2)), np.zeros((3, 3))
    with pytest.raises(ConfigError, match=r"point \[0.0, 0.4, 0.0\] m .* inside the ellipsoid"):
        ellipsoid_field(body, zero, np.array([0.0, 0.4, 0.0]))
    with pytest.raises(ConfigError, match="orthonormal"):
        ellipsoid_field(body, zero, np.array([0.0, 4.0, 0.0]), 2.0 * np.eye(3))
    with pytest.raises(ConfigError, match="finite"):
        ellipsoid_field(body, zero, np.array([0.0, np.inf, 0.0]))
