"""The paper's algorithm in a melt that thins, against the table, on the same elements."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import CellNumerics, Ellipse, follow, follow_newton, surface_pressure
from fibermelt.fiber.cell import ThinningFiber, solve_thinning
from fibermelt.history import FlowHistory
from fibermelt.melt import PowerLaw

pytestmark = pytest.mark.verification

FIBER = Ellipse(42e-6, 3.0)
LAW = PowerLaw(8213.0, 0.5, 1e-2)
NUMERICS = CellNumerics(order=3, estimate=False)

TABLE = 2e-5
"""Angle [rad]: terms of the spin that the table leaves out, 2e-6, over a strain of a few units."""

NODES = 2e-2
"""Part of the largest pressure by which elements of order 3 tell an extreme at their nodes from one
between them."""


def nozzle_like(points: int) -> FlowHistory:
    """Sheared and stretched as in a nozzle, the melt coming along in a straight line."""
    t = np.linspace(0.0, 0.01, points)
    L = np.zeros((points, 2, 2))
    L[:, 0, 0] = -20.0 * np.cos(40.0 * t)
    L[:, 1, 1] = -L[:, 0, 0]
    L[:, 0, 1] = 30.0 * np.sin(60.0 * t)
    L[:, 1, 0] = -80.0 - 40.0 * np.sin(50.0 * t)
    velocity = np.tile([0.0, -0.1], (points, 1))
    return FlowHistory(t, velocity * t[:, None], velocity, L, 1e5 * (1.0 - t))


def test_both_ways_agree() -> None:
    history = nozzle_like(9)
    free = ThinningFiber(FIBER, 4.0, LAW, NUMERICS)
    run = follow_newton(free, FIBER, history, 1.0, 0.7)
    table = solve_thinning(FIBER, 4.0, LAW, NUMERICS)
    motion = follow(history, table, [0.7])
    pressure = surface_pressure(history, table, LAW, motion)
    assert np.abs(run.angle - motion.angle).max() < TABLE
    largest = np.abs(pressure.lowest).max()
    for found, exact in ((run.lowest, pressure.lowest), (run.highest, pressure.highest)):
        assert np.abs(found - exact).max() < NODES * largest
    assert run.solves >= 4 * (len(history) - 1)


def test_another_fiber_is_refused() -> None:
    free = ThinningFiber(FIBER, 4.0, LAW, NUMERICS)
    with pytest.raises(ConfigError, match=r"fiber\.aspect_ratio = 5, but the cell was built for 3"):
        follow_newton(free, Ellipse(42e-6, 5.0), nozzle_like(3), 1.0, 0.0)
