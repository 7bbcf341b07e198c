"""Observed orders: the cell towards the unbounded melt, the motion towards smooth histories."""

import numpy as np
import pytest

from fibermelt.fiber import (
    CellNumerics,
    Ellipse,
    follow,
    paper_angles,
    solve_cell,
    unbounded_ellipse,
)
from fibermelt.verify.fiber_motion import reference_angles, swinging

pytestmark = pytest.mark.verification

FIBER = Ellipse(42e-6, 6.0)


def test_the_cell_becomes_the_unbounded_ellipse() -> None:
    """``B - xi`` and the surface pressure's difference fall like ``M^-2``.

    The fiber's far field is a stresslet, ``u ~ 1/r``; the wall reflects it as a strain of the
    order of ``(a/R)^2``. The finite elements' 1e-5 of the pressure bounds the largest cell.
    """
    exact = unbounded_ellipse(FIBER)
    domains = np.array([20.0, 40.0, 80.0])
    factor, pressure = [], []
    for domain in domains:
        cell = solve_cell(FIBER, float(domain), CellNumerics(order=8, estimate=False))
        response = cell.response
        factor.append(response.shape_factor - exact.shape_factor)
        difference = response.curve.point(exact.surface) - exact.basis
        pressure.append(np.max(np.abs(difference)) / exact.support.largest)
    for errors in (np.array(factor), np.array(pressure)):
        orders = np.log2(errors[:-1] / errors[1:])
        assert orders == pytest.approx(2.0, abs=0.05)
    assert factor[-1] < 2.1e-3
    assert pressure[-1] < 2e-3


@pytest.mark.parametrize("factor", [0.9459, 1.0344])
def test_fourth_order_in_the_spacing_of_the_history(factor: float) -> None:
    exact = reference_angles(factor)
    errors = []
    for points in (129, 257, 513):
        motion = follow(swinging(points), factor, paper_angles())
        errors.append(np.max(np.abs(motion.angle[:, -1] - exact)))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx(4.0, abs=0.2)
    # at 2049 points the interpolant is good to 1e-9, and the time integration must not be worse
    fine = follow(swinging(2049), factor, paper_angles())
    assert fine.angle[:, -1] == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_the_tolerance_is_kept(tolerance: float) -> None:
    history = swinging(257)
    exact = follow(history, 0.9459, paper_angles(), 1e-12)
    motion = follow(history, 0.9459, paper_angles(), tolerance)
    error = np.max(np.abs(motion.angle - exact.angle))
    assert error <= tolerance
    assert motion.substeps <= exact.substeps
