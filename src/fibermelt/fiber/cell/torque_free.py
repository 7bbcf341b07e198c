"""A rigid fiber free of torque in a cell of a thinning melt, whichever space it is in (NGSolve).

Newton's method with the tangent ``2 eta D(w) + 8 (d eta/ds) (D:D(w)) D``, ``s = gamma_dot^2 = 2
D:D``; the spin is an unknown that virtual work closes: the reactions' work in turning the fiber,
its torque, vanishes. Each step has two right-hand sides, the residual and the turning fiber.
Lengths are in half-lengths, strains over the far field's size ``d``, stresses over ``eta(2 d) d``,
so that all numbers are of order one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fibermelt.errors import ConvergenceError
from fibermelt.fiber.cell.mesh import EXTRA_QUADRATURE
from fibermelt.fiber.cell.stokes import COMPRESSIBILITY
from fibermelt.fiber.cell.thinning import CellAnswer, torque_free_step
from fibermelt.melt import ViscosityLaw

__all__ = ["TorqueFreeCell"]

Array = NDArray[np.float64]

RESIDUAL_TOLERANCE = 1e-5
"""Largest residual of momentum and torque, in units in which the load is of order one: spin and
pressure are then off by 1e-6 and 1e-5, a hundredth of what the elements leave."""

MOST_STEPS = 60
"""Newton steps; 5 to 20 are taken. The last ones, near points of no deformation, gain a half
each."""

SMALLEST_STEP = 2.0**-10
"""Part of a Newton step below which there is no descent to be found."""

DESCENT = 0.1
"""Part of the fall that a step promises which it has to keep."""

CONTINUATION = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Powers of the viscosity's variation that lead from the Newtonian melt, where Newton fails
alone."""


class TorqueFreeCell(ABC):
    """A rigid fiber in a cell of one melt; each answer starts from the last one.

    Parameters
    ----------
    space : FESpace
        Velocity and pressure, given on the boundaries ``fiber`` and ``edge``, the far field's.
    law : ViscosityLaw
        The melt.
    extra : int
        Additional order of integration.
    """

    def __init__(self, space: Any, law: ViscosityLaw, extra: int = EXTRA_QUADRATURE) -> None:
        self.space, self.law, self.extra = space, law, extra
        self.flow = ng.GridFunction(space)
        self._rate, self._unit, self._power = (ng.Parameter(1.0) for _ in range(3))
        self._forms()
        self.free = ng.Projector(space.FreeDofs(), True)
        turning = ng.GridFunction(space)
        self._set_velocity(turning, (-ng.y, ng.x), "fiber")
        self.turn = turning.vec
        self.spin, self.started = 0.0, False

    @property
    def unknowns(self) -> int:
        """Return the number of velocity and pressure unknowns."""
        return int(sum(self.space.FreeDofs()))

    def _rates(self, fields: Any) -> tuple[Any, Any, Any]:
        """Return the rate of deformation, the divergence and the pressure of a function."""
        u, p = fields
        return ng.Sym(ng.Grad(u)), ng.div(u), p

    def _set_velocity(self, function: Any, field: tuple[Any, Any], boundary: str = "") -> None:
        """Set the velocity in the plane, everywhere or on a boundary alone."""
        where = {"definedon": self.space.mesh.Boundaries(boundary)} if boundary else {}
        function.components[0].Set(ng.CF(field), **where)

    @abstractmethod
    def _surface_pressure(self) -> Array:
        """Return the pressure where the surface is read, its level taken off."""

    def _forms(self) -> None:
        """Set up residual and tangent at the present flow."""
        trial, test = self.space.TnT()
        strain, dilation, p = self._rates(self.flow.components)
        change, swelling, r = self._rates(trial)
        virtual, opening, q = self._rates(test)
        s = 2.0 * ng.InnerProduct(strain, strain)
        eta, slope = self.law.expression(self._rate * self._rate * s)
        # eta^theta leads from a Newtonian melt (0) to this one (1)
        eta, slope = eta * self._unit, slope * self._unit * self._rate * self._rate
        slope = (self._power * eta ** (self._power - 1.0) * slope).Compile()
        eta = (eta**self._power).Compile()
        dx = ng.dx(bonus_intorder=self.extra)
        self.tangent = ng.BilinearForm(self.space, symmetric=True, condense=True)
        self.tangent += (
            2.0 * eta * ng.InnerProduct(change, virtual)
            + 8.0 * slope * ng.InnerProduct(strain, change) * ng.InnerProduct(strain, virtual)
            - r * opening
            - q * swelling
            - COMPRESSIBILITY * r * q
        ) * dx
        self.residual = ng.LinearForm(self.space)
        self.residual += (
            2.0 * eta * ng.InnerProduct(strain, virtual)
            - p * opening
            - q * dilation
            - COMPRESSIBILITY * p * q
        ) * dx

    def _far_field(self, gradient: Array) -> None:
        """Put a far field on the edge and the spin on the fiber; the inside stays."""
        (a, b), (c, d) = gradient.tolist()
        field = (a * ng.x + b * ng.y, c * ng.x + d * ng.y)
        inside = self.flow.vec.CreateVector()
        if not self.started:
            self._set_velocity(self.flow, field)
        inside.data = self.free * self.flow.vec
        self.flow.vec[:] = 0.0
        self._set_velocity(self.flow, field, "edge")
        self.flow.vec.data += inside + self.spin * self.turn

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
        c, s = float(np.cos(phase)), float(np.sin(phase))
        self._rate.Set(0.5 * rate)
        self._unit.Set(1.0 / float(self.law.viscosity_at(rate)))
        strain = np.array([[c, s], [s, -c]])
        steps = 0
        for powers in ((1.0,) if self.started else (0.0, 1.0), CONTINUATION):
            self._far_field(strain)
            for power in powers:
                self._power.Set(power)
                taken, left = self._newton()
                steps += taken
            if left <= RESIDUAL_TOLERANCE:
                self.started = True
                return CellAnswer(self.spin, self._surface_pressure(), steps)
            self.spin, self.started = 0.0, False
        msg = (
            f"fiber cell: residual {left:.1e} after {steps} Newton steps at {rate:g} 1/s, "
            f"bound {RESIDUAL_TOLERANCE:g}: the melt thins too steeply; take a larger melt.index"
        )
        raise ConvergenceError(msg)

    def _left(self) -> float:
        """Assemble the residual; return the size of what is free of it, and of the torque."""
        self.residual.Assemble()
        torque = ng.InnerProduct(self.residual.vec, self.turn)
        return float(np.hypot(ng.Norm((self.free * self.residual.vec).Evaluate()), torque))

    def _newton(self) -> tuple[int, float]:
        """Take Newton steps with backtracking until little is left; return count and rest."""
        left = self._left()
        for taken in range(MOST_STEPS):
            if not left > RESIDUAL_TOLERANCE:
                return taken, left
            step, spin = self._step()
            before, old, part = left, self.flow.vec.Copy(), 1.0
            while part >= SMALLEST_STEP:
                self.flow.vec.data = old + part * step
                left = self._left()
                if left <= (1.0 - DESCENT * part) * before:
                    break
                part *= 0.5
            else:
                return taken, before
            self.spin += part * spin
        return MOST_STEPS, left

    def _step(self) -> tuple[Any, float]:
        """Return Newton's step of the flow and of the spin."""
        self.tangent.Assemble()
        return torque_free_step(self.space, self.free, self.tangent, self.residual.vec, self.turn)
