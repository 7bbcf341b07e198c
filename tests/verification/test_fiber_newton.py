"""The paper's own algorithm against superposition, on the same elements."""

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    CellNumerics,
    CellSystem,
    Ellipse,
    build_system,
    follow,
    follow_newton,
    surface_pressure,
)
from fibermelt.fiber.newton import NewtonSolver
from fibermelt.fiber.paths import strain_polar
from fibermelt.history import FlowHistory

FIBER = Ellipse(42e-6, 6.0)
MU = 817.0
AGREEMENT = 1e-8  # relative: solver precision, as both are the same linear algebra


def nozzle_like(points: int) -> FlowHistory:
    """Fast, sheared and stretched as in a nozzle: |u|/a is far above |L|."""
    t = np.linspace(0.0, 0.05, points)
    L = np.empty((points, 2, 2))
    L[:, 0, 0] = -20.0 * np.cos(40.0 * t)
    L[:, 1, 1] = -L[:, 0, 0]
    L[:, 0, 1] = 30.0 * np.sin(60.0 * t)
    L[:, 1, 0] = -80.0 - 40.0 * np.sin(50.0 * t)
    velocity = np.stack([0.02 * np.sin(50.0 * t), np.full(points, -0.1)], axis=-1)
    position = np.stack([0.0004 * (1.0 - np.cos(50.0 * t)), -0.1 * t], axis=-1)
    return FlowHistory(t, position, velocity, L, 1e5 * (1.0 - t))


@pytest.fixture(scope="module", params=["cell-edge", "far-node"])
def system(request: pytest.FixtureRequest) -> CellSystem:
    return build_system(FIBER, 4.0, CellNumerics(order=4, pressure_reference=request.param))


def test_agrees_with_superposition(system: CellSystem) -> None:
    history = nozzle_like(17)
    response = system.response
    run = follow_newton(system, FIBER, history, MU, 0.7)
    size, double = strain_polar(history.gradient)
    phase = double - 2.0 * run.angle
    spin = history.spin + response.shape_factor * size * np.sin(phase)
    assert run.spin == pytest.approx(spin, abs=AGREEMENT * size.max())
    shape = np.stack([np.cos(phase), np.sin(phase)], axis=-1) @ response.basis.T
    pressure = MU * size[:, None] * shape
    scale = np.abs(pressure).max()
    assert run.surface_pressure == pytest.approx(pressure, abs=AGREEMENT * scale)
    # the fiber goes with the melt
    assert run.velocity == pytest.approx(history.velocity, abs=AGREEMENT * 0.1)
    # one correction a stage at most but for rounding, and two solves a stage
    assert run.solves <= 3 + 3 * (4 * 16 + 1)


def test_runge_kutta_reaches_the_linear_systems_angles(system: CellSystem) -> None:
    """Fourth order in the step, towards `follow` on the same history."""
    fine = nozzle_like(129)
    errors = []
    for stride in (16, 8):
        take = slice(None, None, stride)
        coarse = FlowHistory(
            fine.time[take],
            fine.position[take],
            fine.velocity[take],
            fine.gradient[take],
            fine.pressure[take],
        )
        run = follow_newton(system, FIBER, coarse, MU, 0.7)
        exact = follow(coarse, system.response.shape_factor, np.array([0.7])).angle[0]
        errors.append(np.max(np.abs(run.angle - exact)))
    assert 3.0 < np.log2(errors[0] / errors[1]) < 5.5  # one pair only, far from the limit
    assert errors[1] < 1e-2


def test_extremes_over_the_nodes(system: CellSystem) -> None:
    history = nozzle_like(9)
    run = follow_newton(system, FIBER, history, MU, 0.7)
    motion = follow(history, system.response.shape_factor, np.array([0.7]))
    motion_pressure = surface_pressure(history, system.response, MU, motion)
    scale = np.abs(motion_pressure.highest).max()
    start = (run.lowest[0], run.highest[0])
    expected = (motion_pressure.lowest[0, 0], motion_pressure.highest[0, 0])
    # the nodes miss the extreme by the tip's curvature times their spacing squared
    assert start == pytest.approx(expected, abs=5e-3 * scale)


def test_force_free_in_any_uniform_flow(system: CellSystem) -> None:
    solver = NewtonSolver(system)
    rates, unknowns = solver.solve(np.array([3.0, -2.0, 0.0, -5.0, 5.0, 0.0]), np.zeros(3))
    assert rates == pytest.approx([3.0, -2.0, 5.0], abs=AGREEMENT)  # as a rigid body with the melt
    assert solver.surface_pressure(unknowns) == pytest.approx(0.0, abs=1e-6)


def test_another_fiber_is_refused(system: CellSystem) -> None:
    with pytest.raises(ConfigError, match="built for 6"):
        follow_newton(system, Ellipse(42e-6, 5.0), nozzle_like(3), MU, 0.0)
