"""Orbits of confined fibers: towards Jeffery's as the cell grows, and by the paper's algorithm."""

import numpy as np
import pytest

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber import CellNumerics, CellSystem, Ellipse, build_system, solve_cell
from fibermelt.fiber import orbit_newton as orbit_newton_module
from fibermelt.fiber.orbit import orbit
from fibermelt.fiber.orbit_newton import orbit_newton

FIBER = Ellipse(42e-6, 6.0)
MU = 817.0
COARSE = CellNumerics(order=2)  # both paths have the same elements: they need not be good
SOLVER = 1e-8


def test_period_and_pressure_become_jefferys_like_the_square_of_the_cell() -> None:
    """``B - xi ~ M^-2`` (`test_fiber_limits`), and so are period and pressure."""
    domains = (20.0, 40.0, 80.0)
    numerics = CellNumerics(order=8, estimate=False)
    orbits = [orbit(solve_cell(FIBER, m, numerics).response, 1.0, MU) for m in domains]
    for errors in (
        [result.period / result.period_jeffery - 1.0 for result in orbits],
        [result.max_pressure / (7.0 * MU) - 1.0 for result in orbits],
    ):
        orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
        # the period is not linear in B: 1/(1 - B^2) moves by a third at M = 20
        assert orders == pytest.approx(2.0, abs=0.1)
        assert orders[-1] == pytest.approx(2.0, abs=0.05)
    assert orbits[-1].max_pressure == pytest.approx(7.0 * MU, rel=2e-3)
    assert orbits[-1].period == pytest.approx(orbits[-1].period_jeffery, rel=3e-3)
    assert orbits[-1].angle_at_min == pytest.approx(0.25 * np.pi, abs=1e-9)  # by symmetry
    assert orbits[-1].where_at_min == pytest.approx(0.0, abs=1e-9)


@pytest.fixture(scope="module")
def tumbling() -> CellSystem:
    return build_system(FIBER, 20.0, COARSE)


def test_the_papers_algorithm_over_one_turn(tumbling: CellSystem) -> None:
    exact = orbit(tumbling.response, 1.0, MU)
    found = orbit_newton(tumbling, 1.0, MU, angle=0.3)
    assert exact.period is not None
    assert found.shape_factor == pytest.approx(exact.shape_factor, abs=SOLVER)
    # 400 steps of fourth order: the next test's error
    assert found.period == pytest.approx(exact.period, rel=3e-7)
    assert not found.stalls
    # steps turn by up to 0.1 rad, so a peak is missed by half of that: 1 - cos(0.1)
    for name in ("max_pressure", "min_pressure", "tip_max", "tip_min"):
        ratio = getattr(found, name) / getattr(exact, name)
        assert 1.0 - 5e-3 < ratio <= 1.0 + SOLVER
    assert found.angle_at_min == pytest.approx(exact.angle_at_min, abs=0.05)
    assert found.where_at_min == pytest.approx(0.0, abs=1e-12)
    assert found.steps == pytest.approx(400.0 * found.period / found.period_jeffery, abs=1.0)
    assert found.solves > 4 * found.steps


def test_period_is_of_fourth_order_in_the_step(tumbling: CellSystem) -> None:
    exact = orbit(tumbling.response, 1.0, MU).period
    assert exact is not None
    errors = [
        abs(orbit_newton(tumbling, 1.0, MU, 0.3, steps).period / exact - 1.0)
        for steps in (50, 100, 200)
    ]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders[-1] == pytest.approx(4.0, abs=0.3)


def test_shear_rate_scales_time_and_pressure(tumbling: CellSystem) -> None:
    one, five = (orbit_newton(tumbling, rate, MU, steps=40) for rate in (1.0, 5.0))
    assert one.period == pytest.approx(5.0 * five.period, rel=SOLVER)
    assert five.max_pressure == pytest.approx(5.0 * one.max_pressure, rel=SOLVER)


def test_half_a_turn_where_it_stalls() -> None:
    system = build_system(FIBER, 4.0, COARSE)
    exact = orbit(system.response, 1.0, MU)
    found = orbit_newton(system, 1.0, MU, angle=0.1, steps=180)
    assert found.period is None
    assert found.stalls
    assert found.steps == 180
    assert found.shape_factor == pytest.approx(exact.shape_factor, abs=SOLVER)
    assert found.stall_angle == pytest.approx(exact.stall_angle, abs=SOLVER)
    # one degree between angles: 1 - cos(2 x 0.5 deg), and h is smooth at its top
    assert found.min_pressure == pytest.approx(exact.min_pressure, rel=2e-4)
    assert found.angle_at_min == pytest.approx(exact.angle_at_min, abs=np.radians(1.0))


def test_too_few_steps(tumbling: CellSystem) -> None:
    with pytest.raises(ConfigError, match="steps = 4"):
        orbit_newton(tumbling, 1.0, MU, steps=4)


def test_a_turn_that_takes_too_long(tumbling: CellSystem, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(orbit_newton_module, "LONGEST_TURN", 1)  # it takes 1.04 of them
    with pytest.raises(ConvergenceError, match="turned by 6"):
        orbit_newton(tumbling, 1.0, MU, steps=40)
