"""The growth exponent of paths: closed forms, crossings, its own error, refusals."""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError, HistoryError
from fibermelt.voids import growth_exponent

ROUNDING = 1e-12  # a few tens of operations


def test_constant_pressure() -> None:
    """``R0 exp(dp t/(4 mu))``: 0.2 MPa over 3 s in 817 Pa s."""
    found = growth_exponent([0.0, 1.0, 3.0], [1e5] * 3, 3e5, [817.0] * 3)
    assert float(found.value) == pytest.approx(2e5 * 3.0 / (4 * 817.0), rel=ROUNDING)
    assert float(found.error) == 0.0


def test_only_what_is_below_the_vapor_pressure_counts() -> None:
    """Absolute 3, 1, 1, 3 Pa against 2 in 0.25 Pa s: two half triangles and a whole second."""
    time, pressure = [0.0, 1.0, 2.0, 3.0], [3.0, 1.0, 1.0, 3.0]
    found = growth_exponent(time, pressure, 2.0, [0.25] * 4)
    assert float(found.value) == pytest.approx(0.25 + 1.0 + 0.25, rel=ROUNDING)
    assert float(growth_exponent(time, pressure, 1.0, [0.25] * 4).value) == 0.0
    assert float(growth_exponent(time, pressure, 0.5, [0.25] * 4).value) == 0.0


def test_it_ends_where_it_is_told_to() -> None:
    """Rate 1 - t up to 1, then 0: up to T it is T - T^2/2."""
    time, pressure = [0.0, 1.0, 2.0], [1.0, 2.0, 2.0]
    for end in (-1.0, 0.0, 0.3, 1.0, 1.7, 5.0):
        found = growth_exponent(time, pressure, 2.0, [0.25] * 3, end)
        until = min(max(end, 0.0), 1.0)
        assert float(found.value) == pytest.approx(until - until**2 / 2, rel=ROUNDING)


def test_the_viscosity_is_that_of_each_point() -> None:
    found = growth_exponent([0.0, 2.0], [0.0, 0.0], 8.0, [1.0, 4.0])
    assert float(found.value) == pytest.approx(0.5 * (2.0 + 0.5) * 2.0, rel=ROUNDING)


@examples(50)
@given(
    pressure=st.lists(st.integers(-9, 9), min_size=3, max_size=12),
    vapor=st.integers(0, 9),
    end=st.floats(0.0, 12.0),
)
def test_against_a_fine_sampling(pressure, vapor, end) -> None:
    t = np.arange(float(len(pressure)))
    p = np.array(pressure, dtype=float)
    found = growth_exponent(t, p, float(vapor), np.full_like(t, 0.25), end)
    steps = 2000
    middles = (np.arange(steps * (len(p) - 1)) + 0.5) / steps
    rate = np.maximum(vapor - np.interp(middles, t, p), 0.0) * (middles < end)
    # The midpoint rule is exact but in the sample of each kink, and of the end: 18 is the largest.
    assert float(found.value) == pytest.approx(rate.sum() / steps, abs=18 * len(p) / steps)


def test_every_second_point_tells_the_error() -> None:
    """A parabola that dips below: second order, and the error told is above the true one."""
    depth, mu = 3e5, 800.0
    exact = depth / (4 * mu) * 4 / 3
    errors = []
    for n in (41, 81, 161):
        t = np.linspace(-2.0, 2.0, n) ** 3 / 4
        found = growth_exponent(t, depth * t**2, depth, np.full(n, mu))
        true = abs(float(found.value) - exact)
        assert true < float(found.error) < 6 * true
        errors.append(true)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    # An uneven spacing about the crossing scatters the order by about a tenth.
    assert orders == pytest.approx([2.0, 2.0], abs=0.2)


def test_a_study_at_once_is_its_paths_one_by_one() -> None:
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.1, 1.0, (4, 1, 60)), axis=-1)
    p = np.cumsum(rng.normal(size=(4, 3, 60)), axis=-1) * 1e5
    eta = rng.uniform(100.0, 1000.0, (4, 1, 60))
    vapor, end = np.array([1e5, 3e5, 2e5]), rng.uniform(5.0, 20.0, (4, 1))
    found = growth_exponent(t, p, vapor, eta, end)
    for i in range(4):
        for j in range(3):
            alone = growth_exponent(t[i, 0], p[i, j], vapor[j], eta[i, 0], end[i, 0])
            assert found.value[i, j] == pytest.approx(float(alone.value), rel=ROUNDING)
            assert found.error[i, j] == pytest.approx(float(alone.error), rel=1e-9)


@examples(30)
@given(vapor=st.floats(0.0, 5e6), more=st.floats(0.0, 1e6), thicker=st.floats(1.0, 3.0))
def test_it_grows_with_the_vapor_and_falls_with_the_viscosity(vapor, more, thicker) -> None:
    t = np.linspace(0.0, 1.0, 50)
    p = 1e6 * np.cos(7.0 * t)
    value = float(growth_exponent(t, p, vapor, np.full(50, 800.0)).value)
    assert float(growth_exponent(t, p, vapor + more, np.full(50, 800.0)).value) >= value
    in_thicker = growth_exponent(t, p, vapor, np.full(50, 800.0 * thicker)).value
    assert float(in_thicker) == pytest.approx(value / thicker, rel=ROUNDING)


@pytest.mark.parametrize(
    ("given_", "kind", "message"),
    [
        ({"pressure": [0.0]}, HistoryError, "the same number of points"),
        ({"time": [0.0, 0.0]}, HistoryError, "time must increase strictly"),
        ({"pressure": [0.0, np.nan]}, HistoryError, r"pressure\[1\] = nan is not finite"),
        ({"vapor_pressure": -1.0}, ConfigError, "vapor_pressure = -1 Pa: must be at least 0 Pa"),
        ({"viscosity": [1.0, 0.0]}, ConfigError, "viscosity = 0 Pa s: must be above 0 Pa s"),
        ({"until": np.nan}, HistoryError, "until is no number: leave it away"),
        ({"until": [[1.0, 2.0]], "vapor_pressure": [1.0] * 3}, HistoryError, "do not go together"),
        ({"viscosity": [1.0] * 3}, HistoryError, "do not go together"),
    ],
)
def test_what_is_no_path_is_refused(given_, kind, message) -> None:
    usual = {
        "time": [0.0, 1.0],
        "pressure": [0.0, 0.0],
        "vapor_pressure": 1.0,
        "viscosity": [1.0, 1.0],
    }
    with pytest.raises(kind, match=message):
        growth_exponent(**(usual | given_))
