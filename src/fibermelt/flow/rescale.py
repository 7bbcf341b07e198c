"""A solved flow with another melt: viscosity scales the pressure and nothing else."""

from __future__ import annotations

from dataclasses import replace

from fibermelt.flow.deposition import FlowSolution
from fibermelt.rheology import Newtonian

__all__ = ["rescaled"]


def rescaled(solution: FlowSolution, melt: Newtonian) -> FlowSolution:
    """Return ``solution`` with ``melt`` in place of its own.

    The flow is solved in units of capillary width, bed speed and viscosity (Stokes, Eq. 1-4: no
    inertia, gravity or surface tension), so surfaces, velocity and gradient stay as they are to
    the last bit; pressures scale with the viscosity, to rounding.

    Parameters
    ----------
    solution : FlowSolution
        A solved flow.
    melt : Newtonian
        The other melt; its viscosity [Pa s] counts.
    """
    factor = melt.viscosity / solution.problem.melt.viscosity
    field = solution.field
    return replace(
        solution,
        problem=replace(solution.problem, melt=melt),
        field=replace(field, pressure=field.pressure * factor),
        inlet_pressure=solution.inlet_pressure * factor,
        error=replace(solution.error, inlet_pressure=solution.error.inlet_pressure * factor),
    )
