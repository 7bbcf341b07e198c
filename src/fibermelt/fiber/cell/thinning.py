"""The confined fiber in a melt whose viscosity depends on the rate of deformation (NGSolve).

The cell is that of `solve_cell`, its stress ``2 eta(gamma_dot) D``; of the cell one half, as the
flow around a centred fiber is at ``-x`` what it is at ``x``, turned around (the pressure the same).

Newton's method takes the law from the stress to the strain. Each point of integration holds a
strain ``E``; a step solves momentum and torque with the stress ``S = 2 eta E + C (D(u) - E)``,
where ``C = 2 eta + 8 (d eta/ds) E E`` is the tangent at ``E``, ``s = 2 E:E``, and the next ``E``
is the strain whose stress is ``S``. That function is smooth where nothing deforms, of the power
``1/n``; the stress as a function of the strain is steep there without bound, so that Newton's
method on ``D(u)`` itself needs continuation and backtracking, and this one neither (the idea, for
melts that yield: Rudi, Shih and Stadler 2020, doi 10.1029/2020GC009059). It starts from the strain
of a Newtonian melt, the sum of two flows that are solved for once.

The spin is an unknown that virtual work closes: the reactions' work in turning the fiber, its
torque, vanishes. Each step has two right-hand sides, the residual and the turning fiber. Lengths
are in half-lengths, strains over the far field's size ``d``, stresses over ``eta(2 d) d``, so that
all numbers are of order one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber.cell.mesh import EXTRA_QUADRATURE, curved_mesh, sample_nodes
from fibermelt.fiber.cell.solve import cell_grid, drawing
from fibermelt.fiber.cell.stokes import COMPRESSIBILITY
from fibermelt.fiber.cell_data import CellNumerics, FlowAround
from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.checks import checked_gradient, checked_number, checked_positive
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.surroundings import FlowAround as SeenFlow
from fibermelt.fiber.surroundings import strain_at, turned_to_flow
from fibermelt.melt import Newtonian, ViscosityLaw
from fibermelt.melt.strain import NOTHING, WEIGHTS, strain_of_stress
from fibermelt.threads import exclusive

__all__ = [
    "THINNING_NUMERICS",
    "CellAnswer",
    "ThinningCell",
    "thinning_flow_around",
    "thinning_grid",
    "thinning_surroundings",
    "torque_free_step",
]

Array = NDArray[np.float64]

THINNING_NUMERICS = CellNumerics(order=5, angular_spacing=0.4, radial_spacing=1.0)
"""How a thinning cell is solved: its grid is sharper than a Newtonian one, and even away from tips.
A table's extremes in ten random directions are then within 2.3e-3 of the largest pressure of those
at order 6 on a third more columns and rows, 2.7 times as sharp (n = 0.25, M = 4, r_e = 6)."""

SHARPENING = 15.0
"""How much finer than a Newtonian cell at the tip and the surface: where nothing deforms, as at the
tip in a stretch, a thinning melt is stiff, and the lowest pressure lies just beside. n = 0.25, M =
4, r_e = 6: with 10 it is 3.0e-3 off that of order 7, with 15 1.0e-3, in as many rows."""

EVEN_FROM = 0.5
"""Eccentric angle [rad] beyond which columns are even: the highest pressure stands beside the point
where nothing deforms, which moves from flank to tip as the strain turns. Without, columns are 0.4
wide at the flanks, and from direction to direction it jumps by up to 4e-3 of the largest (n =
0.25, M = 4, r_e = 6); with it by 1e-4, and the same with 0.3."""

RESIDUAL_TOLERANCE = 1e-5
"""Largest residual of momentum and torque, in units in which the load is of order one. The spin is
then off by 1e-7, extremes by 1e-4 of the largest pressure, the tip's by 1e-2 of it where nothing
deforms there (n = 0.35); with 1e-4 a fifth of the steps is saved, and the tip's is off by 2e-2."""

MOST_STEPS = 40
"""Newton steps; 1 to 5 are taken for n = 0.35, up to 7 for 0.2."""


@dataclass(frozen=True, eq=False)
class CellAnswer:
    """What a fiber answers to one strain.

    Parameters
    ----------
    spin : float
        Torque-free spin relative to the melt's over ``d`` [-].
    pressure : (k,) array
        Pressure at the surface nodes ``s`` in [0, pi) over ``eta(2 d) d`` [-], ``k`` half of
        ``columns * order``.
    steps : int
        Newton steps.
    """

    spin: float
    pressure: Array
    steps: int


def thinning_grid(fiber: Ellipse, domain_size: float, numerics: CellNumerics) -> CellGrid:
    """Return the grid of a thinning melt's cell, or refuse it (`ConfigError`)."""
    grid = cell_grid(fiber, domain_size, numerics)
    if not isinstance(grid, CellGrid):
        msg = 'numerics.cell mesh = "paper": a thinning melt needs the "graded" mesh'
        raise ConfigError(msg)
    return replace(grid, sharpening=SHARPENING, even_from=EVEN_FROM)


def torque_free_step(
    space: Any, free: Any, tangent: Any, residual: Any, turn: Any, torque: float = 0.0
) -> tuple[Any, float]:
    """Return Newton's step of a flow and of the spin of a fiber in it, closed by virtual work.

    Parameters
    ----------
    space, free, tangent, residual
        The flow's space, the projector on its free unknowns, the tangent, assembled and condensed,
        and the residual.
    turn : vector
        The fiber turning at unit rate, zero elsewhere.
    torque : float
        On the fiber, of the part of it that the space has.
    """
    inverse = tangent.mat.Inverse(space.FreeDofs(coupling=True), inverse="sparsecholesky")
    load = (-1.0 * (free * residual)).Evaluate()
    reduced = load.Copy()
    reduced.data += tangent.harmonic_extension_trans * reduced
    step = (inverse * reduced).Evaluate()
    step.data += tangent.harmonic_extension * step
    step.data += tangent.inner_solve * load
    turning = (-1.0 * (inverse * (tangent.mat * turn))).Evaluate()
    turning.data += turn
    resistance = ng.InnerProduct(turn, (tangent.mat * turning).Evaluate())
    turning.data += tangent.harmonic_extension * turning
    spin = float((torque - ng.InnerProduct(residual, turning)) / resistance)
    step.data += spin * turning
    return step, spin


class ThinningCell:
    """A fiber's cell in one melt.

    Parameters
    ----------
    fiber, domain_size, numerics
        As in `solve_cell`; the graded mesh only.
    law : ViscosityLaw
        The melt.

    Raises
    ------
    ConfigError
        If the fiber does not fit into its cell.
    """

    def __init__(
        self, fiber: Ellipse, domain_size: float, law: ViscosityLaw, numerics: CellNumerics
    ) -> None:
        grid = thinning_grid(fiber, domain_size, numerics)
        self.law, self.numerics, self.grid = law, numerics, grid
        self.mesh = curved_mesh(grid, numerics.order, half=True)
        order, mesh = numerics.order, self.mesh.mesh
        velocity = ng.VectorH1(mesh, order=order, dirichlet="fiber|edge")
        opposite = ng.Periodic(velocity, phase=[-1])  # u(-x) = -u(x)
        self.space = opposite * ng.Periodic(ng.H1(mesh, order=order - 1))
        self.flow = ng.GridFunction(self.space)
        self._forms()
        self.free = ng.Projector(self.space.FreeDofs(), True)
        self.turn = self._turning()
        self.nodes = sample_nodes(self.mesh)
        self.spin = 0.0

    @property
    def unknowns(self) -> int:
        """Return the number of velocity and pressure unknowns."""
        return int(sum(self.space.FreeDofs()))

    def _forms(self) -> None:
        """Set up the tangent at the strain that is held, and the residual of its stress."""
        points = ng.comp.IntegrationRuleSpace(
            self.mesh.mesh, order=self.numerics.order + EXTRA_QUADRATURE // 2
        )
        rules = points.GetIntegrationRules()
        self._mapped = self.mesh.mesh.MapToAllElements(rules[ng.ET.QUAD], ng.VOL)
        self._held = [ng.GridFunction(points) for _ in range(3)]
        self._eta, self._slope = (ng.GridFunction(points) for _ in range(2))
        held = ng.CF((self._held[0], self._held[2], self._held[2], self._held[1]), dims=(2, 2))
        (w, r), (v, q) = self.space.TnT()
        u, p = self.flow.components
        self._strain, change, test = (ng.Sym(ng.Grad(field)) for field in (u, w, v))
        dx = ng.dx(intrules=rules)
        self.tangent = ng.BilinearForm(self.space, symmetric=True, condense=True)
        self.tangent += (
            2.0 * self._eta * ng.InnerProduct(change, test)
            + 8.0 * self._slope * ng.InnerProduct(held, change) * ng.InnerProduct(held, test)
            - r * ng.div(v)
            - q * ng.div(w)
            - COMPRESSIBILITY * r * q
        ) * dx
        ahead = ng.InnerProduct(held, self._strain - held)
        self.residual = ng.LinearForm(self.space)
        self.residual += (
            2.0 * self._eta * ng.InnerProduct(self._strain, test)
            + 8.0 * self._slope * ahead * ng.InnerProduct(held, test)
            - p * ng.div(v)
            - q * ng.div(u)
            - COMPRESSIBILITY * p * q
        ) * dx

    def _turning(self) -> Any:
        """Return the coefficients of the fiber turning at unit rate, zero elsewhere."""
        motion = ng.GridFunction(self.space)
        where = self.mesh.mesh.Boundaries("fiber")
        motion.components[0].Set(ng.CF((-ng.y, ng.x)), definedon=where)
        return motion.vec

    def _far_field(self, gradient: Array) -> None:
        """Put a far field on the edge, and nothing elsewhere."""
        (a, b), (c, d) = gradient.tolist()
        field = ng.CF((a * ng.x + b * ng.y, c * ng.x + d * ng.y))
        self.flow.vec[:], self.spin = 0.0, 0.0
        self.flow.components[0].Set(field, definedon=self.mesh.mesh.Boundaries("edge"))

    @cached_property
    def _newtonian(self) -> tuple[Array, Array]:
        """Return the strains of a Newtonian melt at the phases 0 and pi/2."""
        found = []
        for gradient in (np.diag([1.0, -1.0]), np.array([[0.0, 1.0], [1.0, 0.0]])):
            self._far_field(gradient)
            found.append(self._newtonian_strain())
        return found[0], found[1]

    def _newtonian_strain(self, torque: float = 0.0) -> Array:
        """Solve for the flow of a Newtonian melt, and return its strain."""
        level = np.zeros((len(WEIGHTS), self._eta.vec.size))
        return self._step(Newtonian(1.0), level, torque)[1]

    # waiting BLAS threads cost up to five times the work on a busy machine
    @threadpool_limits.wrap(limits=1, user_api="blas")  # type: ignore[untyped-decorator]  # no types
    def answer(self, rate: float, phase: float) -> CellAnswer:
        """Return spin and surface pressure at a strain.

        Parameters
        ----------
        rate : float
            ``gamma_dot = 2 d`` of the far field [1/s], positive.
        phase : float
            ``phi`` [rad]: ``D_11 = d cos phi``, ``D_12 = d sin phi`` in the fiber's axes.

        Raises
        ------
        ConvergenceError
            If Newton's method does not converge.
        """
        law = self.law.scaled(1.0 / float(self.law.viscosity_at(rate)), 0.5 * rate)
        c, s = float(np.cos(phase)), float(np.sin(phase))
        start = c * self._newtonian[0] + s * self._newtonian[1]
        self._far_field(np.array([[c, s], [s, -c]]))
        steps = self._balance(law, start)
        return CellAnswer(self.spin, self._surface_pressure(), steps)

    def _balance(self, law: ViscosityLaw, strain: Array, torque: float = 0.0) -> int:
        """Take Newton steps from a strain until little is left; return their count.

        The far field and the law are scaled; half of a ``torque`` acts on half of the fiber.
        """
        left = np.inf
        for steps in range(1, MOST_STEPS + 1):
            stress, found = self._step(law, strain, torque)
            left = self._left(law, found, torque)
            if left <= RESIDUAL_TOLERANCE:
                return steps
            if not np.isfinite(left):
                break
            strain = strain_of_stress(law, stress, found)
        msg = (
            f"fiber cell: residual {left:.1e} after {steps} Newton steps, bound "
            f"{RESIDUAL_TOLERANCE:g}: the melt thins too steeply; take a larger melt.index"
        )
        raise ConvergenceError(msg)

    def _strain_at_points(self) -> Array:
        """Return the flow's strain at the points of integration, components 11, 22, 12."""
        values = np.asarray(self._strain(self._mapped)).reshape(-1, 4)
        return np.ascontiguousarray(values[:, [0, 3, 1]].T)

    def _hold(self, law: ViscosityLaw, strain: Array) -> tuple[Array, Array]:
        """Assemble the residual at a strain; return its viscosity and slope."""
        viscosity, slope = law.expression(2.0 * (WEIGHTS @ strain**2) + NOTHING**2)
        for function, values in zip(
            (*self._held, self._eta, self._slope), (*strain, viscosity, slope), strict=True
        ):
            function.vec.FV().NumPy()[:] = values
        self.residual.Assemble()
        return viscosity, slope

    def _left(self, law: ViscosityLaw, strain: Array, torque: float) -> float:
        """Return the size of the residual where it is free, and of the torque that is missing."""
        self._hold(law, strain)
        missing = ng.InnerProduct(self.residual.vec, self.turn) - 0.5 * torque
        return float(np.hypot(ng.Norm((self.free * self.residual.vec).Evaluate()), missing))

    def _step(self, law: ViscosityLaw, held: Array, torque: float) -> tuple[Array, Array]:
        """Take Newton's step of flow and spin; return the stress that balances, and the strain."""
        viscosity, slope = self._hold(law, held)
        self.tangent.Assemble()
        step, spin = torque_free_step(
            self.space, self.free, self.tangent, self.residual.vec, self.turn, 0.5 * torque
        )
        self.flow.vec.data += step
        self.spin += spin
        found = self._strain_at_points()
        ahead = WEIGHTS @ (held * (found - held))
        return 2.0 * viscosity * found + 8.0 * slope * ahead * held, found

    def _surface_pressure(self) -> Array:
        """Return the pressure at the surface nodes over half the fiber, its level taken off."""
        mapped, around, outward = self.nodes
        order, grid = self.numerics.order, self.grid
        read = np.asarray(self.flow.components[1](mapped)).ravel()
        values = np.empty(grid.columns * order // 2)
        surface = outward == 0
        values[around[surface] % values.size] = read[surface]
        return values - self._level(read)

    def _level(self, read: Array) -> float:
        """Return the pressure's level: at the far node of all that is read, or over the edge."""
        _, around, outward = self.nodes
        order, pressure = self.numerics.order, self.flow.components[1]
        if self.numerics.pressure_reference == "far-node":
            at = np.flatnonzero((outward == self.grid.rows * order) & (around == 0))
            return float(read[at[0]])
        edge = ng.ds("edge", bonus_intorder=2 * order)
        length = ng.Integrate(ng.CF(1.0) * edge, self.mesh.mesh)
        return float(ng.Integrate(pressure * edge, self.mesh.mesh) / length)

    def around(self, rate: float, phase: float) -> FlowAround:
        """Return the flow around the fiber at a strain, as `answer` has it.

        Of the other half of the cell all is what it is here at the opposite point, velocity and
        place turned around.
        """
        spin = self.answer(rate, phase).spin
        mapped, around, outward = self.nodes
        order, grid = self.numerics.order, self.grid
        half = grid.columns * order // 2

        def whole(function: Any, sign: float) -> Array:
            values = np.asarray(function(mapped)).reshape(around.size, -1)
            result = np.empty((2 * half, grid.rows * order + 1, values.shape[1]))
            result[around, outward] = values
            result[half:] = sign * result[:half]
            return result.reshape(-1, values.shape[1])

        velocity, pressure = self.flow.components
        level = self._level(np.asarray(pressure(mapped)).ravel())
        cells, edges = drawing(self.mesh)
        return FlowAround(
            points=whole(ng.CF((ng.x, ng.y)), -1.0),
            cells=cells,
            element_edges=edges,
            velocity=whole(velocity, -1.0),
            pressure=whole(pressure, 1.0)[:, 0] - level,
            spin=spin,
        )


@exclusive
def thinning_surroundings(
    fiber: Ellipse,
    domain_size: float,
    law: ViscosityLaw,
    gradient: Array,
    angle: float,
    numerics: CellNumerics | None = None,
) -> tuple[FlowAround, SeenFlow]:
    """Return the flow around a confined fiber in a given flow of a thinning melt.

    As `Surroundings.around` has it of a Newtonian melt, whose flows add up; here the cell is solved
    at the strain that the fiber meets.

    Parameters
    ----------
    fiber, domain_size, law, numerics
        As in `solve_thinning`.
    gradient : (2, 2) array
        ``L_ij = d u_i / d x_j`` of the melt along the flow's axes [1/s].
    angle : float
        Of the fiber from the flow's x axis, counter-clockwise [rad].

    Returns
    -------
    tuple of fibermelt.fiber.cell_data.FlowAround and fibermelt.fiber.surroundings.FlowAround
        The cell as solved, in the fiber's axes and without units, and the flow in those of the
        given one.

    Raises
    ------
    ConfigError
        If the fiber does not fit into its cell, a number is out of its range, or nothing strains.
    ConvergenceError
        If the cell does not converge.
    """
    strain, spin = strain_at(checked_gradient(gradient, 2), checked_number("angle", angle))
    size = float(np.hypot(*strain))
    numerics = THINNING_NUMERICS if numerics is None else numerics
    rate = checked_positive("rate of deformation", 2.0 * size, "1/s", "100")
    phase = float(np.arctan2(strain[1], strain[0]))
    found = ThinningCell(fiber, domain_size, law, numerics).around(rate, phase)
    stress = float(law.viscosity_at(rate)) * size
    seen = turned_to_flow(found.points, size * found.velocity, stress * found.pressure, spin, angle)
    return found, seen


@exclusive
def thinning_flow_around(
    fiber: Ellipse,
    domain_size: float,
    law: ViscosityLaw,
    rate: float,
    phase: float,
    numerics: CellNumerics | None = None,
) -> FlowAround:
    """Return the flow around a confined fiber at one strain in a thinning melt, to be drawn.

    Parameters
    ----------
    fiber, domain_size, law, numerics
        As in `solve_thinning`.
    rate, phase : float
        ``gamma_dot`` [1/s], positive, and ``phi`` [rad]: ``D_11 = d cos phi``, ``D_12 = d sin phi``
        in the fiber's axes, ``d = gamma_dot/2``. In simple shear that of a fiber at the angle
        ``theta`` to the stream is ``pi/2 - 2 theta``.

    Raises
    ------
    ConfigError
        If the fiber does not fit into its cell, or a number is out of its range.
    ConvergenceError
        If the cell does not converge.
    """
    rate, phase = checked_positive("rate", rate, "1/s", "100"), checked_number("phase", phase)
    numerics = THINNING_NUMERICS if numerics is None else numerics
    return ThinningCell(fiber, domain_size, law, numerics).around(rate, phase)
