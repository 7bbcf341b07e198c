"""Steady Stokes flow with free surfaces of unknown shape: one Newton for flow and mesh together.

Unknowns: velocity (P_k), pressure (P_k-1), the mesh's displacement, and on the free surfaces a
multiplier that lets the surface go where ``u.n = 0`` wants it. The displacement has full order on
the free surfaces only and is linear inside the moving region, where it merely carries the mesh: it
then costs a few per cent of the unknowns instead of nearly half (ADR 2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fibermelt.errors import ConvergenceError, MeshError
from fibermelt.flow.forms import Elements, Unknowns, jacobian_form, residual_form, stokes_form
from fibermelt.flow.lagrange import LagrangeTriangle

__all__ = ["Boundaries", "FreeSurfaceFlow", "Step"]

Array = NDArray[np.float64]

SMALLEST_JACOBIAN = 0.15
"""A step may not shrink any element's area to less than this part of what it was when meshed."""

SMALLEST_FRACTION = 0.3
"""A step that would have to be cut to less is not taken: it points nowhere."""

LARGEST_RESIDUAL = 1e-8
"""Largest relative residual of a linear solve; above it the factorisation has lost the answer."""

PIN_DISTANCE = 1e-9
"""A mesh vertex this near to a lip is the lip (coordinates are of order one)."""


@dataclass(frozen=True)
class Boundaries:
    """Which part of the mesh does what; names of boundaries are regular expressions.

    Parameters
    ----------
    moving : str
        Region whose mesh follows the free surfaces.
    free : str
        The free surfaces: no traction, ``u.n = 0``, shape unknown.
    velocity : mapping of name to (u, v)
        Boundaries on which the velocity is given.
    symmetry : str
        Boundaries along x on which only ``v = 0`` is given.
    held_x, held_y : str
        Boundaries on which the mesh may not move in x, in y.
    lips : (n, 2) array
        Where free surfaces are pinned.
    """

    moving: str
    free: str
    velocity: Mapping[str, tuple[Any, Any]]
    held_x: str
    held_y: str
    lips: NDArray[np.float64]
    symmetry: str = ""


@dataclass(frozen=True)
class Step:
    """What one step met and did.

    Parameters
    ----------
    residual : float
        Norm of the residual it started from, in scaled units.
    worst_field : str
        What most of it is in: momentum, mass or kinematics.
    size : float
        Largest move of a mesh node that it wanted.
    fraction : float
        Part of it taken; 0 if it pointed nowhere.
    jacobian : float
        Smallest area ratio of an element after it.
    """

    residual: float
    worst_field: str
    size: float
    fraction: float
    jacobian: float


def _vertex_at(mesh: ng.Mesh, point: Array) -> int:
    """Return the number of the mesh vertex at ``point``."""
    distance = np.array([np.hypot(*np.subtract(v.point, point)) for v in mesh.vertices])
    nearest = int(np.argmin(distance))
    if distance[nearest] > PIN_DISTANCE:
        msg = (
            f"no mesh vertex at the lip {tuple(point)}, the nearest is {distance[nearest]:.1e} off"
        )
        raise MeshError(msg)
    return nearest


def _elements(mesh: ng.Mesh, boundaries: Boundaries) -> Elements:
    """Return which elements have an edge on a free surface, and which of the others move."""
    surface = mesh.Boundaries(boundaries.free).Elements()
    on_surface = {edge.nr for element in surface for edge in element.edges}
    curved, moving = ng.BitArray(mesh.ne), ng.BitArray(mesh.ne)
    curved.Clear()
    moving.Clear()
    for element in mesh.Materials(boundaries.moving).Elements():
        is_curved = any(edge.nr in on_surface for edge in element.edges)
        (curved if is_curved else moving).Set(element.nr)
    return Elements(curved, ~curved, moving)


class FreeSurfaceFlow:
    """The flow on one mesh, from the fixed-mesh Stokes solution on.

    Making one solves Stokes on the mesh as given (the coupled matrix is singular at rest); each
    `step` is one Newton step of the coupled problem, shortened if it would tangle the mesh.
    """

    def __init__(self, mesh: ng.Mesh, boundaries: Boundaries, order: int) -> None:
        """Set the problem up on ``mesh`` and solve Stokes on it as it is."""
        self.mesh = mesh
        self.boundaries = boundaries
        self.order = order
        given = "|".join(boundaries.velocity)
        fixed_y = "|".join(filter(None, (given, boundaries.symmetry)))
        held = {"dirichletx": boundaries.held_x, "dirichlety": boundaries.held_y}
        moving = mesh.Materials(boundaries.moving)
        self._spaces = (
            ng.VectorH1(mesh, order=order, dirichletx=given, dirichlety=fixed_y),
            ng.H1(mesh, order=order - 1),
            ng.VectorH1(mesh, order=order, definedon=moving, **held),
            ng.H1(mesh, order=order, definedon=mesh.Boundaries(boundaries.free)),
        )
        u, p, d, lam = self._spaces
        self._space = u * p * d * lam
        self._ranges = [self._space.Range(i) for i in range(4)]
        self._state = ng.GridFunction(self._space)
        self.displacement = ng.GridFunction(d)
        self._trial_displacement = ng.GridFunction(d)
        self._coupled, self._fixed_mesh = self._free_dofs()
        self._make_forms()
        values = {name: ng.CF(value) for name, value in boundaries.velocity.items()}
        self.velocity.Set(
            mesh.BoundaryCF(values, default=ng.CF((0, 0))), definedon=mesh.Boundaries(given)
        )
        correction, _ = self._solve(self._stokes, self._fixed_mesh)
        self._state.vec.data -= correction

    @property
    def velocity(self) -> ng.GridFunction:
        """Return the velocity, in scaled units."""
        return self._state.components[0]

    @property
    def pressure(self) -> ng.GridFunction:
        """Return the pressure, in scaled units."""
        return self._state.components[1]

    @property
    def unknowns(self) -> int:
        """Return the number of unknowns of the coupled system."""
        return int(self._coupled.NumSet())

    def _free_dofs(self) -> tuple[ng.BitArray, ng.BitArray]:
        """Return which unknowns take part in the coupled problem, and in Stokes alone."""
        mesh, (_, _, d, lam) = self.mesh, self._spaces
        in_mesh, in_surface = self._ranges[2].start, self._ranges[3].start
        used = ng.BitArray(self._space.ndof)
        used[:in_mesh] = True
        used[in_mesh:] = False
        nodes = set()
        for element in mesh.Materials(self.boundaries.moving).Elements():
            nodes.update(element.vertices)
        for element in mesh.Boundaries(self.boundaries.free).Elements():
            nodes.update(element.edges)
            for dof in lam.GetDofNrs(element):
                used.Set(in_surface + dof)
        for node in nodes:
            for dof in d.GetDofNrs(node):
                used.Set(in_mesh + dof)
        for lip in self.boundaries.lips:
            for dof in lam.GetDofNrs(ng.NodeId(ng.VERTEX, _vertex_at(mesh, lip))):
                used.Clear(in_surface + dof)
        coupled = used & self._space.FreeDofs()
        fixed_mesh = ng.BitArray(coupled)
        fixed_mesh[in_mesh:] = False
        return coupled, fixed_mesh

    def _make_forms(self) -> None:
        trial, test = self._space.TnT()
        unknowns = Unknowns(tuple(trial), tuple(test), self.velocity, self.pressure)
        elements = _elements(self.mesh, self.boundaries)
        self._stokes = ng.BilinearForm(self._space)
        for term in stokes_form(unknowns, elements):
            self._stokes += term
        self._jacobian = ng.BilinearForm(self._space)
        self._rate = ng.Parameter(0.0)
        for term in jacobian_form(unknowns, elements, self.boundaries.free, self._rate):
            self._jacobian += term
        self._residual = ng.LinearForm(self._space)
        for term in residual_form(unknowns, elements, self.boundaries.free):
            self._residual += term

    def _solve(
        self, form: ng.BilinearForm, free: ng.BitArray, reuse: bool = False
    ) -> tuple[ng.BaseVector, Array]:
        """Return the correction of the present state and its residual.

        With ``reuse`` by the matrix and factors of the last solve with ``form``.
        The fronts of a planar problem are too small for a threaded BLAS: its waiting threads cost
        up to five times the work on a busy machine. Assembly does run on all cores.
        """
        with threadpool_limits(limits=1, user_api="blas"), ng.TaskManager():
            self._residual.Assemble()
            if not reuse:
                form.Assemble()
                self._inverse = form.mat.Inverse(free, inverse="umfpack")
            correction = self._residual.vec.CreateVector()
            correction.data = self._inverse * self._residual.vec
            left = self._residual.vec.CreateVector()
            left.data = self._residual.vec - form.mat * correction
        mask = np.fromiter(free, dtype=bool, count=len(free))
        residual = np.where(mask, self._residual.vec.FV().NumPy(), 0.0)
        size = float(np.linalg.norm(residual))
        worst = float(np.linalg.norm(left.FV().NumPy()[mask]))
        if not worst <= LARGEST_RESIDUAL * max(size, LARGEST_RESIDUAL):
            msg = (
                f"the linear solve left a residual of {worst:.2e} against {size:.2e}: the matrix "
                "is singular to working precision; try a longer contact_edge or lip_edge"
            )
            raise ConvergenceError(msg)
        return correction, residual

    def _smallest_jacobian(self, displacement: ng.GridFunction) -> float:
        """Return the smallest area ratio of ``displacement``, on a lattice that has the edges."""
        lattice = LagrangeTriangle(2 * self.order).nodes
        rule = ng.IntegrationRule([tuple(map(float, r)) for r in lattice], [0.0] * len(lattice))
        points = self.mesh.MapToAllElements(rule, ng.VOL)
        return float(ng.Det(ng.Id(2) + ng.Grad(displacement))(points).min())

    def step(self, rate: float = 0.0, reuse: bool = False) -> Step:
        """Take one step of flow and mesh together, shortened so that no element tangles.

        Parameters
        ----------
        rate : float
            0 for Newton's step; above that one of implicit time of length ``1 / rate``.
        reuse : bool
            With the matrix and factors of the step before (a chord step): a tenth of the cost, and
            linear convergence at the rate by which the matrix has changed since.
        """
        self._rate.Set(rate)
        correction, residual = self._solve(self._jacobian, self._coupled, reuse)
        parts = {
            name: float(np.linalg.norm(residual[self._ranges[k].start : self._ranges[k].stop]))
            for name, k in (("momentum", 0), ("mass", 1), ("kinematics", 3))
        }
        met = (float(np.linalg.norm(residual)), max(parts, key=lambda name: parts[name]))
        moves = slice(self._ranges[2].start, self._ranges[2].stop)
        move = correction.FV().NumPy()[moves]
        size = float(np.abs(move).max())
        present = self.displacement.vec.FV().NumPy()
        trial = self._trial_displacement.vec.FV().NumPy()
        self.mesh.UnsetDeformation()
        fraction = 1.0
        while True:
            trial[:] = present - fraction * move
            jacobian = self._smallest_jacobian(self._trial_displacement)
            if jacobian > SMALLEST_JACOBIAN:
                break
            fraction *= 0.7
            if fraction < SMALLEST_FRACTION:
                fraction = 0.0
                break
        if fraction == 0.0:
            self.mesh.SetDeformation(self.displacement)
            return Step(*met, size, fraction, jacobian)
        present[:] = trial
        self._state.vec.data -= fraction * correction
        self.mesh.SetDeformation(self.displacement)
        return Step(*met, size, fraction, jacobian)

    def surface(self, name: str, start: Array, samples: int = 4) -> Array:
        """Return the boundary ``name`` as it lies now, a polyline (n, 2) that begins at ``start``.

        Every edge gives ``samples`` equal parts of its parameter, so that its curve is kept.
        """
        nodes = np.linspace(0.0, 1.0, samples + 1)
        rule = ng.IntegrationRule([(float(s),) for s in nodes], [0.0] * (samples + 1))
        at = self.mesh.MapToAllElements(rule, self.mesh.Boundaries(name))
        pieces = np.asarray(ng.CF((ng.x, ng.y))(at)).reshape(-1, samples + 1, 2)
        left = np.ones(len(pieces), dtype=bool)
        line, end = [], np.asarray(start, dtype=float)
        while left.any():
            gap = np.hypot(*np.moveaxis(pieces[:, [0, -1]] - end, -1, 0))
            gap[~left] = np.inf
            which, side = np.unravel_index(np.argmin(gap), gap.shape)
            piece = pieces[which] if side == 0 else pieces[which][::-1]
            line.append(piece[:-1])
            end = piece[-1]
            left[which] = False
        return np.vstack([*line, end[None]])

    def kinematic_residual(self) -> float:
        """Return the root mean square of ``u.n`` over the free surfaces, in scaled units."""
        free = ng.ds(self.boundaries.free, bonus_intorder=2)
        through = ng.Integrate((ng.specialcf.normal(2) * self.velocity) ** 2 * free, self.mesh)
        length = ng.Integrate(ng.CF(1) * free, self.mesh)
        return float(np.sqrt(through / length))
