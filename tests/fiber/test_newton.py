"""The paper's own algorithm against superposition, on the same elements."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    CellNumerics,
    CellSystem,
    Ellipse,
    NewtonMotion,
    build_system,
    extremes,
    follow,
    follow_newton,
    surface_pressure,
)
from fibermelt.fiber.newton import NewtonSolver
from fibermelt.fiber.paths import strain_polar
from fibermelt.flow.deposition import FlowSolution
from fibermelt.flow.streamlines import Streamline, trace_streamlines
from fibermelt.history import FlowHistory

pytestmark = pytest.mark.verification

FIBER = Ellipse(42e-6, 6.0)
MU = 817.0
TURN = 2.0 * np.pi
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


def every_nth(history: FlowHistory, every: int) -> FlowHistory:
    """Return a history with fewer points."""
    columns = (history.time, history.position, history.velocity, history.gradient, history.pressure)
    return FlowHistory(*(column[::every] for column in columns))


@pytest.fixture(scope="module", params=["mean", "far-node"])
def system(request: pytest.FixtureRequest) -> CellSystem:
    return build_system(FIBER, 4.0, CellNumerics(order=4, pressure_reference=request.param))


@pytest.fixture(scope="module")
def small_system() -> CellSystem:
    return build_system(FIBER, 4.0, CellNumerics(order=2))


@pytest.fixture(scope="module")
def coarse_lines(coarse_flow: FlowSolution) -> tuple[Streamline, ...]:
    """The paper's streamlines in 300 steps each."""
    return trace_streamlines(coarse_flow, points=301)


def assert_agrees(system: CellSystem, history: FlowHistory, run: NewtonMotion) -> None:
    """Compare spin and surface pressure at every step, relative to ``|D|`` there and then."""
    response = system.response
    size, double = strain_polar(history.gradient)
    phase = double - 2.0 * run.angle
    spin = history.spin + response.shape_factor * size * np.sin(phase)
    assert np.max(np.abs(run.spin - spin) / size) < AGREEMENT
    shape = np.stack([np.cos(phase), np.sin(phase)], axis=-1) @ response.basis.T
    pressure = MU * size[:, None] * shape
    assert np.max(np.abs(run.surface_pressure - pressure) / (MU * size[:, None])) < AGREEMENT
    tip = MU * size * (np.stack([np.cos(phase), np.sin(phase)], axis=-1) @ response.tip)
    assert np.max(np.abs(run.tip - tip) / (MU * size)) < AGREEMENT
    # the fiber goes with the melt
    fastest = np.abs(history.velocity).max()
    assert run.velocity == pytest.approx(
        np.broadcast_to(history.velocity[:, :2], run.velocity.shape), abs=AGREEMENT * fastest
    )


def test_agrees_with_superposition(system: CellSystem) -> None:
    history = nozzle_like(17)
    run = follow_newton(system, FIBER, history, MU, np.array([0.7, -1.2]))
    assert run.initial_angles.tolist() == run.angle[:, 0].tolist() == [0.7, -1.2]
    assert_agrees(system, history, run)
    # one correction a stage at most but for rounding, and two solves a stage
    assert run.solves <= 3 + 2 * 3 * (4 * 16 + 1)


@pytest.mark.parametrize("index", [10, 4])
def test_agrees_along_a_streamline_of_the_papers_flow(
    coarse_lines: tuple[Streamline, ...], index: int
) -> None:
    line = coarse_lines[index - 1]
    assert line.index == index
    history = line.history
    system = build_system(FIBER, 4.0, CellNumerics(order=3))
    run = follow_newton(system, FIBER, history, MU, 0.3)
    assert_agrees(system, history, run)
    motion = follow(history, system.response.shape_factor, np.array([0.3]))
    # 300 Runge-Kutta steps in all, the sharpest turn at the nozzle's exit among them
    assert run.angle == pytest.approx(motion.angle, abs=1e-5)
    length = np.abs(np.diff(history.position, axis=0)).sum()
    assert run.position[0] == pytest.approx(history.position[:, :2], abs=1e-5 * length)
    pressure = surface_pressure(history, system.response, MU, motion)
    exact = extremes(history, pressure, motion, line.zone_time)
    found = extremes(history, run, run, line.zone_time)
    assert found.index.tolist() == exact.index.tolist()
    # the surface points miss the extremes by the tip's curvature times their spacing squared
    assert found.value == pytest.approx(exact.value, rel=5e-3)
    assert found.angle == pytest.approx(exact.angle, abs=1e-5)
    spacing = 2.0 * np.pi / run.surface.size
    assert found.where.shape == exact.where.shape
    tips = np.abs(exact.where) < 0.1  # on the flanks the pressure is flat, and the ends meet
    assert np.any(tips)
    assert found.where[tips] == pytest.approx(exact.where[tips], abs=spacing)


def test_runge_kutta_is_of_fourth_order(small_system: CellSystem) -> None:
    """Towards the exact propagator on the same interpolated history."""
    errors = []
    for points in (33, 65, 129):
        history = nozzle_like(points)
        run = follow_newton(small_system, FIBER, history, MU, 0.7)
        exact = follow(history, small_system.response.shape_factor, np.array([0.7]), 1e-12)
        errors.append(np.max(np.abs(run.angle - exact.angle)))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("index", [4, 10])
def test_orders_along_a_streamline_of_the_papers_flow(
    small_system: CellSystem, paper_lines: tuple[Streamline, ...], index: int
) -> None:
    """Both paths on every 16th, 8th and 4th point of a streamline through the nozzle.

    On the same points the paths differ by Runge and Kutta's error, of fourth order. Both approach
    the fiber on all points with the history: its gradient has kinks where the flow's elements
    meet, so that dropping points costs an error of second order or somewhat better, the same in
    either path and a hundred times the difference between them.
    """
    history = paper_lines[index - 1].history
    factor = small_system.response.shape_factor
    start = np.array([0.3])
    fine = follow(history, factor, start, 1e-12).angle
    between, ours, papers = [], [], []
    for every in (16, 8, 4):
        thin = every_nth(history, every)
        exact = follow(thin, factor, start, 1e-12).angle
        run = follow_newton(small_system, FIBER, thin, MU, start).angle
        reference = fine[:, ::every]
        between.append(np.max(np.abs(run - exact)))
        ours.append(np.max(np.abs(exact - reference)))
        papers.append(np.max(np.abs(run - reference)))
    assert np.log2(between[0] / between[-1]) / 2 == pytest.approx(4.0, abs=0.4)
    for errors in (ours, papers):
        # kinks fall between other points each time: the order is that of both halvings together
        assert np.log2(errors[0] / errors[-1]) / 2 > 2.0
    assert papers == pytest.approx(ours, rel=0.05)


def test_extremes_over_the_nodes(system: CellSystem) -> None:
    history = nozzle_like(9)
    run = follow_newton(system, FIBER, history, MU, 0.7)
    motion = follow(history, system.response.shape_factor, np.array([0.7]))
    exact = surface_pressure(history, system.response, MU, motion)
    scale = np.abs(exact.highest).max()
    # the nodes miss the extreme by the tip's curvature times their spacing squared
    assert run.lowest[:, 0] == pytest.approx(exact.lowest[:, 0], abs=5e-3 * scale)
    assert run.highest[:, 0] == pytest.approx(exact.highest[:, 0], abs=5e-3 * scale)
    spacing = 2.0 * np.pi / run.surface.size
    assert run.where_lowest[:, 0] == pytest.approx(exact.where_lowest[:, 0], abs=spacing)
    assert run.where_highest[:, 0] == pytest.approx(exact.where_highest[:, 0], abs=spacing)
    at = run.surface_pressure[0, 3, np.argmin(np.abs(run.surface - run.where_lowest[0, 3] % TURN))]
    assert at == run.lowest[0, 3]


def test_force_free_in_any_uniform_flow(system: CellSystem) -> None:
    solver = NewtonSolver(system)
    rates, unknowns = solver.solve(np.array([3.0, -2.0, 0.0, -5.0, 5.0, 0.0]), np.zeros(3))
    assert rates == pytest.approx([3.0, -2.0, 5.0], abs=AGREEMENT)  # as a rigid body with the melt
    assert solver.surface_pressure(unknowns) == pytest.approx(0.0, abs=1e-6)


def test_another_fiber_is_refused(system: CellSystem) -> None:
    with pytest.raises(ConfigError, match="built for 6"):
        follow_newton(system, Ellipse(42e-6, 5.0), nozzle_like(3), MU, 0.0)


@pytest.mark.parametrize(
    ("viscosity", "angle", "message"),
    [(0.0, 0.0, "melt.viscosity = 0"), (MU, np.nan, "initial_angles"), (MU, [], "initial_angles")],
)
def test_unusable_input(
    small_system: CellSystem, viscosity: float, angle: float, message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        follow_newton(small_system, FIBER, nozzle_like(3), viscosity, angle)
