"""Steady Stokes flow with free surfaces of unknown shape: one Newton for flow and mesh together.

Unknowns: velocity (P_k), pressure (P_k-1), the mesh's displacement, and on the free surfaces a
multiplier that lets the surface go where ``u.n = 0`` wants it. The displacement has full order on
the free surfaces only and is linear inside the moving region, where it merely carries the mesh: it
then costs a few per cent of the unknowns instead of nearly half (ADR 2).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fibermelt.flow.equilibrium import Equilibrium
from fibermelt.flow.forms import (
    INTEGRATION_BONUS,
    Elements,
    MeltStress,
    Unknowns,
    ViscousStress,
    jacobian_form,
    residual_form,
)
from fibermelt.flow.linear import CondensedForm, solve_at_rest
from fibermelt.flow.spaces import Boundaries, elements_of, spaces_on
from fibermelt.flow.strain import COMPONENTS, HeldStrain
from fibermelt.melt import Newtonian, ViscosityLaw
from fibermelt.threads import exclusive

__all__ = ["Boundaries", "FreeSurfaceFlow", "Step"]

Array = NDArray[np.float64]

SMALLEST_JACOBIAN = 0.15
"""A step may not shrink any element's area to less than this part of what it was when meshed."""

SMALLEST_FRACTION = 0.3
"""A step that would have to be cut to less is not taken: it points nowhere."""

EDGE_MIDDLE = -0.125
"""In the middle of an edge the first of its own functions, ``(s^2 - 1)/8``."""

NEAREST, NEARLY = 6, 1e-9
"""A strain between meshes is the mean over this many corners of triangles, weighted by the
inverse of their distance [widths]."""


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


def _lattice(dim: int, parts: int) -> list[tuple[float, ...]]:
    """Return even points of the reference simplex, its corners and edges among them."""
    return [
        tuple(i / parts for i in node)
        for node in itertools.product(range(parts + 1), repeat=dim)
        if sum(node) <= parts
    ]


class FreeSurfaceFlow:
    """The flow on one mesh, from the flow on the mesh as given on.

    Making one solves the flow with the mesh held (the coupled matrix is singular at rest); each
    `step` is one Newton step of the coupled problem, shortened if it would tangle the mesh. A melt
    that thins follows the stress ahead of it (`HeldStrain`), and settles with the mesh held.
    """

    @exclusive
    def __init__(
        self,
        mesh: ng.Mesh,
        boundaries: Boundaries,
        order: int,
        law: ViscosityLaw | None = None,
        before: FreeSurfaceFlow | None = None,
        middles: Array | None = None,
    ) -> None:
        """Set the problem up on ``mesh`` and solve the flow on it as it is.

        In space edges begin where their ``middles`` (n_edges, 3) say, as seen from their chord's.

        Without a ``law`` [scaled units] the melt is Newtonian. The strain of a flow ``before``, on
        another mesh of nearly the same shape, is where that of a melt that thins starts.
        """
        self.mesh = mesh
        self.boundaries = boundaries
        self.order = order
        spaces = spaces_on(mesh, boundaries, order)
        self._space, self._moves = spaces.coupled, spaces.moves
        self._ranges = [self._space.Range(i) for i in range(4)]
        self._state = ng.GridFunction(self._space)
        self.displacement = ng.GridFunction(spaces.displacement)
        self._trial_displacement = ng.GridFunction(spaces.displacement)
        self._law = Newtonian(1.0) if law is None else law
        if middles is not None:
            self._bend(middles)
        elements = elements_of(mesh, boundaries)
        self._make_forms(elements)
        self._set_given_velocity()
        at_rest = self._state.vec[: spaces.flow.ndof]
        self._equilibrium: Equilibrium | None = None
        if self._law.is_newtonian:
            solve_at_rest(spaces.flow, elements, at_rest, self._residual, boundaries)
            return
        self._equilibrium = Equilibrium(
            spaces.flow, self._stress, at_rest, self._residual, boundaries
        )
        if before is not None:
            for held in self._stress.held:
                held.hold(before.strain_near(held.places))
        self._equilibrium.settle()

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
        return int(self._matrix.free.sum())

    def _bend(self, middles: Array) -> None:
        """Move the middles of edges; the quadratic of an edge is the first of its own unknowns."""
        space, values = self.displacement.space, self.displacement.vec.FV().NumPy()
        bent = np.flatnonzero(np.any(middles != 0.0, axis=1))
        dofs = np.array([space.GetDofNrs(ng.NodeId(ng.EDGE, int(edge))) for edge in bent])
        first = dofs.reshape(len(bent), 3, -1)[:, :, 0]
        values[first] = middles[bent] / EDGE_MIDDLE
        self.mesh.SetDeformation(self.displacement)

    def _set_given_velocity(self) -> None:
        """Set what is given on the boundaries; what flows in is then scaled to its exact flux."""
        values = {name: ng.CF(value) for name, value in self.boundaries.velocity.items()}
        given = self.mesh.Boundaries(self.boundaries.given)
        rest = ng.CF((0,) * self.mesh.dim)
        self.velocity.Set(self.mesh.BoundaryCF(values, default=rest), definedon=given)
        for name, flux in self.boundaries.inflow.items():
            through = -self.velocity * ng.specialcf.normal(self.mesh.dim) * ng.ds(name)
            values[name] = values[name] * (flux / ng.Integrate(through, self.mesh))
            self.velocity.Set(self.mesh.BoundaryCF(values, default=rest), definedon=given)

    def _make_forms(self, elements: Elements) -> None:
        trial, test = self._space.TnT()
        unknowns = Unknowns(tuple(trial), tuple(test), self.velocity, self.pressure)
        free, film = self.boundaries.free, self.boundaries.film
        self._rate = ng.Parameter(0.0)
        self._stress = self._melt_stress(elements)
        self._jacobian = jacobian_form(unknowns, self._stress, free, self._rate, film)
        self._matrix = CondensedForm(self._space, self._jacobian, "umfpack", symmetric=False)
        self._residual = ng.LinearForm(self._space)
        for term in residual_form(unknowns, self._stress, free, film):
            self._residual += term.Compile()

    def _melt_stress(self, elements: Elements) -> MeltStress:
        """Return the stress; of a melt that thins at the points that the residual is taken at."""
        gradient = ng.Grad(self.velocity)
        if self._law.is_newtonian:
            same = ViscousStress(gradient)
            return MeltStress(elements, same, same)
        parts = ((elements.curved, INTEGRATION_BONUS), (elements.straight, 0))
        curved, straight = (
            ViscousStress(
                gradient, HeldStrain(self.mesh, self._law, gradient, some, 2 * self.order + bonus)
            )
            for some, bonus in parts
        )
        return MeltStress(elements, curved, straight)

    def _solve(self, reuse: bool) -> tuple[ng.BaseVector, Array]:
        """Return the correction of the present state and its residual.

        With ``reuse`` by the matrix and factors of the last solve.
        """
        with ng.TaskManager():
            self._residual.Assemble()
        right = self._residual.vec.CreateVector()
        residual = np.where(self._matrix.free, self._residual.vec.FV().NumPy(), 0.0)
        right.FV().NumPy()[:] = residual
        if not reuse:
            self._matrix.factorise()
        return self._matrix.checked(right), residual

    def _smallest_jacobian(self, displacement: ng.GridFunction) -> float:
        """Return the smallest ratio of volume of ``displacement``, on a lattice with the edges."""
        lattice = _lattice(self.mesh.dim, 2 * self.order)
        rule = ng.IntegrationRule(lattice, [0.0] * len(lattice))
        points = self.mesh.MapToAllElements(rule, ng.VOL)
        return float(ng.Det(ng.Id(self.mesh.dim) + ng.Grad(displacement))(points).min())

    @exclusive
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
        correction, residual = self._solve(reuse)
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
            trial[self._moves] = present[self._moves] - fraction * move
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
        self._stress.follow()
        if self._equilibrium is not None:
            self._equilibrium.settle()
        return Step(*met, size, fraction, jacobian)

    def release(self) -> None:
        """Let the factors of the last step go: where the flow is solved nobody needs them."""
        self._matrix.release()

    @exclusive
    def strain_near(self, points: Array) -> Array:
        """Return the strain's `COMPONENTS` (n_components, n) at ``points``, from the corners'."""
        dim = self.mesh.dim
        corners = [*map(tuple, np.eye(dim).tolist()), (0.0,) * dim]
        rule = ng.IntegrationRule(corners, [0.0] * len(corners))
        at = self.mesh.MapToAllElements(rule, ng.VOL)
        D = ng.Sym(ng.Grad(self.velocity))
        place = (ng.x, ng.y, ng.z)[:dim]
        sampled = np.asarray(ng.CF((*place, *(D[i, j] for i, j in COMPONENTS[dim])))(at))
        distance, nearest = cKDTree(sampled[:, :dim]).query(points, k=NEAREST)
        weight = 1.0 / (distance + NEARLY)
        mean = np.einsum("nk,nkc->cn", weight, sampled[nearest, dim:])
        return np.asarray(mean / weight.sum(axis=1))

    @exclusive
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

    @exclusive
    def places(self, name: str, parts: int = 6) -> Array:
        """Return points (n, dim) of a boundary as it lies now, a lattice on each of its faces."""
        nodes = _lattice(self.mesh.dim - 1, parts)
        rule = ng.IntegrationRule(nodes, [0.0] * len(nodes))
        at = self.mesh.MapToAllElements(rule, self.mesh.Boundaries(name))
        return np.asarray(ng.CF((ng.x, ng.y, ng.z)[: self.mesh.dim])(at))

    @exclusive
    def area(self, name: str) -> float:
        """Return the area (in the plane the length) of a boundary as it lies now."""
        return float(ng.Integrate(ng.CF(1) * ng.ds(name, bonus_intorder=2), self.mesh))

    @exclusive
    def kinematic_residual(self) -> float:
        """Return the root mean square of ``u.n`` over the free surfaces, in scaled units."""
        free = ng.ds(self.boundaries.free, bonus_intorder=2)
        normal = ng.specialcf.normal(self.mesh.dim)
        through = ng.Integrate((normal * self.velocity) ** 2 * free, self.mesh)
        length = ng.Integrate(ng.CF(1) * free, self.mesh)
        return float(np.sqrt(through / length))
