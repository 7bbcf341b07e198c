"""The cell's matrix as the paper's algorithm partitions it (NGSolve to plain sparse arrays)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fibermelt.fiber.cell.mesh import CurvedMesh, sample_nodes
from fibermelt.fiber.cell.solve import cell_grid, cell_mesh, solve_cell
from fibermelt.fiber.cell.stokes import COMPRESSIBILITY, stokes
from fibermelt.fiber.cell_data import CellNumerics, CellSystem
from fibermelt.fiber.cell_surface import surface_values
from fibermelt.fiber.shape import Ellipse
from fibermelt.threads import exclusive

__all__ = ["build_system"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]


@exclusive
def build_system(
    fiber: Ellipse, domain_size: float, numerics: CellNumerics | None = None
) -> CellSystem:
    """Return the cell's matrix, its partition and a prefactored solver for the paper's algorithm.

    Grid and discretisation are those of `solve_cell`, but nothing is condensed. The tiny
    compressibility keeps the matrix regular; the level of Eq. 7 is taken off afterwards, as a
    prescribed node would have to swallow the rounding of the whole boundary's flux.

    Parameters
    ----------
    fiber, domain_size, numerics
        As in `solve_cell`; no error estimate is made.

    Raises
    ------
    ConfigError
        If the fiber does not fit into its cell.
    """
    numerics = replace(CellNumerics() if numerics is None else numerics, estimate=False)
    response = solve_cell(fiber, domain_size, numerics).response
    mesh = cell_mesh(cell_grid(fiber, domain_size, numerics), numerics.velocity_order)
    space, form = stokes(mesh, condense=False, compressibility=COMPRESSIBILITY)
    rows, columns, values = (np.array(part) for part in form.mat.COO())
    matrix = sparse.csr_matrix((values, (rows, columns)), shape=(space.ndof, space.ndof))
    edge, fixed = (_velocities(mesh, space, name) for name in ("edge", "fiber"))
    is_free = np.ones(space.ndof, dtype=bool)
    is_free[np.concatenate([edge, fixed])] = False
    free = np.flatnonzero(is_free)
    one, none = ng.CF(1.0), ng.CF(0.0)
    linear = [(one, none), (none, one), (ng.x, none), (ng.y, none), (none, ng.x), (none, ng.y)]
    rigid = [(one, none), (none, one), (-ng.y, ng.x)]
    level = _edge_mean if numerics.pressure_reference == "mean" else _far_node
    return CellSystem(
        matrix=matrix,
        free=free,
        edge=edge,
        fiber=fixed,
        edge_modes=_coefficients(mesh, space, "edge", linear)[edge],
        fiber_modes=_coefficients(mesh, space, "fiber", rigid)[fixed],
        surface_pressure=_surface_pressure(mesh, space),
        pressure_level=level(mesh, space),
        solve=_solver(space, form, free),
        response=response,
    )


def _solver(space: Any, form: Any, free: Index) -> Callable[[Array], Array]:
    """Return ``K_ff^-1``, factorised once.

    The sparse Cholesky factorisation: four to ten times faster per solve than SuperLU's or
    UMFPACK's here, so that the paper's algorithm is not slowed by its solver.
    """
    mask = ng.BitArray(space.ndof)
    mask.Clear()
    for unknown in free:
        mask.Set(int(unknown))
    inverse = form.mat.Inverse(mask, inverse="sparsecholesky")
    load, answer = form.mat.CreateColVector(), form.mat.CreateColVector()

    @exclusive
    def solve(values: Array) -> Array:
        load.FV().NumPy()[free] = values
        answer.data = inverse * load
        return np.array(answer.FV().NumPy()[free])

    return solve


def _velocities(mesh: CurvedMesh, space: Any, boundary: str) -> Index:
    """Return the velocity unknowns on a boundary."""
    on_boundary = space.components[0].GetDofs(mesh.mesh.Boundaries(boundary))
    return np.flatnonzero(np.array(on_boundary))


def _coefficients(
    mesh: CurvedMesh, space: Any, boundary: str, fields: Sequence[tuple[Any, Any]]
) -> Array:
    """Return the coefficients of velocity fields on a boundary, one column each."""
    function = ng.GridFunction(space)
    columns = []
    for field in fields:
        function.vec[:] = 0.0
        function.components[0].Set(ng.CF(field), definedon=mesh.mesh.Boundaries(boundary))
        columns.append(function.vec.FV().NumPy().copy())
    return np.stack(columns, axis=-1)


def _edge_mean(mesh: CurvedMesh, space: Any) -> Array:
    """Return the functional that takes the mean pressure over the cell's edge."""
    _, q = space.TestFunction()
    form = ng.LinearForm(space)
    edge = ng.ds("edge", bonus_intorder=2 * mesh.order)
    form += q * edge
    form.Assemble()
    length = ng.Integrate(ng.CF(1.0) * edge, mesh.mesh)
    return np.asarray(form.vec.FV().NumPy() / length)


def _far_node(mesh: CurvedMesh, space: Any) -> Array:
    """Return the functional that takes the pressure at ``(R, 0)``: the first column's last vertex.

    A vertex's unknown is the value there, and vertices come first.
    """
    functional = np.zeros(space.ndof)
    functional[space.Range(1).start + mesh.grid.rows] = 1.0
    return functional


def _surface_pressure(mesh: CurvedMesh, space: Any) -> Any:
    """Return the operator from the unknowns to the pressure at the response's surface points.

    The pressure of every single unknown on the fiber is sampled and treated like the modes in
    `surface_basis`: on the graded mesh its even part is projected on cosines, its odd part on
    sines; on the paper's mesh the vertices are read.
    """
    mapped, around, outward = sample_nodes(mesh)
    unknowns = np.flatnonzero(np.array(space.components[1].GetDofs(mesh.mesh.Boundaries("fiber"))))
    surface = outward == 0
    samples = np.empty((mesh.grid.columns * mesh.order, unknowns.size))
    single = ng.GridFunction(space.components[1])
    for k, unknown in enumerate(unknowns):
        single.vec[:] = 0.0
        single.vec[int(unknown)] = 1.0
        samples[around[surface], k] = np.asarray(single(mapped)).ravel()[surface]
    values = surface_values(mesh.grid, mesh.order, samples)
    m = values.shape[0]
    rows, columns = (part.ravel() for part in np.indices((m, unknowns.size)))
    where = (rows, unknowns[columns] + space.Range(1).start)
    return sparse.csr_matrix((values.ravel(), where), shape=(m, space.ndof))
