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


def curved_mesh(grid: CellGrid, order: int, half: bool = False) -> CurvedMesh:
    """Return the graded grid's elements, curved at the given order.

    By ``half`` only those on one side of the fiber's axis, with the two rays that bound them, ahead
    of the tips, identified: what happens at ``x`` happens at ``-x``, turned around.
    """
    mesh, column = _flat_mesh(grid, half)
    quarters, depth, piecewise = column_chart(mesh, grid, column, half)
    tip = _function(piecewise, grid.nearest_tip(column))
    x, y = grid.position(tip, quarters, depth, functions=ng)
    shift = ng.GridFunction(ng.VectorH1(mesh, order=order))
    target = ng.CF((x - ng.x, y - ng.y)).Compile()  # shares what both components repeat
    shift.Set(target, bonus_intorder=EXTRA_QUADRATURE)
    mesh.SetDeformation(shift)
    return CurvedMesh(mesh, grid, order, quarters, depth)


def column_chart(
    mesh: Any, grid: CellGrid | PaperGrid, column: Index, half: bool = False
) -> tuple[Any, Any, Any]:
    """Return the coordinates around (quarter turns) and outward, and the space of element values.

    The chart is built from vertex values, so it does not care how elements are oriented: the row is
    linear between vertices, and so is the parity of the column (their number is even), which gives
    the way across an element without the jump where the last column meets the first.
    """
    piecewise, linear = ng.L2(mesh, order=0), ng.H1(mesh, order=1)
    vertex_column, vertex_row = vertex_indices(grid, half)
    odd = _function(piecewise, column % 2)
    parity = _function(linear, vertex_column % 2)
    across = odd + (1.0 - 2.0 * odd) * parity
    quarters = (_function(piecewise, column) + across) / grid.columns_per_quarter
    return quarters, _function(linear, vertex_row) / grid.rows, piecewise


def _function(space: Any, values: Array | Index) -> Any:
    result = ng.GridFunction(space)
    result.vec.FV().NumPy()[:] = values
    return result


def _flat_mesh(grid: CellGrid, half: bool) -> tuple[Any, Index]:
    """Return a ring of straight elements, or half of it, and each element's column."""
    mesh = ngm.Mesh(dim=2)
    at = ring_of_points(mesh, grid, half)
    columns = grid.columns // 2 if half else grid.columns
    for i in range(columns):
        for j in range(grid.rows):
            corners = [at[i, j], at[i, j + 1], at[i + 1, j + 1], at[i + 1, j]]
            mesh.Add(ngm.Element2D(1, corners))
    return ng.Mesh(mesh), np.repeat(np.arange(columns), grid.rows)


def ring_of_points(
    mesh: Any, grid: CellGrid | PaperGrid, half: bool = False
) -> dict[tuple[int, int], Any]:
    """Add a ring's points and boundaries to a mesh; return the points by column and row.

    The last column's are those of the first; of half a ring, they are identified with them.
    """
    columns, rows = grid.columns // 2 if half else grid.columns, grid.rows
    at = {}
    for i in range(columns + half):
        direction = np.exp(2j * np.pi * i / grid.columns)
        for j in range(rows + 1):
            z = direction * (1.0 + j / rows)
            at[i, j] = mesh.Add(ngm.MeshPoint(ngm.Pnt(z.real, z.imag, 0.0)))
    mesh.Add(ngm.FaceDescriptor(surfnr=1, domin=1, bc=1))
    mesh.SetMaterial(1, "melt")
    names = ["fiber", "edge"]
    if half:
        names += ["ahead", "behind"]
        for j in range(rows + 1):
            mesh.AddPointIdentification(at[0, j], at[columns, j], 1, 2)
        for j in range(rows):
            mesh.Add(ngm.Element1D([at[0, j], at[0, j + 1]], index=3))
            mesh.Add(ngm.Element1D([at[columns, j + 1], at[columns, j]], index=4))
    else:
        at |= {(columns, j): at[0, j] for j in range(rows + 1)}
    for i in range(columns):
        mesh.Add(ngm.Element1D([at[i + 1, 0], at[i, 0]], index=1))
        mesh.Add(ngm.Element1D([at[i, rows], at[i + 1, rows]], index=2))
    for k, name in enumerate(names):
        mesh.SetBCName(k, name)
    return at


def vertex_indices(grid: CellGrid | PaperGrid, half: bool = False) -> tuple[Index, Index]:
    """Return the column and the row of every vertex, as `ring_of_points` counts them."""
    columns = grid.columns // 2 + 1 if half else grid.columns
    column, row = np.indices((columns, grid.rows + 1))
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
