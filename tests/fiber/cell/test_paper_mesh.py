"""The paper's own mesh: that it is what its Fig. 6 says, and what it leaves open.

The numbers of its discretisation error are measured, against the graded mesh, which agrees with a
series solution to 1e-8 (`test_fiber_cell`): the bands say how far a change may move them unseen.
"""

import numpy as np
import pytest

from fibermelt.fiber import (
    CellNumerics,
    CellSolution,
    CellSystem,
    Ellipse,
    build_system,
    follow_newton,
    solve_cell,
)
from fibermelt.fiber.cell.triangles import paper_mesh
from fibermelt.fiber.cell_paper import PaperGrid
from fibermelt.fiber.newton import NewtonSolver
from fibermelt.fiber.paths import strain_polar
from fibermelt.history import simple_shear

pytestmark = pytest.mark.verification

FIBER = Ellipse(42e-6, 6.0)
PAPER = CellNumerics(mesh="paper")
ROUNDING = 1e-12
SOLVER = 1e-8  # of velocities and pressures: both are the same linear algebra


@pytest.fixture(scope="module")
def papers_cell() -> CellSolution:
    return solve_cell(FIBER, 4.0, PAPER)


@pytest.fixture(scope="module")
def system() -> CellSystem:
    return build_system(FIBER, 4.0, PAPER)


def test_all_six_nodes_of_1800_triangles_are_where_the_grid_has_them(
    papers_cell: CellSolution,
) -> None:
    assert papers_cell.elements == 1800
    assert papers_cell.unknowns == 2 * 60 * 59 + 30 * 31  # free velocities, and pressures
    nodes = PaperGrid(1.0 / 6.0, 2.0).nodes()
    assert papers_cell.points == pytest.approx(nodes.reshape(-1, 2), abs=ROUNDING)
    assert papers_cell.cells.shape == (4 * 1800, 3)
    assert papers_cell.element_edges.shape == (30 * 31 + 2 * 30 * 30, 3)
    a, b, c = (papers_cell.points[papers_cell.cells[:, k]] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert np.all(area > 0.0)


def test_edges_are_curved() -> None:
    """Sixty parabolas follow the walls to fourth order; sixty chords would miss 2e-3 of it."""
    import ngsolve as ng  # noqa: PLC0415  only this test looks inside

    mesh = paper_mesh(PaperGrid(1.0 / 6.0, 2.0)).mesh
    area = ng.Integrate(ng.CF(1.0), mesh, order=6)
    assert area == pytest.approx(np.pi * (4.0 - 1.0 / 6.0), rel=2e-5)


def test_uniform_and_rigid_flows_are_exact(system: CellSystem) -> None:
    """The patch test: isoparametric elements hold every linear velocity, at pressure zero."""
    solver = NewtonSolver(system)
    rates, unknowns = solver.solve(np.array([3.0, -2.0, 0.0, -5.0, 5.0, 0.0]), np.zeros(3))
    assert rates == pytest.approx([3.0, -2.0, 5.0], abs=SOLVER)
    assert solver.surface_pressure(unknowns) == pytest.approx(0.0, abs=1e-6)


def test_walls(papers_cell: CellSolution) -> None:
    x, y = papers_cell.points.T
    on_fiber = np.abs(np.hypot(x, 6.0 * y) - 1.0) < ROUNDING
    on_edge = np.abs(np.hypot(x, y) - 2.0) < ROUNDING
    assert on_fiber.sum() == on_edge.sum() == 60
    far = [np.stack([x, -y], axis=-1), np.stack([y, x], axis=-1)]
    for mode, spin in enumerate((papers_cell.handedness, papers_cell.shape_factor)):
        turning = spin * np.stack([-y, x], axis=-1)
        velocity = papers_cell.velocity[:, mode]
        assert velocity[on_edge] == pytest.approx(far[mode][on_edge], abs=ROUNDING)
        assert velocity[on_fiber] == pytest.approx(turning[on_fiber], abs=ROUNDING)


def test_discretisation_error_at_the_papers_domain_size(papers_cell: CellSolution) -> None:
    """``B`` to 1.3e-4, the tip pressure 14.5 percent too high: 12 degrees span the tip."""
    graded = solve_cell(FIBER, 4.0)
    assert papers_cell.shape_factor - graded.shape_factor == pytest.approx(1.34e-4, abs=1e-6)
    assert papers_cell.tip_pressure / graded.tip_pressure == pytest.approx(1.145, abs=1e-3)
    assert papers_cell.stall_angle == pytest.approx(0.1295, abs=5e-5)  # 0.1292 converged
    estimate = papers_cell.error_estimate
    assert estimate is not None
    shape_error = abs(papers_cell.shape_factor - graded.shape_factor)
    tip_error = papers_cell.tip_pressure / graded.tip_pressure - 1.0
    assert estimate.shape_factor == pytest.approx(shape_error, rel=1e-6)
    assert estimate.tip_pressure == pytest.approx(tip_error, rel=1e-6)
    assert estimate.surface_pressure == pytest.approx(tip_error, rel=0.02)  # it is worst there


def test_period_error_in_a_cell_large_enough_for_jeffery() -> None:
    """At ``M = 40`` the cell adds 0.95 percent to Jeffery's period, the mesh 0.36 more."""
    periods = []
    for numerics in (CellNumerics(estimate=False), CellNumerics(mesh="paper", estimate=False)):
        factor = solve_cell(FIBER, 40.0, numerics).shape_factor
        periods.append(4.0 * np.pi / np.sqrt(1.0 - factor**2))
    assert periods == pytest.approx([39.1148, 39.2548], abs=2e-4)


def test_surface_points_are_the_vertices(papers_cell: CellSolution) -> None:
    """Linear pressure has its extremes there, and the curve between passes through them."""
    response = papers_cell.response
    at_nodes = papers_cell.pressure.reshape(60, 61, 2)[::2, 0]
    assert response.basis.tolist() == at_nodes.tolist()
    assert response.curve.point(response.surface) == pytest.approx(at_nodes, abs=1e-10)
    middle = papers_cell.pressure.reshape(60, 61, 2)[1::2, 0]
    mean = 0.5 * (at_nodes + np.roll(at_nodes, -1, axis=0))
    assert middle == pytest.approx(mean, abs=1e-10)


def test_handedness_is_small_and_the_graded_mesh_has_none(papers_cell: CellSolution) -> None:
    assert papers_cell.handedness == pytest.approx(3.0e-5, abs=2e-6)
    graded = solve_cell(FIBER, 4.0, CellNumerics(estimate=False))
    assert abs(graded.handedness) < SOLVER


def test_far_node_reference() -> None:
    node = solve_cell(
        FIBER, 4.0, CellNumerics(mesh="paper", pressure_reference="far-node", estimate=False)
    )
    far = np.argmin(np.hypot(node.points[:, 0] - 2.0, node.points[:, 1]))
    assert node.pressure[far] == pytest.approx(0.0, abs=1e-9 * node.tip_pressure)


def test_where_the_reference_node_lies_moves_the_tip_pressure() -> None:
    """By -12 percent ahead of the tips to +7 beside the fiber; the paper prints no place."""
    cell = solve_cell(FIBER, 4.0, CellNumerics(estimate=False))
    on_edge = np.abs(np.hypot(*cell.points.T) - 2.0) < 1e-6  # how well order 7 follows the wall
    stretching = cell.pressure[on_edge, 0]
    assert stretching[np.argmax(cell.points[on_edge, 0])] == pytest.approx(stretching.min())
    assert stretching[np.argmax(cell.points[on_edge, 1])] == pytest.approx(stretching.max())
    tip = cell.response.basis[:, 0].min()
    moved = [(tip - level) / tip - 1.0 for level in (stretching.min(), stretching.max())]
    assert moved == pytest.approx([-0.119, 0.070], abs=1e-3)


def test_newton_and_superposition_on_the_papers_mesh(
    system: CellSystem, papers_cell: CellSolution
) -> None:
    """Pressure to solver precision; spin up to the handedness, which superposition leaves out."""
    history = simple_shear(1.0, 4.0, 9)
    response = system.response
    run = follow_newton(system, FIBER, history, 817.0, 0.4)
    size, double = strain_polar(history.gradient)
    phase = double - 2.0 * run.angle[0]
    local = response.shape_factor * np.sin(phase) + papers_cell.handedness * np.cos(phase)
    assert run.spin[0] == pytest.approx(history.spin + size * local, abs=SOLVER)
    shape = np.stack([np.cos(phase), np.sin(phase)], axis=-1) @ response.basis.T
    pressure = 817.0 * size[:, None] * shape
    assert run.surface_pressure[0] == pytest.approx(pressure, abs=SOLVER * 817.0)
