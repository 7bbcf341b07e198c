"""Curved elements between the fiber and the cell's edge (NGSolve)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import netgen.meshing as ngm
import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.cell_paper import PaperGrid

__all__ = [
    "EXTRA_QUADRATURE",
    "CurvedMesh",
    "column_chart",
    "curved_mesh",
    "ring_of_points",
    "sample_nodes",
    "vertex_indices",
]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

EXTRA_QUADRATURE = 4
"""Additional integration order for the curved elements' rational integrands."""

ROUNDING = 1e-12
"""What a sum of two nodes' coordinates may be off one."""


@dataclass(frozen=True, eq=False)
class CurvedMesh:
    """A curved mesh with its chart, as functions on it.

    Parameters
    ----------
    mesh
        The finite elements' mesh, boundaries "fiber" and "edge".
    grid : CellGrid or PaperGrid
        Where the elements lie: quadrilaterals, or the paper's triangles.
    order : int
        Polynomial order of the geometry.
    quarters, depth
        Coordinates around the fiber (quarter turns) and outward (0 to 1).
    """

    mesh: Any
    grid: CellGrid | PaperGrid
    order: int
    quarters: Any
    depth: Any


def curved_mesh(grid: CellGrid, order: int) -> CurvedMesh:
    """Return the graded grid's elements, curved at the given order."""
    mesh, column = _flat_mesh(grid)
    quarters, depth, piecewise = column_chart(mesh, grid, column)
    tip = _function(piecewise, grid.nearest_tip(column))
    x, y = grid.position(tip, quarters, depth, functions=ng)
    shift = ng.GridFunction(ng.VectorH1(mesh, order=order))
    target = ng.CF((x - ng.x, y - ng.y)).Compile()  # shares what both components repeat
    shift.Set(target, bonus_intorder=EXTRA_QUADRATURE)
    mesh.SetDeformation(shift)
    return CurvedMesh(mesh, grid, order, quarters, depth)


def column_chart(mesh: Any, grid: CellGrid | PaperGrid, column: Index) -> tuple[Any, Any, Any]:
    """Return the coordinates around (quarter turns) and outward, and the space of element values.

    The chart is built from vertex values, so it does not care how elements are oriented: the row is
    linear between vertices, and so is the parity of the column (their number is even), which gives
    the way across an element without the jump where the last column meets the first.
    """
    piecewise, linear = ng.L2(mesh, order=0), ng.H1(mesh, order=1)
    vertex_column, vertex_row = vertex_indices(grid)
    odd = _function(piecewise, column % 2)
    parity = _function(linear, vertex_column % 2)
    across = odd + (1.0 - 2.0 * odd) * parity
    quarters = (_function(piecewise, column) + across) / grid.columns_per_quarter
    return quarters, _function(linear, vertex_row) / grid.rows, piecewise


def _function(space: Any, values: Array | Index) -> Any:
    result = ng.GridFunction(space)
    result.vec.FV().NumPy()[:] = values
    return result


def _flat_mesh(grid: CellGrid) -> tuple[Any, Index]:
    """Return a ring of straight elements, and each element's column."""
    mesh = ngm.Mesh(dim=2)
    at = ring_of_points(mesh, grid)
    for i in range(grid.columns):
        k = (i + 1) % grid.columns
        for j in range(grid.rows):
            mesh.Add(ngm.Element2D(1, [at[i, j], at[i, j + 1], at[k, j + 1], at[k, j]]))
    return ng.Mesh(mesh), np.repeat(np.arange(grid.columns), grid.rows)


def ring_of_points(mesh: Any, grid: CellGrid | PaperGrid) -> dict[tuple[int, int], Any]:
    """Add a ring's points and boundaries to a mesh; return the points by column and row."""
    columns, rows = grid.columns, grid.rows
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
        mesh.Add(ngm.Element1D([at[k, 0], at[i, 0]], index=1))
        mesh.Add(ngm.Element1D([at[i, rows], at[k, rows]], index=2))
    mesh.SetBCName(0, "fiber")
    mesh.SetBCName(1, "edge")
    return at


def vertex_indices(grid: CellGrid | PaperGrid) -> tuple[Index, Index]:
    """Return the column and the row of every vertex, as `ring_of_points` counts them."""
    column, row = np.indices((grid.columns, grid.rows + 1))
    return column.ravel(), row.ravel()


def sample_nodes(mesh: CurvedMesh) -> tuple[Any, Index, Index]:
    """Return mapped sample points of all elements and their indices around and outward."""
    order, grid = mesh.order, mesh.grid
    steps = np.arange(order + 1) / order
    is_triangle = isinstance(grid, PaperGrid)
    reference = [(u, v) for u in steps for v in steps if not is_triangle or u + v < 1.0 + ROUNDING]
    rule = ng.IntegrationRule(points=reference, weights=[0.0] * len(reference))
    mapped = mesh.mesh.MapToAllElements(rule, ng.VOL)
    quarters = np.asarray(mesh.quarters(mapped)).ravel()
    around = np.rint(quarters * (grid.columns_per_quarter * order)).astype(np.intp)
    outward = np.rint(np.asarray(mesh.depth(mapped)).ravel() * (grid.rows * order))
    return mapped, around % (grid.columns * order), outward.astype(np.intp)
