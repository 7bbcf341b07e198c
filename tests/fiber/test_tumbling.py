"""One turn in time: known in closed form, the same by integration, and bounded by the extremes."""

from dataclasses import replace

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Ellipse,
    FiberResponse,
    follow,
    jeffery_angle,
    jeffery_period,
    orbit,
    surface_pressure,
    unbounded_ellipse,
)
from fibermelt.fiber.tumbling import tumble, turn_times, turned_angle
from fibermelt.history import simple_shear

FEW = examples(20)

ROUNDING = 1e-12

ratios = st.floats(1.0, 50.0)
rates = st.floats(0.01, 100.0)


ELLIPSE = unbounded_ellipse(Ellipse(1.0, 6.0))


def stretched(factor: float) -> FiberResponse:
    """A response that sees what an ellipse sees, and turns in its own way."""
    return replace(ELLIPSE, shape_factor=factor)


@FEW
@given(ratios, rates)
def test_a_turn_takes_jefferys_period(ratio: float, rate: float) -> None:
    response = unbounded_ellipse(Ellipse(1.0, ratio))
    time = turn_times(response.shape_factor, rate, 41)
    assert time[0] == 0.0
    assert np.all(np.diff(time) > 0.0)
    # 1 - xi loses its last digits for slender fibers: 1e-16 r_e^2
    assert time[-1] == pytest.approx(jeffery_period(ratio, rate), rel=1e-12 * ratio)
    assert time[[10, 20, 30]] == pytest.approx(time[-1] * np.array([0.25, 0.5, 0.75]), rel=1e-12)


@FEW
@given(ratios, rates, st.floats(-np.pi, np.pi))
def test_the_turn_closes_and_is_jefferys(ratio: float, rate: float, start: float) -> None:
    response = unbounded_ellipse(Ellipse(1.0, ratio))
    time = turn_times(response.shape_factor, rate, 41)
    turn = tumble(response, rate, 3.0, time, start)
    # rounding of the period turns the fiber on by 1e-14 r_e^2 of a turn where it is fastest
    closes = 1e-12 * ratio * ratio
    assert turn.angle[-1] - turn.angle[0] == pytest.approx(-2.0 * np.pi, abs=closes)
    expected = jeffery_angle(time, rate, ratio, start)
    assert turn.angle == pytest.approx(expected, abs=closes)
    spin = 0.5 * rate * (response.shape_factor * np.cos(2.0 * expected) - 1.0)
    assert turn.spin == pytest.approx(spin, abs=2.0 * rate * closes)
    for values in (turn.lowest, turn.highest, turn.tip):
        assert values[-1] == pytest.approx(values[0], abs=3.0 * rate * ratio * (ROUNDING + closes))


@pytest.mark.parametrize("factor", [0.0, 0.5, 0.95, 0.999, 1.0, 1.001, 1.3])
@pytest.mark.parametrize("start", [-1.3, 0.0, 0.9])
def test_what_integration_finds(factor: float, start: float) -> None:
    response = stretched(factor)
    history = simple_shear(2.0, 12.0, 301)
    motion = follow(history, factor, np.array([start]), tolerance=1e-9)
    pressure = surface_pressure(history, response, 5.0, motion)
    turn = tumble(response, 2.0, 5.0, history.time, start)
    # the integration's tolerance, and what it makes of pressures that change by 40 Pa per radian
    assert turn.angle == pytest.approx(motion.angle[0], abs=1e-8)
    assert turn.spin == pytest.approx(motion.spin[0], abs=1e-7)
    assert turn.lowest == pytest.approx(pressure.lowest[0], abs=1e-6)
    assert turn.highest == pytest.approx(pressure.highest[0], abs=1e-6)
    assert turn.tip == pytest.approx(pressure.tip[0], abs=1e-6)


@pytest.mark.parametrize("start", [-0.7, 0.2, 1.4])
def test_between_tumbling_and_stalling(start: float) -> None:
    time = np.linspace(0.0, 20.0, 50)
    middle = tumble(stretched(1.0), 1.0, 1.0, time, start)
    # a material line: its cotangent grows by the shear
    assert 1.0 / np.tan(middle.angle) == pytest.approx(1.0 / np.tan(start) + time, rel=1e-9)
    for factor in (1.0 - 1e-9, 1.0 + 1e-9):
        beside = tumble(stretched(factor), 1.0, 1.0, time, start)
        # the factor's difference acts for 20 s
        assert beside.angle == pytest.approx(middle.angle, abs=1e-7)


@pytest.mark.parametrize("start", [-1.5, 0.0, 1.5])
def test_a_fiber_that_stalls_comes_to_rest(start: float) -> None:
    response = stretched(1.25)
    turn = tumble(response, 1.0, 1.0, np.array([0.0, 100.0]), start)
    assert response.stall_angle is not None
    rest = (turn.angle[-1] - response.stall_angle) / np.pi
    assert rest == pytest.approx(round(rest), abs=ROUNDING)
    assert turn.spin[-1] == pytest.approx(0.0, abs=ROUNDING)
    assert abs(turn.angle[-1] - start) < np.pi


@FEW
@given(st.floats(0.0, 0.999), rates, st.floats(0.1, 1e4))
def test_linear_in_viscosity_and_shear_rate(factor: float, rate: float, viscosity: float) -> None:
    response = stretched(factor)
    time = turn_times(factor, 1.0, 33)
    unit = tumble(response, 1.0, 1.0, time)
    turn = tumble(response, rate, viscosity, turn_times(factor, rate, 33))
    assert turn.time * rate == pytest.approx(time, rel=ROUNDING)
    # the slender half of these factors amplifies rounding of the time by sqrt(1/(1 - B))
    assert turn.angle == pytest.approx(unit.angle, abs=1e-10)
    for name in ("lowest", "highest", "tip"):
        scaled = getattr(unit, name) * rate * viscosity
        assert getattr(turn, name) == pytest.approx(scaled, abs=1e-9 * rate * viscosity)
    assert turn.spin == pytest.approx(unit.spin * rate, abs=1e-10 * rate)


@pytest.mark.parametrize("count", [41, 401])
@pytest.mark.parametrize("ratio", [1.0, 3.0, 6.0, 10.0, 30.0])
def test_extremes_of_the_instants_miss_the_exact_ones_by_their_spacing(
    ratio: float, count: int
) -> None:
    response = unbounded_ellipse(Ellipse(1.0, ratio))
    exact = orbit(response, 1.0, 817.0)
    turn = tumble(response, 1.0, 817.0, turn_times(response.shape_factor, 1.0, count))
    # h(phi) >= h_max cos(phi - phi_max), and twice half a step of the angle is a step of the phase
    miss = 1.0 - np.cos(np.abs(np.diff(turn.angle)).max()) + ROUNDING
    for found, extreme in (
        (-turn.lowest.min(), -exact.min_pressure),
        (turn.highest.max(), exact.max_pressure),
        (-turn.tip.min(), -exact.tip_min),
        (turn.tip.max(), exact.tip_max),
    ):
        assert (1.0 - miss) * extreme <= found <= extreme * (1.0 + ROUNDING)


def test_both_steps_are_bounded() -> None:
    ratio, count = 25.0, 401
    response = unbounded_ellipse(Ellipse(1.0, ratio))
    time = turn_times(response.shape_factor, 1.0, count)
    turn = tumble(response, 1.0, 1.0, time)
    most = np.sqrt(ratio) * (1.0 + 1e-9)
    assert np.abs(np.diff(turn.angle)).max() <= most * 2.0 * np.pi / (count - 1)
    assert np.diff(time).max() <= most * time[-1] / (count - 1)


@pytest.mark.parametrize(
    ("factor", "rate", "count", "message"),
    [
        (1.0, 1.0, 41, "shape_factor = 1: must lie between"),
        (-1.0, 1.0, 41, "shape_factor = -1: must lie between"),
        (np.nan, 1.0, 41, "shape_factor = nan: must lie between"),
        (0.5, 0.0, 41, "shear_rate = 0 1/s"),
        (0.5, 1.0, 4, "count = 4: must be a whole number of at least 5"),
    ],
)
def test_no_turn(factor: float, rate: float, count: int, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        turn_times(factor, rate, count)


@pytest.mark.parametrize("time", [[0.0, np.nan], 1.0, [[0.0, 1.0]]])
def test_no_times(time: object) -> None:
    with pytest.raises(ConfigError, match="must be a list of finite times"):
        tumble(stretched(0.5), 1.0, 1.0, time)


@pytest.mark.parametrize("factor", [0.9, 1.0, 1.2])
def test_times_as_a_list(factor: float) -> None:
    times = [0.0, 0.5, 2.0]
    assert np.array_equal(
        turned_angle(factor, 1.0, times), turned_angle(factor, 1.0, np.array(times))
    )
    with pytest.raises(ConfigError, match=r"time\[1\] = nan: must be finite"):
        turned_angle(factor, 1.0, [0.0, np.nan])
