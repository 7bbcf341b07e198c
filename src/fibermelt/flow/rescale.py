"""A solved flow with another melt, or with both speeds faster by one factor: it only scales."""

from __future__ import annotations

from dataclasses import replace

from fibermelt.errors import ConfigError
from fibermelt.flow.deposition import FlowSolution
from fibermelt.flow.problem import Deposition

__all__ = ["RATIO_DIGITS", "rescaled", "scaled_constants", "speed_ratio"]

RATIO_DIGITS = 12
"""Significant digits of a ratio of speeds that must agree: three less than a quotient has."""


def speed_ratio(inlet_speed: float, bed_speed: float) -> float:
    """Return the mean inlet speed over the bed's, without what rounding makes of it."""
    return float(f"{inlet_speed / bed_speed:.{RATIO_DIGITS}g}")


def scaled_constants(problem: Deposition) -> tuple[str, ...]:
    """Return what decides a flow of its melt's law: its constants in the flow's units, in words.

    Without what rounding makes of them; a Newtonian melt is the same in any.
    """
    law = problem.scaled_law
    if law.is_newtonian:
        return ("Newtonian",)
    constants = law.constants().items()
    return (type(law).__name__, *(f"{name} {x:.{RATIO_DIGITS}g}" for name, x in constants))


def rescaled(solution: FlowSolution, problem: Deposition) -> FlowSolution:
    """Return the solution of ``problem``, one of the same nozzle and the same ratio of speeds.

    The flow is solved in units of capillary width ``W``, bed speed ``V`` and the viscosity ``eta``
    at ``V/W`` (no inertia, gravity or surface tension), so surfaces stay as they are where the
    melt's law is the same in these units: another Newtonian melt, all viscosities by a factor, or
    speeds and time constants together. Velocities, their gradient and the stream function scale
    with ``V``, pressures with ``eta V``, all to rounding.

    Parameters
    ----------
    solution : FlowSolution
        A solved flow.
    problem : Deposition
        The other melt and speeds.

    Raises
    ------
    ConfigError
        If the nozzles, the ratios of the speeds or the scaled laws differ.
    """
    solved = solution.problem
    ratios = [speed_ratio(one.inlet_speed, one.bed_speed) for one in (solved, problem)]
    laws = [scaled_constants(one) for one in (solved, problem)]
    if problem.nozzle != solved.nozzle or ratios[0] != ratios[1] or laws[0] != laws[1]:
        msg = (
            f"a flow scales to another melt and to faster speeds only: flow.inlet_speed over "
            f"flow.bed_speed is {ratios[1]:g} where {ratios[0]:g} was solved, the nozzle is "
            f"another, or the melt thins otherwise at its rates ({laws[1]} where {laws[0]} was "
            "solved); solve it, from the surfaces of this one (start=)"
        )
        raise ConfigError(msg)
    faster = problem.bed_speed / solved.bed_speed
    thicker = problem.viscosity_scale / solved.viscosity_scale
    stress = problem.stress_scale / solved.stress_scale
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
            viscosity=field.viscosity * thicker,
            gradient_error=field.gradient_error * faster,
        ),
        inlet_pressure=solution.inlet_pressure * stress,
        error=replace(solution.error, inlet_pressure=solution.error.inlet_pressure * stress),
    )
