"""Directors in three dimensions against an independent integration of Jeffery's equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fibermelt.fiber import equal_area_directions, follow_directors
from fibermelt.fiber.directors import GradientPath

STARTS = equal_area_directions(5)
DURATION = 12.0


def gradient(t: float | np.ndarray) -> np.ndarray:
    """All nine components, none in step with another; the shear rules."""
    time = np.asarray(t)[..., None, None]
    rate = 1.0 + 0.3 * np.arange(3)[:, None] + 0.17 * np.arange(3)
    L = 0.3 * np.cos(rate * time + np.arange(3)) + np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0]])
    trace = np.trace(L, axis1=-2, axis2=-1)
    return L - trace[..., None, None] / 3.0 * np.eye(3)


class Smooth:
    def __init__(self, points: int) -> None:
        self.time = np.linspace(0.0, DURATION, points)
        self.gradient = gradient(self.time)


def path(points: int) -> GradientPath:
    return Smooth(points)


def reference(factor: float) -> np.ndarray:
    """A Runge-Kutta method of order eight on the nonlinear equation, from the formula itself."""

    def rate(t: float, flat: np.ndarray) -> np.ndarray:
        p, L = flat.reshape(-1, 3), gradient(t)
        D, W = 0.5 * (L + L.T), 0.5 * (L - L.T)
        stretch = np.einsum("ni,ij,nj->n", p, D, p)[:, None]
        return np.ravel(p @ W.T + factor * (p @ D - stretch * p))

    run = solve_ivp(rate, (0.0, DURATION), STARTS.ravel(), "DOP853", rtol=1e-12, atol=1e-13)
    return run.y[:, -1].reshape(-1, 3)


@pytest.mark.parametrize("factor", [0.9459, -0.8, 1.0344])
def test_fourth_order_in_the_spacing_of_the_history(factor: float) -> None:
    exact = reference(factor)
    errors = []
    for points in (129, 257, 513):
        motion = follow_directors(path(points), factor, STARTS)
        errors.append(np.max(np.abs(motion.direction[:, -1] - exact)))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx(4.0, abs=0.25)
    # at 2049 points the interpolant is good to some 1e-9, and the integration must not be worse
    fine = follow_directors(path(2049), factor, STARTS)
    assert fine.direction[:, -1] == pytest.approx(exact, abs=1e-8)
    assert np.sum(fine.direction**2, axis=-1) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_the_tolerance_is_kept(tolerance: float) -> None:
    exact = follow_directors(path(65), 0.9459, STARTS, 1e-12)
    motion = follow_directors(path(65), 0.9459, STARTS, tolerance)
    assert np.max(np.abs(motion.direction - exact.direction)) <= tolerance
    assert motion.substeps <= exact.substeps
