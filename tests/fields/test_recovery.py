"""Gradients recovered from nodal velocities: exact for cubics, their error told, walls kept."""

from __future__ import annotations

import numpy as np
import pytest
from exact_flows import (
    COUETTE,
    MILL,
    PIPE,
    ROTATION,
    SLIT,
    ExactFlow,
    Mesh,
    box,
    embedded,
    rectangle,
)
from scipy.sparse import csr_array

from fibermelt.fields.averaging import cells_to_nodes
from fibermelt.fields.recovery import recovered_gradient
from fibermelt.fields.simplices import boundary_nodes, facets

ROUNDING = 1e-9
"""Of gradients of order one: 1e-16 times the condition of a fit, below 1e6 on these meshes."""


def recovered(flow: ExactFlow, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each node's error of the gradient, its estimate, and whether it is on the boundary."""
    mesh = flow.mesh(n)
    x = embedded(mesh.points)
    d = mesh.points.shape[1]
    slope, doubt = recovered_gradient(mesh.points, mesh.cells, flow.velocity(x)[:, :d])
    error = np.linalg.norm(slope - flow.gradient(x)[:, :d, :d], axis=(1, 2))
    return error, doubt, boundary_nodes(mesh.points, mesh.cells, facets(mesh.cells))


@pytest.mark.parametrize("flow", [COUETTE, SLIT, ROTATION, PIPE], ids=lambda flow: flow.name)
def test_quadratics_are_exact_up_to_the_wall(flow: ExactFlow) -> None:
    error, doubt, _ = recovered(flow, 4)
    assert error.max() < ROUNDING
    assert doubt.max() < ROUNDING


@pytest.mark.parametrize("mesh", [rectangle(5), box(4)])
def test_cubics_are_exact_and_not_transposed(mesh: Mesh) -> None:
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    u = np.column_stack([x * y**2, x**3 - y])
    slope, doubt = recovered_gradient(mesh.points, mesh.cells, u)
    np.testing.assert_allclose(slope[:, 0, 0], y**2, atol=ROUNDING)
    np.testing.assert_allclose(slope[:, 0, 1], 2 * x * y, atol=ROUNDING)
    np.testing.assert_allclose(slope[:, 1, 0], 3 * x**2, atol=ROUNDING)
    np.testing.assert_allclose(slope[:, 1, 1], -1, atol=ROUNDING)
    assert doubt.max() > 0.01  # a quadratic does not do it


def test_stretched_cells_change_nothing() -> None:
    """A layer of cells a thousand times as long as wide, turned by 30 degrees."""
    mesh = rectangle(6)
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    points = mesh.points * [1.0, 1e-3] @ turn.T
    across = points @ turn[:, 1] / 1e-3
    u = np.column_stack([across**3, across])
    slope, _ = recovered_gradient(points, mesh.cells, u)
    exact = np.zeros_like(slope)
    exact[:, 0] = 3 * across[:, None] ** 2 * turn[:, 1] / 1e-3
    exact[:, 1] = turn[:, 1] / 1e-3
    np.testing.assert_allclose(slope, exact, atol=1e3 * ROUNDING)


def test_nothing_is_fitted_across_a_wall() -> None:
    """Two layers in shear against one another, with a wall of no thickness between them."""
    low = rectangle(6)
    points = np.concatenate([low.points, low.points + np.array([0.0, 1.0])])
    cells = np.concatenate([low.cells, low.cells + len(low.points)])
    y = points[:, 1]
    upper = np.arange(len(points)) >= len(low.points)
    u = np.column_stack([np.where(upper, 5.0 * (y - 1.0), 1.0 - y), 0 * y])
    slope, doubt = recovered_gradient(points, cells, u)
    np.testing.assert_allclose(slope[:, 0, 1], np.where(upper, 5.0, -1.0), atol=ROUNDING)
    assert doubt.max() < ROUNDING


def test_too_few_nodes_for_a_cubic_are_in_doubt() -> None:
    points = np.array([[0.0, 0], [1, 0], [0, 1]])
    cells = np.array([[0, 1, 2]])
    slope, doubt = recovered_gradient(points, cells, points @ np.array([[0.0, 0], [2, 0]]))
    np.testing.assert_allclose(slope[:, 0, 1], 2.0, atol=ROUNDING)
    np.testing.assert_allclose(doubt, 2.0, atol=ROUNDING)


def test_the_estimate_is_seldom_below_the_error_and_falls_with_it() -> None:
    coarse, fine = (recovered(MILL, n) for n in (8, 16))
    for error, doubt, _ in (coarse, fine):
        assert np.mean(doubt >= error) > 0.99
    # of the quadratic, of second order: 4, and the meshes are not alike
    assert 3.0 < np.median(coarse[1]) / np.median(fine[1]) < 5.5


def test_scatter_of_velocities_is_in_the_estimate() -> None:
    mesh = rectangle(16)
    scatter = np.random.default_rng(0).normal(size=mesh.points.shape)
    exact = SLIT.velocity(embedded(mesh.points))[:, :2]
    slope, doubt = recovered_gradient(mesh.points, mesh.cells, exact + 1e-4 * scatter)
    error = np.linalg.norm(slope - SLIT.gradient(embedded(mesh.points))[:, :2, :2], axis=(1, 2))
    assert error.max() > 1e-3
    assert np.mean(doubt >= error) > 0.97
    # one deviation of a covariance that is bounded, not computed
    assert 1.0 < np.median(doubt / error) < 3.0


def test_quadratics_in_cells_reach_the_nodes_exactly() -> None:
    for mesh in (rectangle(5), box(3)):
        n, m = len(mesh.points), len(mesh.cells)
        k = mesh.cells.shape[1]
        member = csr_array(
            (np.ones(m * k, dtype=bool), (mesh.cells.ravel(), np.repeat(np.arange(m), k))), (n, m)
        )
        centres = mesh.points[mesh.cells].mean(axis=1)
        known, wanted = (
            np.column_stack([1 + x @ np.array([2.0, -1.0, 0.5])[: k - 1], x[:, 0] * x[:, 1]])
            for x in (centres, mesh.points)
        )
        found = cells_to_nodes(mesh.points, centres, member, known)
        # patches are kept from being flat by 1e-12 of their size, fits from rounding by 1e6 of it
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_few_cells_reach_the_nodes_linearly() -> None:
    """Too few for a quadratic: a plane through those there are."""
    mesh = rectangle(1)
    member = csr_array(
        (np.ones(12, dtype=bool), (mesh.cells.ravel(), np.repeat(np.arange(4), 3))), (6, 4)
    )
    centres = mesh.points[mesh.cells].mean(axis=1)
    found = cells_to_nodes(mesh.points, centres, member, 1 + centres @ [[2.0], [-1.0]])
    np.testing.assert_allclose(found, 1 + mesh.points @ [[2.0], [-1.0]], atol=1e-11)


@pytest.mark.parametrize("shape", [(5, 4, 1), (1, 1, 6)])
def test_values_of_one_layer_reach_the_nodes_linearly(shape: tuple[int, int, int]) -> None:
    """A layer and a row of bricks, turned: of what is across the cells say nothing."""
    node = np.arange(np.prod(np.add(shape, 1))).reshape(np.add(shape, 1))
    axes = [np.linspace(0.0, n, n + 1) for n in shape]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    steps = [slice(None, -1), slice(1, None)]
    corners = np.stack([node[i, j, k].ravel() for i in steps for j in steps for k in steps], axis=1)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    m = len(corners)
    member = csr_array(
        (np.ones(8 * m, dtype=bool), (corners.ravel(), np.repeat(np.arange(m), 8))),
        (len(points), m),
    )
    slope = np.where(np.array(shape) > 1, [2.0, -1.0, 0.5], 0.0)
    values = 1 + points @ slope
    centres = points[corners].mean(axis=1) @ turn
    found = cells_to_nodes(points @ turn, centres, member, values[corners].mean(axis=1)[:, None])
    # as above
    np.testing.assert_allclose(found[:, 0], values, atol=1e-9)


def test_one_cell_gives_its_value_to_all_its_nodes() -> None:
    member = csr_array(np.ones((3, 1), dtype=bool))
    points = np.array([[0.0, 0], [1, 0], [0, 1]])
    found = cells_to_nodes(points, points.mean(axis=0)[None], member, np.array([[7.0]]))
    np.testing.assert_allclose(found, 7.0)
