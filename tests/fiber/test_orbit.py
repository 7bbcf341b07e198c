"""One turn in simple shear: what is known in closed form, and what refuses to turn."""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Ellipse,
    FiberResponse,
    ellipse_extremes,
    follow,
    orbit,
    surface_pressure,
    unbounded_ellipse,
)
from fibermelt.fiber.orbit import tumbling_period
from fibermelt.history import simple_shear
from fibermelt.melt import CarreauYasuda, PowerLaw
from fibermelt.questions.orbit import read_melt

FEW = examples(20)
ROUNDING = 1e-12
ANGLE = 1e-10  # what `orbit` promises of places and angles

SAMPLES = 256
SURFACE = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES

T_JEF = {1: 12.57, 3: 20.94, 6: 38.75, 8: 51.05, 10: 63.46}
T_JEF_BY_RATE = {0.25: 154.99, 0.5: 77.49, 1.0: 38.75, 2.0: 19.37, 5.0: 7.75}


@pytest.mark.parametrize(("ratio", "printed"), T_JEF.items())
def test_periods_of_table_1(ratio: int, printed: float) -> None:
    result = orbit(unbounded_ellipse(Ellipse(1.0, ratio)), 1.0, 817.0)
    exact = 2.0 * np.pi * (ratio + 1.0 / ratio)  # Eq. 24
    assert result.period == pytest.approx(exact, rel=1e-8)
    assert result.period_jeffery == pytest.approx(exact, rel=ROUNDING)
    assert result.period == pytest.approx(printed, abs=0.006)  # printed to 0.01
    assert not result.stalls
    assert result.stall_angle is None


@pytest.mark.parametrize(("rate", "printed"), T_JEF_BY_RATE.items())
def test_periods_of_table_1_by_shear_rate(rate: float, printed: float) -> None:
    result = orbit(unbounded_ellipse(Ellipse(1.0, 6.0)), rate, 817.0)
    assert result.period == pytest.approx(2.0 * np.pi * (6.0 + 1.0 / 6.0) / rate, rel=1e-8)
    assert result.period == pytest.approx(printed, abs=0.006)


@FEW
@given(st.floats(1.0, 50.0), st.floats(0.01, 100.0), st.floats(0.1, 1e4))
def test_unbounded_ellipse_sees_one_plus_its_aspect_ratio(
    ratio: float, rate: float, viscosity: float
) -> None:
    result = orbit(unbounded_ellipse(Ellipse(1.0, ratio)), rate, viscosity)
    expected = viscosity * rate * (1.0 + ratio)
    for value in (result.max_pressure, result.tip_max, -result.min_pressure, -result.tip_min):
        assert value == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize("ratio", [1.5, 6.0, 20.0])
@pytest.mark.parametrize("start", [-1.0, 0.0, 2.0])
def test_lowest_at_the_tips_at_45_degrees_to_the_flow(ratio: float, start: float) -> None:
    result = orbit(unbounded_ellipse(Ellipse(1.0, ratio)), 1.0, 817.0, start)
    assert result.angle_at_min == pytest.approx(0.25 * np.pi, abs=ANGLE)
    assert result.where_at_min == pytest.approx(0.0, abs=ANGLE)


def test_a_circle_sees_it_where_it_starts() -> None:
    result = orbit(unbounded_ellipse(Ellipse(1.0, 1.0)), 1.0, 817.0, 0.3)
    assert result.angle_at_min == pytest.approx(0.3)
    assert result.where_at_min == pytest.approx(0.25 * np.pi - 0.3, abs=ANGLE)


@FEW
@given(st.floats(1.0, 20.0), st.floats(-np.pi, np.pi))
def test_no_orientation_is_worse(ratio: float, angle: float) -> None:
    result = orbit(unbounded_ellipse(Ellipse(1.0, ratio)), 1.0, 1.0)
    phase = 0.5 * np.pi - 2.0 * angle
    low, high = ellipse_extremes(ratio, 0.5 * np.cos(phase), 0.5 * np.sin(phase))
    assert low >= result.min_pressure * (1.0 + ROUNDING)
    assert high <= result.max_pressure * (1.0 + ROUNDING)


def lopsided(factor: float) -> FiberResponse:
    """A response with its largest pressures off the tip: at two places, mirrored."""
    radius = 1.0 + 0.3 * np.cos(2.0 * SURFACE - 1.0) + 0.3 * np.cos(2.0 * SURFACE + 1.0)
    radius -= 0.25 * np.cos(4.0 * SURFACE)
    basis = radius[:, None] * np.stack([-np.cos(2.0 * SURFACE), np.sin(2.0 * SURFACE)], axis=-1)
    return FiberResponse(6.0, factor, SURFACE, basis)


@pytest.mark.parametrize("start", [-1.4, -0.2, 0.5, 1.2])
def test_an_orbit_off_the_tip_is_what_following_the_fiber_finds(start: float) -> None:
    response = lopsided(0.8)
    result = orbit(response, 2.0, 3.0, start)
    history = simple_shear(2.0, result.period, 4001)
    motion = follow(history, 0.8, np.array([start]))
    assert motion.angle[0, -1] == pytest.approx(start - 2.0 * np.pi, abs=1e-7)  # one turn
    pressure = surface_pressure(history, response, 3.0, motion)
    # the steps miss a peak of curvature below 20 by their square: 2e-3 rad of turning each
    assert pressure.lowest.min() == pytest.approx(result.min_pressure, rel=1e-4)
    assert pressure.highest.max() == pytest.approx(result.max_pressure, rel=1e-4)
    assert pressure.tip.max() == pytest.approx(result.tip_max, rel=1e-4)
    assert pressure.tip.min() == pytest.approx(result.tip_min, rel=1e-4)
    assert result.max_pressure > 1.01 * result.tip_max
    # two angles tie, and the first on the way is named: no step before it comes as low
    lowest = response.support.both(np.array([0.5 * np.pi - 2.0 * result.angle_at_min]))[0]
    assert 3.0 * lowest[0] == pytest.approx(result.min_pressure, rel=1e-8)
    turned = (start - result.angle_at_min) % np.pi
    before = motion.angle[0] > start - turned + 0.05
    assert np.all(pressure.lowest[0, before] > result.min_pressure * (1.0 - 1e-4))
    where = response.support.where_exact(np.array([1.5 * np.pi - 2.0 * result.angle_at_min]))
    assert result.where_at_min == pytest.approx(where[0], abs=1e-6)  # by two routes


def test_a_fiber_that_stalls() -> None:
    result = orbit(lopsided(1.25), 1.0, 1.0)
    assert result.period is None
    assert result.stalls
    assert result.stall_angle == pytest.approx(0.5 * np.arccos(0.8))
    assert result.max_pressure == orbit(lopsided(0.8), 1.0, 1.0).max_pressure


def test_period_of_a_shape_factor() -> None:
    assert tumbling_period(0.6, 2.0) == pytest.approx(4.0 * np.pi / 1.6)
    assert tumbling_period(1.0, 2.0) is None


@pytest.mark.parametrize(
    ("rate", "viscosity", "angle", "message"),
    [
        (0.0, 1.0, 0.0, "shear_rate = 0 1/s"),
        (-1.0, 1.0, 0.0, "shear_rate = -1 1/s"),
        (1.0, np.nan, 0.0, "viscosity = nan Pa s"),
        (1.0, 1.0, np.inf, "angle = inf"),
    ],
)
def test_no_orbit(rate: float, viscosity: float, angle: float, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        orbit(unbounded_ellipse(Ellipse(1.0, 6.0)), rate, viscosity, angle)


def test_a_melt_of_the_command_line_is_a_law():
    assert read_melt(None, {"viscosity": "817"}) == 817.0
    said = {"viscosity": None, "consistency": "1", "index": "0.5"}
    assert read_melt("power-law", said) == PowerLaw(1.0, 0.5)
    carreau = {"viscosity": "5 kPa s", "index": "0.4", "time_constant": "200 ms"}
    assert read_melt("carreau", carreau) == CarreauYasuda(5000.0, 0.4, 0.2)


@pytest.mark.parametrize(
    ("law", "said", "message"),
    [
        ("newton", {}, '--law "newton": must be one of "newtonian"'),
        (None, {"viscosity": None}, "--viscosity: missing: the law newtonian needs it"),
        ("power-law", {"index": "0.5", "consistency": None}, "--consistency: missing"),
        ("carreau", {"consistency": "1"}, "--consistency: no constant of the law carreau"),
        ("power-law", {"index": "0", "consistency": "1"}, "--index = 0 must be positive"),
        ("power-law", {"index": "0.5", "consistency": "1 m"}, '--consistency = "1 m"'),
    ],
)
def test_a_melt_that_is_none_names_the_option(law, said, message):
    options = dict.fromkeys(("viscosity", "consistency", "index", "time_constant")) | said
    with pytest.raises(ConfigError, match=message):
        read_melt(law, options)
