"""Curved elements between the fiber and the cell's edge (NGSolve)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import netgen.meshing as ngm
import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.cell_grid import CellGrid

__all__ = ["EXTRA_QUADRATURE", "CurvedMesh", "curved_mesh", "sample_nodes"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

EXTRA_QUADRATURE = 4
"""Additional integration order for the curved elements' rational integrands."""


@dataclass(frozen=True, eq=False)
class CurvedMesh:
    """A curved mesh with its chart, as functions on it.

    Parameters
    ----------
    mesh
        The finite elements' mesh, boundaries "fiber" and "edge".
    grid : CellGrid
        Where the elements lie.
    order : int
        Polynomial order of the geometry.
    quarters, depth
        Coordinates around the fiber (quarter turns) and outward (0 to 1).
    """

    mesh: Any
    grid: CellGrid
    order: int
    quarters: Any
    depth: Any


def curved_mesh(grid: CellGrid, order: int) -> CurvedMesh:
    """Return the grid's elements, curved at the given order.

    The chart is built from vertex values, so it does not care how elements are oriented: the row is
    linear between vertices, and so is the parity of the column (their number is even), which gives
    the way across an element without the jump where the last column meets the first.
    """
    mesh, column, vertex_column, vertex_row = _flat_mesh(grid)
    piecewise, linear = ng.L2(mesh, order=0), ng.H1(mesh, order=1)

    def function(space: Any, values: Array | Index) -> Any:
        result = ng.GridFunction(space)
        result.vec.FV().NumPy()[:] = values
        return result

    odd = function(piecewise, column % 2)
    parity = function(linear, vertex_column % 2)
    across = odd + (1.0 - 2.0 * odd) * parity
    tip = function(piecewise, grid.nearest_tip(column))
    quarters = (function(piecewise, column) + across) / grid.columns_per_quarter
    depth = function(linear, vertex_row) / grid.rows
    x, y = grid.position(tip, quarters, depth, functions=ng)
    shift = ng.GridFunction(ng.VectorH1(mesh, order=order))
    target = ng.CF((x - ng.x, y - ng.y)).Compile()  # shares what both components repeat
    shift.Set(target, bonus_intorder=EXTRA_QUADRATURE)
    mesh.SetDeformation(shift)
    return CurvedMesh(mesh, grid, order, quarters, depth)


def _flat_mesh(grid: CellGrid) -> tuple[Any, Index, Array, Array]:
    """Return a ring of straight elements, each element's column, each vertex's column and row."""
    columns, rows = grid.columns, grid.rows
    mesh = ngm.Mesh(dim=2)
    at = {}
    for i in range(columns):
        direction = np.exp(2j * np.pi * i / columns)
        for j in range(rows + 1):
            z = direction * (1.0 + j / rows)
            at[i, j] = mesh.Add(ngm.MeshPoint(ngm.Pnt(z.real, z.imag, 0.0)))
    mesh.Add(ngm.FaceDescriptor(surfnr=1, domin=1, bc=1))
    mesh.SetMaterial(1, "melt")
    for i in range(columns):
        k = (i + 1) % columns
        for j in range(rows):
            mesh.Add(ngm.Element2D(1, [at[i, j], at[i, j + 1], at[k, j + 1], at[k, j]]))
        mesh.Add(ngm.Element1D([at[k, 0], at[i, 0]], index=1))
        mesh.Add(ngm.Element1D([at[i, rows], at[k, rows]], index=2))
    mesh.SetBCName(0, "fiber")
    mesh.SetBCName(1, "edge")
    columns_of_elements = np.repeat(np.arange(columns), rows)
    columns_of_vertices = np.repeat(np.arange(columns), rows + 1).astype(float)
    rows_of_vertices = np.tile(np.arange(rows + 1), columns).astype(float)
    return ng.Mesh(mesh), columns_of_elements, columns_of_vertices, rows_of_vertices


def sample_nodes(mesh: CurvedMesh) -> tuple[Any, Index, Index]:
    """Return mapped sample points of all elements and their indices around and outward."""
    order, grid = mesh.order, mesh.grid
    steps = np.arange(order + 1) / order
    reference = [(u, v) for u in steps for v in steps]
    rule = ng.IntegrationRule(points=reference, weights=[0.0] * len(reference))
    mapped = mesh.mesh.MapToAllElements(rule, ng.VOL)
    quarters = np.asarray(mesh.quarters(mapped)).ravel()
    around = np.rint(quarters * (grid.columns_per_quarter * order)).astype(np.intp)
    outward = np.rint(np.asarray(mesh.depth(mapped)).ravel() * (grid.rows * order))
    return mapped, around % (grid.columns * order), outward.astype(np.intp)
