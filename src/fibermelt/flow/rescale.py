"""A solved flow with another melt, or with both speeds faster by one factor: it only scales."""

from __future__ import annotations

from dataclasses import replace

from fibermelt.errors import ConfigError
from fibermelt.flow.deposition import FlowSolution
from fibermelt.flow.problem import Deposition

__all__ = ["RATIO_DIGITS", "rescaled", "speed_ratio"]

RATIO_DIGITS = 12
"""Significant digits of a ratio of speeds that must agree: three less than a quotient has."""


def speed_ratio(inlet_speed: float, bed_speed: float) -> float:
    """Return the mean inlet speed over the bed's, without what rounding makes of it."""
    return float(f"{inlet_speed / bed_speed:.{RATIO_DIGITS}g}")


def rescaled(solution: FlowSolution, problem: Deposition) -> FlowSolution:
    """Return the solution of ``problem``, one of the same nozzle and the same ratio of speeds.

    The flow is solved in units of capillary width ``W``, bed speed ``V`` and viscosity ``mu``
    (Stokes, Eq. 1-4: no inertia, gravity or surface tension), so surfaces stay as they are;
    velocities, their gradient and the stream function scale with ``V``, pressures with ``mu V``,
    all to rounding.

    Parameters
    ----------
    solution : FlowSolution
        A solved flow.
    problem : Deposition
        The other melt and speeds.

    Raises
    ------
    ConfigError
        If the nozzles or the ratios of the speeds differ.
    """
    solved = solution.problem
    ratios = [speed_ratio(one.inlet_speed, one.bed_speed) for one in (solved, problem)]
    if problem.nozzle != solved.nozzle or ratios[0] != ratios[1]:
        msg = (
            f"a flow scales to another melt and to faster speeds only: flow.inlet_speed over "
            f"flow.bed_speed is {ratios[1]:g} where {ratios[0]:g} was solved, or the nozzle is "
            "another; solve it, from the surfaces of this one (start=)"
        )
        raise ConfigError(msg)
    faster = problem.bed_speed / solved.bed_speed
    stress = faster * (problem.melt.viscosity / solved.melt.viscosity)
    field = solution.field
    return replace(
        solution,
        problem=problem,
        field=replace(
            field,
            velocity=field.velocity * faster,
            pressure=field.pressure * stress,
            gradient=field.gradient * faster,
            stream_function=field.stream_function * faster,
            gradient_error=field.gradient_error * faster,
        ),
        inlet_pressure=solution.inlet_pressure * stress,
        error=replace(solution.error, inlet_pressure=solution.error.inlet_pressure * stress),
    )
