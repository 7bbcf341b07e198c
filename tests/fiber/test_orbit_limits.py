"""Orbits of confined fibers: towards Jeffery's as the cell grows, and by the paper's algorithm."""

import numpy as np
import pytest

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber import (
    CellNumerics,
    CellSystem,
    Ellipse,
    build_system,
    newton_orbit,
    orbit,
    orbit_newton,
    solve_cell,
)

pytestmark = pytest.mark.verification

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


@pytest.mark.parametrize(
    ("ratio", "printed", "band"),
    [(3.0, 21.24, 5e-3), (6.0, 39.53, 2e-3), (8.0, 52.32, 2e-3), (10.0, 65.34, 2e-3)],
)
def test_one_cell_has_the_periods_that_table_1_gives_its_finite_elements(
    ratio: float, printed: float, band: float
) -> None:
    """A converged cell of ``M = 28``; ``T_fea`` itself scatters by 0.8 percent with the rate.

    (Times the rate it must be one number at ``r_e = 6``: the table has 39.37 to 39.98.)
    """
    response = solve_cell(Ellipse(1.0, ratio), 28.0, CellNumerics(estimate=False)).response
    assert orbit(response, 1.0, MU).period == pytest.approx(printed, rel=band)


def test_a_circle_has_jefferys_period_in_any_cell() -> None:
    """It has no way to answer a strain: Table 1's 12.87 s is no effect of the cell."""
    for numerics in (CellNumerics(estimate=False), CellNumerics(mesh="paper", estimate=False)):
        response = solve_cell(Ellipse(1.0, 1.0), 4.0, numerics).response
        assert orbit(response, 1.0, MU).period == pytest.approx(4.0 * np.pi, rel=SOLVER)


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
    monkeypatch.setattr(newton_orbit, "LONGEST_TURN", 1)  # it takes 1.04 of them
    with pytest.raises(ConvergenceError, match="turned by 6"):
        orbit_newton(tumbling, 1.0, MU, steps=40)
