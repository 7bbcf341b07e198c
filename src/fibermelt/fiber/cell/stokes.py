"""Stokes flow in the cell by superposition: three Dirichlet problems, one factorisation (NGSolve).

By linearity three problems hold everything: the strains ``D_11`` and ``D_12`` past a fiber held
fast, and the fiber turning at unit rate in a cell at rest. The torque is the virtual work of the
consistent nodal reactions (Eq. 14, 18) on a unit rotation, which converges twice as fast as the
traction's integral does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fibermelt.errors import ConvergenceError
from fibermelt.fiber.cell.mesh import EXTRA_QUADRATURE, CurvedMesh, sample_nodes
from fibermelt.fiber.cell_data import CellNumerics

__all__ = ["Fields", "Modes", "sample_fields", "solve_modes", "stokes"]

Array = NDArray[np.float64]

COMPRESSIBILITY = 1e-12
"""Pressure mass term over the viscosity: fixes the level, and lets the sparse Cholesky
factorisation run without pivots. Its flux error is 1e-12 of the pressure."""

RESIDUAL_TOLERANCE = 1e-8
"""Largest algebraic residual over the load: two digits below the shape factor's 1e-6."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Discrete solutions of the two modes with what was measured on the way.

    ``handedness`` is the spin at unit ``D_11``: zero on a mesh that is its own mirror image.
    """

    shape_factor: float
    handedness: float
    functions: tuple[Any, Any]
    unknowns: int
    residual: float


def stokes(mesh: CurvedMesh, condense: bool, compressibility: float) -> tuple[Any, Any]:
    """Return space and assembled form of ``2 D(u):D(v) - p div v - q div u - eps p q``."""
    velocity = ng.VectorH1(mesh.mesh, order=mesh.order, dirichlet="fiber|edge")
    space = velocity * ng.H1(mesh.mesh, order=mesh.order - 1)
    (u, p), (v, q) = space.TnT()
    strain = ng.InnerProduct(ng.Sym(ng.Grad(u)), ng.Sym(ng.Grad(v)))
    form = ng.BilinearForm(space, symmetric=condense, condense=condense)
    form += (2.0 * strain - p * ng.div(v) - q * ng.div(u) - compressibility * p * q) * ng.dx(
        bonus_intorder=EXTRA_QUADRATURE
    )
    form.Assemble()
    return space, form


# waiting BLAS threads cost up to five times the work on a busy machine
@threadpool_limits.wrap(limits=1, user_api="blas")  # type: ignore[untyped-decorator]  # has no types
def solve_modes(mesh: CurvedMesh) -> Modes:
    """Solve the three Dirichlet problems and combine them to the torque-free modes."""
    space, form = stokes(mesh, condense=True, compressibility=COMPRESSIBILITY)
    inverse = form.mat.Inverse(space.FreeDofs(coupling=True), inverse="sparsecholesky")
    free = ng.Projector(space.FreeDofs(coupling=True), True)
    solutions, reactions, residual = [], [], 0.0
    turn = ng.CF((-ng.y, ng.x))
    loads = (("edge", ng.CF((ng.x, -ng.y))), ("edge", ng.CF((ng.y, ng.x))), ("fiber", turn))
    for where, value in loads:
        solution = ng.GridFunction(space)
        solution.components[0].Set(value, definedon=mesh.mesh.Boundaries(where))
        reaction = (form.mat * solution.vec).Evaluate()
        load = ng.Norm((free * reaction).Evaluate())
        for _ in range(2):  # the second solve refines what no pivoting may have lost
            solution.vec.data -= inverse * reaction
            reaction = (form.mat * solution.vec).Evaluate()
        residual = max(residual, ng.Norm((free * reaction).Evaluate()) / load)
        solution.vec.data += form.harmonic_extension * solution.vec
        solutions.append(solution)
        reactions.append(reaction)
    if not residual <= RESIDUAL_TOLERANCE:
        msg = (
            f"fiber cell: relative residual {residual:.1e} after the linear solve, bound "
            f"{RESIDUAL_TOLERANCE:g}: use a lower order, or a domain_size further from 2"
        )
        raise ConvergenceError(msg)
    rotation = ng.GridFunction(space)
    rotation.components[0].Set(turn, definedon=mesh.mesh.Boundaries("fiber"))
    torque = [ng.InnerProduct(reaction, rotation.vec) for reaction in reactions]
    spins = [float(-moment / torque[2]) for moment in torque[:2]]
    for solution, spin in zip(solutions[:2], spins, strict=True):
        solution.vec.data += spin * solutions[2].vec
    unknowns = sum(space.FreeDofs())
    return Modes(spins[1], spins[0], (solutions[0], solutions[1]), int(unknowns), float(residual))


@dataclass(frozen=True, eq=False)
class Fields:
    """Samples at ``order`` equal intervals per element: axes around, outward, ..."""

    points: Array
    velocity: Array
    pressure: Array


def sample_fields(mesh: CurvedMesh, modes: Modes, numerics: CellNumerics) -> Fields:
    """Read the modes on the structured nodes and set the level of their pressure."""
    order, grid = mesh.order, mesh.grid
    mapped, around, outward = sample_nodes(mesh)

    def read(function: Any) -> Array:
        values = np.asarray(function(mapped)).reshape(around.size, -1)
        result = np.empty((grid.columns * order, grid.rows * order + 1, values.shape[1]))
        result[around, outward] = values
        return result

    points = read(ng.CF((ng.x, ng.y)))
    velocity = [read(mode.components[0]) for mode in modes.functions]
    pressure = [read(mode.components[1])[..., 0] for mode in modes.functions]
    levels = [0.0, 0.0]
    for k, mode in enumerate(modes.functions):
        if numerics.pressure_reference == "far-node":
            levels[k] = float(pressure[k][0, -1])
        else:
            levels[k] = _edge_mean(mesh, mode.components[1])
    return Fields(points, np.stack(velocity, -2), np.stack(pressure, -1) - np.array(levels))


def _edge_mean(mesh: CurvedMesh, pressure: Any) -> float:
    """Return the mean of a pressure over the cell's edge."""
    edge = ng.ds("edge", bonus_intorder=2 * mesh.order)
    length = ng.Integrate(ng.CF(1.0) * edge, mesh.mesh)
    return float(ng.Integrate(pressure * edge, mesh.mesh) / length)
