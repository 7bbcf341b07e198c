"""The ellipse and the closed forms of an unbounded one."""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Ellipse,
    ellipse_extremes,
    ellipse_pressure,
    jeffery_angle,
    jeffery_factor,
    jeffery_period,
    unbounded_ellipse,
)

FEW = examples(10)  # each builds a table or a chain of arrays
ROUNDING = 1e-12  # a few hundred operations on numbers of the size of r_e

ratios = st.floats(1.0, 30.0)
angles = st.floats(-np.pi, np.pi)


def test_shape_factor_of_the_papers_fiber() -> None:
    assert Ellipse(42e-6, 6.0).jeffery_factor == pytest.approx(0.9459, abs=5e-5)  # section 2.5
    assert Ellipse(42e-6, 6.0).semi_minor == pytest.approx(7e-6)


@pytest.mark.parametrize(
    ("half_length", "aspect_ratio", "key"),
    [
        (42e-6, 0.5, "aspect_ratio = 0.5"),
        (42e-6, np.nan, "aspect_ratio = nan"),
        (0.0, 6.0, "half_length = 0"),
        (-1.0, 6.0, "half_length = -1"),
    ],
)
def test_no_fiber(half_length: float, aspect_ratio: float, key: str) -> None:
    with pytest.raises(ConfigError, match=key):
        Ellipse(half_length, aspect_ratio)


@given(ratios)
def test_shape_factor_of_the_inverse_ratio_is_the_negative(ratio: float) -> None:
    assert jeffery_factor(1.0 / ratio) == pytest.approx(-jeffery_factor(ratio), abs=ROUNDING)


@given(ratios, angles)
def test_closed_form_extremes_bound_and_touch_the_pressure(ratio: float, phase: float) -> None:
    surface = 2.0 * np.pi * np.arange(2000) / 2000
    d11, d12 = np.cos(phase), np.sin(phase)
    pressure = ellipse_pressure(ratio, d11, d12, surface)
    low, high = ellipse_extremes(ratio, d11, d12)
    room = ROUNDING * (1.0 + ratio)
    assert low - room <= pressure.min()
    assert pressure.max() <= high + room
    # the spacing times the largest slope, which the tip's curvature bounds by r_e^2
    touch = 4.0 * (1.0 + ratio) * ratio**2 * (np.pi / 2000) ** 2 * 8.0
    assert pressure.min() - low <= touch
    assert high - pressure.max() <= touch


@pytest.mark.parametrize("ratio", [1.0, 1.0001, 3.0, 6.0, 50.0])
def test_unbounded_extreme_over_an_orbit(ratio: float) -> None:
    response = unbounded_ellipse(Ellipse(1.0, ratio))
    assert response.tip_pressure == pytest.approx(1.0 + ratio, rel=ROUNDING)
    assert response.stall_angle is None


@FEW
@given(ratios, angles)
def test_support_function_is_the_closed_form(ratio: float, phase: float) -> None:
    support = unbounded_ellipse(Ellipse(1.0, ratio)).support
    low, high = support.both(np.array([phase]))
    expected = ellipse_extremes(ratio, np.cos(phase), np.sin(phase))
    # the table's own tolerance
    assert low[0] == pytest.approx(expected[0], abs=1e-8 * support.largest)
    assert high[0] == pytest.approx(expected[1], abs=1e-8 * support.largest)
    where = support.where_exact(np.array([phase]))
    found = ellipse_pressure(ratio, np.cos(phase), np.sin(phase), where)
    assert found[0] == pytest.approx(expected[1], abs=1e-11 * support.largest)
    assert abs(where[0]) <= 0.5 * np.pi + ROUNDING


@pytest.mark.parametrize(("ratio", "period"), [(1, 12.57), (3, 20.94), (6, 38.75), (10, 63.46)])
def test_periods_of_table_1(ratio: float, period: float) -> None:
    assert jeffery_period(ratio, 1.0) == pytest.approx(period, abs=0.006)  # printed to 0.01


@given(st.floats(1.0, 20.0), angles)
def test_jeffery_angle_solves_its_equation(ratio: float, start: float) -> None:
    step = 1e-4
    theta = jeffery_angle(np.array([-step, 0.0, step]), 1.0, ratio, start)
    rate = 0.5 * (jeffery_factor(ratio) * np.cos(2.0 * start) - 1.0)
    assert theta[1] == pytest.approx(start, abs=ROUNDING)
    # central difference: step^2/6 times a third derivative below 4
    assert (theta[2] - theta[0]) / (2.0 * step) == pytest.approx(rate, abs=1e-7)


def test_no_period_at_rest() -> None:
    with pytest.raises(ConfigError, match="shear_rate = 0"):
        jeffery_period(6.0, 0.0)
