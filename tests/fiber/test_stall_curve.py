"""The stall curve from cells against single, better cells; what the paper read off its own."""

import numpy as np
import pytest

from fibermelt.errors import ConvergenceError
from fibermelt.fiber import CellNumerics, Ellipse, solve_cell
from fibermelt.fiber.stall import CURVE_NUMERICS, paper_stall_angle, stall_curve
from fibermelt.fiber.stall_data import StallCurve

pytestmark = pytest.mark.verification

FINER = CellNumerics(order=8, angular_spacing=1.0, radial_spacing=1.0, estimate=False)
"""Good to 1e-9, two digits below the curves' own cells."""


@pytest.fixture(scope="module")
def paper_curve() -> StallCurve:
    return stall_curve(6.0)


def test_stall_angles_of_the_papers_fiber(paper_curve: StallCurve) -> None:
    # to the digits given; the angle's error is 1e-6 of B over 2 sin 2 theta
    angles = paper_curve.stall_angle([3.0, 4.0, 5.0])
    assert angles == pytest.approx([0.2004, 0.1292, 0.0539], abs=1e-4)
    assert paper_curve.largest_stalling_domain == pytest.approx(5.293296, abs=2e-5)
    assert paper_curve.value(np.inf) == pytest.approx(35.0 / 37.0, abs=1e-12)
    # Eq. 32 is read off coarse cells: near at 3 and 4, far where the angle goes to zero
    off = np.abs(angles - paper_stall_angle([3.0, 4.0, 5.0]))
    assert off == pytest.approx([0.003, 0.002, 0.018], abs=1e-3)


@pytest.mark.parametrize("ratio", [1.5, 6.0, 20.0])
def test_a_curve_is_as_good_as_it_says(ratio: float, paper_curve: StallCurve) -> None:
    curve = paper_curve if ratio == 6.0 else stall_curve(ratio)
    assert curve.error <= 1e-6
    for M in (2.13, 2.7, 4.7):  # between the points
        cell = solve_cell(Ellipse(42e-6, ratio), M, FINER)
        assert curve.value(M) == pytest.approx(cell.shape_factor, abs=curve.error)
    M = curve.largest_stalling_domain
    factor = solve_cell(Ellipse(42e-6, ratio), M, FINER).shape_factor
    assert factor == pytest.approx(1.0, abs=curve.error)


def test_a_curve_takes_twelve_cells(paper_curve: StallCurve) -> None:
    # twelve cells of 55 ms keep it below a second; the unbounded melt needs none
    assert paper_curve.domain_size.size == 13
    assert np.isinf(paper_curve.domain_size[-1])
    assert np.all(np.isfinite(paper_curve.domain_size[:-1]))


def test_a_rounder_fiber_takes_cells_of_a_higher_order() -> None:
    curve = stall_curve(1.2)
    assert curve.error <= 1e-6
    cell = solve_cell(Ellipse(42e-6, 1.2), 2.13, FINER)
    assert curve.value(2.13) == pytest.approx(cell.shape_factor, abs=curve.error)
    assert curve.largest_stalling_domain == pytest.approx(2.75390, abs=1e-4)


def test_cells_that_cannot_reach_the_tolerance_are_refused() -> None:
    with pytest.raises(ConvergenceError, match=r"order 6\): take a more slender fiber"):
        stall_curve(1.2, numerics=CURVE_NUMERICS)
