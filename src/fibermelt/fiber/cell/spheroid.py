"""A rigid spheroid in the plane of a planar flow of a thinning melt, in 3D (NGSolve).

Inertialess flow ``div(2 eta(gamma_dot) D) = grad p``, ``gamma_dot^2 = 2 D:D``, far field ``D x`` with
``D = d [[cos phi, sin phi], [sin phi, -cos phi]]`` in the plane of the fiber's axis, nothing across.
Half-length ``a = 1``, ``gamma_dot = 2 d = 1``. The fiber turns at ``omega`` about z; no torque acts on it.

Coordinates are confocal: ``(x, y, z) = (A e_x, B e_y, B e_z)``, ``e`` on the unit sphere,
``A + B = exp(s)``, ``A - B = c^2 exp(-s)``, ``c^2 = 1 - 1/r_e^2``, the sphere included. The half ``z >= 0``
is solved. Velocity of order k, continuous pressure of order k - 1 on hexahedra, prisms at the poles.

Newton's step keeps the system symmetric and bordered by one unknown. With ``K`` the tangent, ``F`` the
residual and ``w`` the flow of a fiber that turns at unit rate in the tangent's melt (``K w = 0`` inside),
the virtual work of the torque gives ``d omega = -<F, w>/<w, K w>``, so one factorisation serves both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import netgen.meshing as ngm
import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from threadpoolctl import threadpool_limits

from fibermelt.errors import ConvergenceError

__all__ = ["SpheroidCell", "SpheroidGrid", "SpheroidSolution"]

Array = NDArray[np.float64]
Viscosity = Callable[[Any], Any]
"""Viscosity [K gamma_dot^(n-1)] of the squared rate, ``1`` in the far field, as an NGSolve expression."""

COMPRESSIBILITY = 1e-10
"""Pressure mass over the far viscosity: fixes the level, lets Cholesky run without pivots."""

NEWTON_TOLERANCE = 1e-7
"""Residual over the first one: far below the discretisation's 1e-3."""

NEWTON_STEPS = 30
HALVINGS = 8

SAMPLES = 8
"""Intervals per side of an element between samples of the pressure: twice the order of P4."""

FIRST_LAYER = 0.3
"""First layer over the fiber's radius, in the confocal coordinate s."""

FIRST_ANGLE = 0.5
"""First element at a tip over ``1/r_e``, the eccentric angle at which a tip turns to the side."""


@dataclass(frozen=True)
class SpheroidGrid:
    """How the half-space is divided.

    Parameters
    ----------
    layers, meridian, azimuth : int
        Elements outward, from a tip to the equator, and around the half ``z >= 0``.
    order : int
        Of the velocity.
    outer : float
        Largest half-axis of the outer surface over the fiber's half-length [-].
    """

    layers: int = 6
    meridian: int = 6
    azimuth: int = 4
    order: int = 4
    outer: float = 10.0


@dataclass(frozen=True, eq=False)
class SpheroidSolution:
    """One flow past the fiber.

    Parameters
    ----------
    spin : float
        ``omega/d`` [-], relative to the melt's.
    points : (m, 3) ndarray
        Points of the surface in half-lengths, the fiber along x, the flow's plane ``z = 0`` [-].
    pressure : (m,) ndarray
        Pressure there over the far field's [K gamma_dot^n].
    unknowns, steps : int
        Coupled unknowns, and Newton steps.
    """

    spin: float
    points: Array
    pressure: Array
    unknowns: int
    steps: int


class SpheroidCell:
    """Mesh and spaces of one aspect ratio; flows are solved one from another.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], at least one.
    grid : SpheroidGrid
        The division.
    """

    def __init__(self, aspect_ratio: float, grid: SpheroidGrid | None = None) -> None:
        self.aspect_ratio = aspect_ratio
        self.grid = SpheroidGrid() if grid is None else grid
        self.mesh, self._shift = _mesh(aspect_ratio, self.grid)
        order = self.grid.order
        velocity = ng.VectorH1(
            self.mesh, order=order, dirichlet="fiber|far", dirichletz="fiber|far|plane"
        )
        self.space = velocity * ng.H1(self.mesh, order=order - 1)
        self.state = ng.GridFunction(self.space)
        self.spin = 0.0

    # waiting BLAS threads cost up to five times the work on a busy machine
    @threadpool_limits.wrap(limits=1, user_api="blas")  # type: ignore[untyped-decorator]  # has no types
    def solve(self, viscosity: Viscosity, phi: float) -> SpheroidSolution:
        """Solve from the last flow, or from the undisturbed one."""
        (u, p), (v, q) = self.space.TnT()
        strain = ng.Sym(ng.Grad(u))
        eta = viscosity(2.0 * ng.InnerProduct(strain, strain))
        form = ng.BilinearForm(self.space, symmetric=True, condense=True)
        form += (
            2.0 * eta * ng.InnerProduct(strain, ng.Sym(ng.Grad(v)))
            - p * ng.div(v)
            - q * ng.div(u)
            - COMPRESSIBILITY * p * q
        ) * ng.dx(bonus_intorder=2)
        far = 0.5 * ng.CF(
            (
                np.cos(phi) * ng.x + np.sin(phi) * ng.y,
                np.sin(phi) * ng.x - np.cos(phi) * ng.y,
                0.0,
            )
        )
        state, space = self.state, self.space
        if ng.Norm(state.vec) == 0.0:
            state.components[0].Set(far)
        turn = ng.CF((-ng.y, ng.x, 0.0))
        boundary = ng.GridFunction(space)
        boundary.components[0].Set(far, definedon=self.mesh.Boundaries("far"))
        rigid = ng.GridFunction(space)
        rigid.components[0].Set(turn, definedon=self.mesh.Boundaries("fiber"))
        fixed = ng.Projector(space.FreeDofs(), False)
        free = ng.Projector(space.FreeDofs(), True)
        jump = (fixed * (boundary.vec + self.spin * rigid.vec - state.vec)).Evaluate()
        residual, turning = state.vec.CreateVector(), state.vec.CreateVector()
        step, trial = state.vec.CreateVector(), state.vec.CreateVector()
        first = size = np.inf
        for count in range(NEWTON_STEPS):
            form.Apply(state.vec, residual)
            form.AssembleLinearization(state.vec)
            inverse = form.mat.Inverse(space.FreeDofs(coupling=True), inverse="sparsecholesky")

            def lifted(values: Any) -> Any:
                """Return the flow of the tangent's melt with these values on the boundary."""
                out = values.CreateVector()
                out.data = values
                out.data -= inverse * (form.mat * values).Evaluate()
                out.data += form.harmonic_extension * out
                return out

            turning.data = lifted(rigid.vec)
            stiffness = ng.InnerProduct(turning, (form.mat * turning).Evaluate())
            load = (residual + form.harmonic_extension_trans * residual).Evaluate()
            step.data = -1.0 * (inverse * load)
            step.data += form.harmonic_extension * step
            step.data -= form.inner_solve * residual
            if count == 0:  # the boundary takes its values in the first, whole step
                step.data += lifted(jump)
            torque = ng.InnerProduct(residual, turning)
            if count == 0:
                torque += ng.InnerProduct(turning, (form.mat * step).Evaluate())
            change = -torque / stiffness
            step.data += change * turning
            factor = 1.0
            for _ in range(HALVINGS):
                trial.data = state.vec + factor * step
                form.Apply(trial, residual)
                norm = ng.Norm((free * residual).Evaluate())
                torque = abs(ng.InnerProduct(residual, turning)) / np.sqrt(stiffness)
                norm = float(np.hypot(norm, torque))
                if count == 0 or norm < size:
                    break
                factor *= 0.5
            state.vec.data = trial
            self.spin += factor * change
            scale = ng.Norm(residual)
            first = scale if count == 0 else first
            size = norm
            if size <= NEWTON_TOLERANCE * first:
                return self._sample(count + 1)
        msg = (
            f"spheroid cell: residual {size / first:.1e} after {NEWTON_STEPS} steps, bound "
            f"{NEWTON_TOLERANCE:g}: start from the flow of a larger index"
        )
        raise ConvergenceError(msg)

    def _sample(self, steps: int) -> SpheroidSolution:
        """Read the surface and take the mean level of the outer surface off."""
        mesh, pressure = self.mesh, self.state.components[1]
        side = np.linspace(0.0, 1.0, SAMPLES + 1)
        square = [(x, y) for x in side for y in side]
        rules = {
            ng.ET.QUAD: ng.IntegrationRule(square, [0.0] * len(square)),
            ng.ET.TRIG: ng.IntegrationRule(
                [(x, y) for x, y in square if x + y <= 1.0 + 1e-12],
                [0.0] * sum(x + y <= 1.0 + 1e-12 for x, y in square),
            ),
        }
        mapped = mesh.MapToAllElements(rules, mesh.Boundaries("fiber"))
        values = np.asarray(ng.CF((ng.x, ng.y, ng.z, pressure))(mapped)).reshape(-1, 4)
        edge = ng.ds("far", bonus_intorder=4)
        level = ng.Integrate(pressure * edge, mesh) / ng.Integrate(ng.CF(1.0) * edge, mesh)
        unknowns = int(sum(self.space.FreeDofs(coupling=True)))
        return SpheroidSolution(
            2.0 * self.spin, values[:, :3].copy(), values[:, 3] - level, unknowns, steps
        )


def _graded(first: float, total: float, count: int) -> Array:
    """Return ``count`` intervals in geometric progression from ``first`` to ``total``."""
    if first * count >= total:
        return np.linspace(0.0, total, count + 1)
    ratio = brentq(lambda g: first * (g**count - 1.0) / (g - 1.0) - total, 1.0 + 1e-9, 1e3)
    return np.concatenate([[0.0], np.cumsum(first * ratio ** np.arange(count))])


def _mesh(aspect_ratio: float, grid: SpheroidGrid) -> tuple[Any, Any]:
    """Return the curved half-space and the deformation that has to outlive it.

    Unit vectors ``e`` are linear between vertices and divided by their length, which is smooth
    across the poles, where the azimuth is not.
    """
    squared = 1.0 - aspect_ratio**-2
    start = np.log1p(1.0 / aspect_ratio)
    outward = np.log(grid.outer + np.sqrt(grid.outer**2 - squared)) - start
    first = FIRST_LAYER / aspect_ratio
    shells = start + _graded(first, outward, grid.layers)
    half = _graded(FIRST_ANGLE / aspect_ratio, 0.5 * np.pi, grid.meridian)
    angles = np.concatenate([half, np.pi - half[-2::-1]])
    around = np.linspace(0.0, np.pi, grid.azimuth + 1)
    last = angles.size - 1
    raw = ngm.Mesh(dim=3)
    number: dict[tuple[int, int, int], Any] = {}
    charts: list[tuple[float, ...]] = []

    def vertex(i: int, j: int, k: int) -> Any:
        """Return the vertex, one at a pole for every azimuth."""
        key = (i, j, k if 0 < j < last else 0)
        if key not in number:
            nu, psi = angles[j], around[k]
            e = (np.cos(nu), np.sin(nu) * np.cos(psi), np.sin(nu) * np.sin(psi))
            far, near = 0.5 * np.exp(shells[i]), 0.5 * squared * np.exp(-shells[i])
            point = ((far + near) * e[0], (far - near) * e[1], (far - near) * e[2])
            number[key] = raw.Add(ngm.MeshPoint(ngm.Pnt(*point)))
            charts.append((*e, shells[i]))
        return number[key]

    for index, name in enumerate(("fiber", "far", "plane"), 1):
        raw.Add(ngm.FaceDescriptor(surfnr=index, domin=1, domout=0, bc=index))
        raw.SetBCName(index - 1, name)
    raw.SetMaterial(1, "melt")
    for i, j, k in np.ndindex(grid.layers, last, grid.azimuth):
        square = ((j, k), (j + 1, k), (j + 1, k + 1), (j, k + 1))
        below = list(dict.fromkeys(vertex(i, *at) for at in square))
        above = list(dict.fromkeys(vertex(i + 1, *at) for at in square))
        raw.Add(ngm.Element3D(1, below + above))
        if i == 0:
            raw.Add(ngm.Element2D(1, below[::-1]))
        if i == grid.layers - 1:
            raw.Add(ngm.Element2D(2, above))
        for at, is_plane in ((0, k == 0), (grid.azimuth, k == grid.azimuth - 1)):
            if is_plane:
                ring = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                raw.Add(ngm.Element2D(3, [vertex(*corner, at) for corner in ring]))
    mesh = ng.Mesh(raw)
    linear = ng.H1(mesh, order=1)
    chart = [ng.GridFunction(linear) for _ in range(4)]
    for function, values in zip(chart, np.array(charts).T, strict=True):
        function.vec.FV().NumPy()[:] = values
    length = ng.sqrt(chart[0] ** 2 + chart[1] ** 2 + chart[2] ** 2)
    far, near = 0.5 * ng.exp(chart[3]), 0.5 * squared * ng.exp(-chart[3])
    target = ng.CF(
        (
            (far + near) * chart[0] / length,
            (far - near) * chart[1] / length,
            (far - near) * chart[2] / length,
        )
    )
    shift = ng.GridFunction(ng.VectorH1(mesh, order=grid.order))
    shift.Set(target - ng.CF((ng.x, ng.y, ng.z)))
    mesh.SetDeformation(shift)
    return mesh, shift
