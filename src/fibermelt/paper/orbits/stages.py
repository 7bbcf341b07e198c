"""The sensitivity studies of one fiber as stages: its turns in simple shear, and 2D against 3D.

The paper's section 2.3: a fiber in ``u_x = gamma_dot y`` over one turn for several aspect ratios,
shear rates and viscosities (Fig. 8-13, Table 1), in a cell so large that its edge is hardly felt,
and in an unbounded melt (Jeffery). Beyond the paper, what its plane ellipse costs: the same for a
spheroid, whose tips see more. What loads the finite elements is imported where it is used.
"""

from __future__ import annotations

from math import nan, pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Parameters, Say
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.jeffery import unbounded_ellipse
from fibermelt.fiber.near_field import near_field
from fibermelt.fiber.orbit import orbit
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.tumbling import tumble, turn_times
from fibermelt.paper.claims.printed import printed_period
from fibermelt.paper.orbits.quantities import QUANTITIES
from fibermelt.parts.melt.melt import newtonian_viscosity

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.fiber.cell_data import CellSolution
    from fibermelt.fiber.orbit import Orbit
    from fibermelt.fiber.response import FiberResponse

__all__ = ["Case", "orbit_cases", "orbits_stage"]

ORBIT_MODELS = ("confined-ellipse", "ellipse")
"""Ours in its cell, and Jeffery's."""

INSTANTS = 401
"""Instants of a turn: a peak of ``r_e`` = 10 is missed by 1e-3 of it at most."""

REACH, RINGS, RAYS = 2.5, 29, 192
"""Half-lengths around the fiber that Fig. 11 shows, and the net: eight rays to an element or so."""


class Case(NamedTuple):
    """A fiber in simple shear, and which sweep it belongs to."""

    sweep: str
    aspect_ratio: float
    shear_rate: float
    viscosity: float


def orbit_cases(parameters: Parameters) -> list[Case]:
    """Return the cases: the base first, then the sweeps, each with the base's other values."""
    ratio, viscosity = parameters["fiber.aspect_ratio"], newtonian_viscosity(parameters)
    rate = parameters["sensitivity.shear_rate"]
    return [
        Case("base", ratio, rate, viscosity),
        *(
            Case("aspect_ratio", value, rate, viscosity)
            for value in parameters["sensitivity.aspect_ratios"]
        ),
        *(
            Case("shear_rate", ratio, value, viscosity)
            for value in parameters["sensitivity.shear_rates"]
        ),
        *(Case("viscosity", ratio, rate, value) for value in parameters["sensitivity.viscosities"]),
    ]


def orbits_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Follow single fibers over a turn in simple shear, confined and unbounded.

    One cell is solved for each distinct aspect ratio; rate and viscosity only scale the answer.
    The paper's values of the viscosity (Fig. 13) are not in its text: a study chooses its own.
    """
    cases = orbit_cases(parameters)
    size = parameters["sensitivity.domain_size"]
    # no estimate: it would double the cost of cells whose error is 2e-5 (the tests measure it)
    numerics = CellNumerics(order=parameters["numerics.cell_order"], estimate=False)
    ratios = sorted({case.aspect_ratio for case in cases})
    cells, answers = {}, {}
    for ratio in ratios:
        fiber = Ellipse(parameters["fiber.half_length"], ratio)
        cells[ratio] = _solve(fiber.half_length, ratio, size, numerics)
        answers[ratio] = (cells[ratio].response, unbounded_ellipse(fiber))
        say(f"aspect ratio {ratio:g}: {cells[ratio].unknowns} unknowns")
    swept = tuple(parameters["sensitivity.aspect_ratios"])
    scale = newtonian_viscosity(parameters) * parameters["sensitivity.shear_rate"]
    turns = [[_turn(answer, case) for answer in answers[case.aspect_ratio]] for case in cases]
    near = [_around(cells[ratio], numerics, scale) for ratio in swept]
    return labelled(
        {
            "ratio": swept,
            "case_sweep": [case.sweep for case in cases],
            "case_aspect_ratio": [case.aspect_ratio for case in cases],
            "case_shear_rate": [case.shear_rate for case in cases],
            "case_viscosity": [case.viscosity for case in cases],
            "orbit_model": list(ORBIT_MODELS),
            "orbit_domain_size": size,
            **{name: [[one[name] for one in both] for both in turns] for name in turns[0][0]},
            **_printed(cases),
            **{name: [part[name] for part in near] for name in near[0]},
        },
        QUANTITIES,
    )


def _solve(half_length: float, ratio: float, size: float, numerics: CellNumerics) -> CellSolution:
    """Solve one cell."""
    from fibermelt.fiber.cell import solve_cell  # noqa: PLC0415  lazy: loads the finite elements

    return solve_cell(Ellipse(half_length, ratio), size, numerics)


def _turn(response: FiberResponse, case: Case) -> dict[str, Any]:
    """Return a fiber's exact extremes and its turn; of one that stalls, over Jeffery's period."""
    whole = orbit(response, case.shear_rate, case.viscosity)
    if whole.period is None:
        time = np.linspace(0.0, whole.period_jeffery, INSTANTS)
    else:
        time = turn_times(response.shape_factor, case.shear_rate, INSTANTS)
    turn = tumble(response, case.shear_rate, case.viscosity, time)
    angle, where = _lowest(response, whole)
    return {
        "orbit_shape_factor": whole.shape_factor,
        "orbit_period": np.nan if whole.period is None else whole.period,
        "orbit_lowest": whole.min_pressure,
        "orbit_highest": whole.max_pressure,
        "orbit_tip_lowest": whole.tip_min,
        "orbit_tip_highest": whole.tip_max,
        "orbit_angle_at_lowest": angle,
        "orbit_where_lowest": where,
        "turn_time": turn.time,
        "turn_angle": turn.angle,
        "turn_spin": turn.spin,
        "turn_lowest": turn.lowest,
        "turn_highest": turn.highest,
        "turn_tip": turn.tip,
    }


def _lowest(response: FiberResponse, whole: Orbit) -> tuple[float, float]:
    """Return the fiber's angle and the place of the lowest pressure [rad].

    A circle has it at every angle, on the side that is stretched: it is given the angle 0, where
    finite elements would break the tie at their error.
    """
    if response.aspect_ratio == 1.0:
        return 0.0, 0.25 * pi
    return whole.angle_at_min, whole.where_at_min


def _printed(cases: list[Case]) -> dict[str, Any]:
    """Return the paper's periods of the cases of its Table 1, NaN for others."""
    lines = [
        printed_period(case.aspect_ratio, case.shear_rate) if case.sweep != "viscosity" else None
        for case in cases
    ]
    return {
        "printed_period": [nan if line is None else line.finite_elements for line in lines],
        "printed_period_jeffery": [nan if line is None else line.jeffery for line in lines],
    }


def _around(cell: CellSolution, numerics: CellNumerics, scale: float) -> dict[str, Any]:
    """Return the pressure around a fiber at the angle with the lowest pressure, ``scale`` in Pa."""
    angle, _ = _lowest(cell.response, orbit(cell.response, 1.0, 1.0))
    strain = 0.5 * np.array([np.sin(2.0 * angle), np.cos(2.0 * angle)])
    near = near_field(cell, numerics, REACH, RINGS, RAYS)
    return {
        "near_angle": angle,
        "near_point": near.points,
        "near_pressure": scale * near.pressure @ strain,
    }
