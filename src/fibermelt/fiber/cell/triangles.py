"""The paper's mesh as finite elements: six-node isoparametric triangles (NGSolve)."""

from __future__ import annotations

from typing import Any

import netgen.meshing as ngm
import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.cell.mesh import CurvedMesh, column_chart, ring_of_points, vertex_indices
from fibermelt.fiber.cell_paper import PAPER_ORDER, PaperGrid

__all__ = ["paper_mesh"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]


def paper_mesh(grid: PaperGrid) -> CurvedMesh:
    """Return the paper's triangles with all six nodes of each where the grid has them."""
    mesh, column = _flat_triangles(grid)
    shift = ng.GridFunction(ng.VectorH1(mesh, order=PAPER_ORDER))
    _interpolate(mesh, grid, shift)
    mesh.SetDeformation(shift)
    quarters, depth, _ = column_chart(mesh, grid, column)
    return CurvedMesh(mesh, grid, PAPER_ORDER, quarters, depth)


def _flat_triangles(grid: PaperGrid) -> tuple[Any, Index]:
    """Return a ring of straight triangles, and each one's column."""
    mesh = ngm.Mesh(dim=2)
    at = ring_of_points(mesh, grid)
    for i in range(grid.columns):
        k = (i + 1) % grid.columns
        for j in range(grid.rows):
            inner, outer, ahead, beside = at[i, j], at[i, j + 1], at[k, j + 1], at[k, j]
            mesh.Add(ngm.Element2D(1, [inner, outer, ahead]))
            mesh.Add(ngm.Element2D(1, [inner, ahead, beside]))
    return ng.Mesh(mesh), np.repeat(np.arange(grid.columns), 2 * grid.rows)


def _interpolate(mesh: Any, grid: PaperGrid, shift: Any) -> None:
    """Set the displacement that carries vertices and edge midpoints to the grid's nodes.

    The space's unknowns are the vertices' values and, for each edge, the multiple of a bubble by
    which its midpoint is off their mean.
    """
    column, row = vertex_indices(grid)
    flat = np.array([vertex.point for vertex in mesh.vertices])
    edges = np.array([[vertex.nr for vertex in edge.vertices] for edge in mesh.edges])
    nodes = grid.nodes()
    at_vertex = nodes[PAPER_ORDER * column, PAPER_ORDER * row] - flat
    step = (column[edges[:, 1]] - column[edges[:, 0]] + 1) % grid.columns - 1  # -1, 0 or 1
    around = (PAPER_ORDER * column[edges[:, 0]] + step) % nodes.shape[0]
    at_middle = nodes[around, row[edges].sum(axis=1)] - flat[edges].mean(axis=1)
    bubble = (at_middle - at_vertex[edges].mean(axis=1)) / _bubble_height(mesh)
    for k, component in enumerate(shift.components):
        component.vec.FV().NumPy()[:] = np.concatenate([at_vertex[:, k], bubble[:, k]])


def _bubble_height(mesh: Any) -> float:
    """Return the value of an edge's shape function at the edge's midpoint, as it is scaled here."""
    bubble = ng.GridFunction(ng.H1(mesh, order=PAPER_ORDER))
    bubble.vec[:] = 0.0
    bubble.vec[mesh.nv] = 1.0
    middles = ng.IntegrationRule(points=[(0.5, 0.0), (0.0, 0.5), (0.5, 0.5)], weights=[0.0] * 3)
    values = np.asarray(bubble(mesh.MapToAllElements(middles, ng.VOL))).ravel()
    return float(values[np.argmax(np.abs(values))])
