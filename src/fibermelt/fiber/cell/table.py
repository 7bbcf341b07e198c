"""The table of a confined fiber's answers in a thinning melt, from its cells."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.fiber.cell.thinning import THINNING_NUMERICS, thinning_grid
from fibermelt.fiber.cell.worker import Answers, Point, Task, solve_tasks
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.cell_surface import lagrange_matrix
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.thinning import ThinningResponse, bending_rates, table_rates
from fibermelt.melt import PowerLaw, ViscosityLaw
from fibermelt.threads import cores, exclusive

__all__ = ["solve_thinning"]

Array = NDArray[np.float64]

PHASES = 13
"""Directions in a quarter turn: every 7.5 degrees. Cubics between them are off by 5e-4 of the
largest pressure in the lowest and 2e-3 in the highest, most of it the elements' (n = 0.35, M = 4,
r_e = 6), by 6e-4 for r_e = 20 in a Newtonian melt. Harmonics of the pressure at each point of the
surface do not get below 6e-3, however many directions: it has a cusp where nothing deforms, which
moves along the surface."""

RATES_PER_DECADE = 4.0
"""Rates at which a law that bends is solved for: 14 for a Carreau law, between which cubics are off
by 1e-3 of the largest pressure (n = 0.35, M = 4, r_e = 6); nine leave 4e-3."""

PLATEAU = 1e-3
"""Lowest rate of a power law over that of its table: at 1e-2 its pressures differ by 1e-3 where
they are small, by 1e-4 where they are large (n = 0.35)."""

READINGS = 8
"""Points between two nodes on the surface at which an extreme is looked for, before a parabola."""

CHECKS = 4
"""Directions between those of a table of one rate that its estimate solves for."""

TARGET = 5e-3
"""Estimated error of a table's extremes, over the largest pressure, beyond which it takes more
directions, or rates, where they are missed. r_e = 6 needs none; at 20 the lowest pressure moves
from flank to tip within the last 8 degrees, and is off by 6e-3 there (n = 0.35, M = 4)."""

MOST_ROUNDS = 4
"""How often, each halving what lies between."""

BEYOND = 3.0
"""How far beyond its first and last rate, where it holds their answers, a table is compared."""

FINER = 2
"""Orders that the estimate of the elements' error takes more."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Part of a quarter turn between the directions of the estimate at one rate and at the next."""


@exclusive
def solve_thinning(
    fiber: Ellipse,
    domain_size: float,
    law: ViscosityLaw,
    numerics: CellNumerics | None = None,
    rates: tuple[float, float] | None = None,
    phases: int = PHASES,
    workers: int | None = None,
) -> ThinningResponse:
    """Return the answers of a confined fiber to every strain in a thinning melt.

    Parameters
    ----------
    fiber, domain_size
        As in `solve_cell`. An unbounded fiber is one in a large cell: of the closed form for n = 1
        the pressure is 1.0 % of the largest off at ``M`` = 40 for a circle, 0.45 % for ``r_e`` = 3,
        0.34 % for 6, a sixteenth of it at 160; less in a thinning melt, whose disturbance fades
        faster.
    law : ViscosityLaw
        The melt.
    numerics : CellNumerics, optional
        Order, spacings, pressure level; `THINNING_NUMERICS` if not given. With ``estimate`` the
        table is compared with cells solved in the middle between its points, one at each rate, and
        beyond its rates, and with cells two orders higher; where it misses them by more than
        `TARGET` it takes more points.
    rates : (2,) tuple of float, optional
        Lowest and highest ``gamma_dot`` [1/s] that will be asked for, or one rate twice; all if not
        given. A power law has the same answer at every rate.
    phases : int
        Directions in a quarter turn, evenly spread, odd, at least 5; more where they are needed.
    workers : int, optional
        Processes, this one included; one a core if not given.

    Raises
    ------
    ConfigError
        If the fiber does not fit into its cell, or a number is out of its range.
    ConvergenceError
        If a cell does not converge.
    """
    numerics = THINNING_NUMERICS if numerics is None else numerics
    if phases < 5 or phases % 2 == 0:
        msg = f"phases = {phases}: must be odd and at least 5, e.g. {PHASES}"
        raise ConfigError(msg)
    nodes, inner = table_rates(law, rates, RATES_PER_DECADE), _cell_law(law)
    phase = np.linspace(0.0, 0.5 * np.pi, phases)
    between, again = _checks(law, nodes, phase) if numerics.estimate else ([], [])
    grid = thinning_grid(fiber, domain_size, numerics)
    cells = Task(fiber, domain_size, inner, numerics, (*_points(nodes, phase), *between))
    finer = replace(numerics, order=numerics.order + FINER)
    tasks = [cells, replace(cells, numerics=finer, points=tuple(again))]
    known, fine = solve_tasks(tasks, _processes(workers))
    left = MOST_ROUNDS
    while True:
        table = _response(fiber, law, (nodes, phase), known, grid, numerics.order, phases)
        if not numerics.estimate:
            return table
        elements = _errors(table, fine, grid, finer.order).max(axis=0)
        missed = _errors(table, {point: known[point] for point in between}, grid, numerics.order)
        turn, worst = missed.max(axis=0) + elements
        table = replace(table, spin_error=float(turn), pressure_error=float(worst))
        allowed = max(TARGET - float(elements[1]), 0.25 * TARGET)
        coarse = [at for at, error in zip(between, missed[:, 1], strict=True) if error > allowed]
        if worst <= TARGET or not coarse or not left:
            return table
        nodes, phase, more = _refined(nodes, phase, coarse)
        between += more
        new = [at for at in dict.fromkeys((*_points(nodes, phase), *more)) if at not in known]
        known |= solve_tasks([replace(cells, points=tuple(new))], _processes(workers))[0]
        left -= 1


def _points(rates: Array, phases: Array) -> list[Point]:
    """Return the points of a table of rates [1/s] and phases [rad]."""
    return [(rate, phase) for rate in rates.tolist() for phase in phases.tolist()]


def _refined(rates: Array, phases: Array, coarse: list[Point]) -> tuple[Array, Array, list[Point]]:
    """Return rates and phases of a table with those of points that it misses, and where to look.

    A point between two phases of the table makes its own one of them, to be looked at again at both
    sides; what is missed at a phase of the table is between its rates.
    """
    new_rates, new_phases, more = set(rates.tolist()), set(phases.tolist()), []
    for rate, phase in coarse:
        if phase in new_phases and rate not in new_rates:
            new_rates.add(rate)
        elif phase not in new_phases:
            after = int(np.searchsorted(phases, phase))
            new_phases.add(phase)
            more += [(rate, float(0.5 * (phase + phases[after - k]))) for k in (1, 0)]
    return np.array(sorted(new_rates)), np.array(sorted(new_phases)), more


def _cell_law(law: ViscosityLaw) -> ViscosityLaw:
    """Return the law that the cells of a table have: a power law with a plateau far below."""
    return PowerLaw(law.consistency, law.index, PLATEAU) if isinstance(law, PowerLaw) else law


def _checks(law: ViscosityLaw, rates: Array, phases: Array) -> tuple[list[Point], list[Point]]:
    """Return the points beside those of a table that it is compared at, and some of its own."""
    middle = 0.5 * (phases[1:] + phases[:-1])
    if rates.size == 1:
        chosen = np.unique(np.rint(np.linspace(0, middle.size - 1, CHECKS)).astype(np.intp))
        between = [(float(rates[0]), float(phase)) for phase in middle[chosen]]
    else:
        part = np.mod(GOLDEN * np.arange(rates.size - 1), 1.0)
        chosen = (part * middle.size).astype(np.intp)
        between = [
            (float(rate), float(phase))
            for rate, phase in zip(np.sqrt(rates[1:] * rates[:-1]), middle[chosen], strict=True)
        ]
        low, high = bending_rates(law)
        ends = [
            (rates[0] / BEYOND, rates[0] <= low * (1 + 1e-9)),
            (rates[-1] * BEYOND, rates[-1] >= high * (1 - 1e-9)),
        ]
        half = float(middle[middle.size // 2])
        between += [(float(rate), half) for rate, is_held in ends if is_held]
    steepest = float(rates[np.argmin(law.index_at(rates))])
    return between, [(steepest, float(phases[k])) for k in (0, phases.size // 2, -1)]


def _processes(workers: int | None) -> int:
    """Return the number of processes that solve cells: one a core if not given."""
    return cores() if workers is None else max(1, workers)


def _response(
    fiber: Ellipse,
    law: ViscosityLaw,
    nodes: tuple[Array, Array],
    known: Answers,
    grid: CellGrid,
    order: int,
    even: int,
) -> ThinningResponse:
    """Return the table from the answers at its rates and phases, of which ``even`` are even."""
    rates, phases = nodes
    answers = [[known[rate, phase] for phase in phases.tolist()] for rate in rates.tolist()]
    spread = np.searchsorted(phases, np.linspace(0.0, 0.5 * np.pi, even))
    pressure = np.array([[one.pressure for one in row] for row in answers])
    found = [surface_extremes(surface, grid, order) for surface in pressure]
    lowest, highest, where_lowest, where_highest, tip = map(np.stack, zip(*found, strict=True))
    table = ThinningResponse.from_extremes(
        fiber.aspect_ratio,
        law,
        rates,
        np.array([[one.spin for one in row] for row in answers])[:, spread],
        lowest,
        highest,
        tip,
        where=(phases, where_lowest, where_highest),
    )
    return replace(table, surface=surface_nodes(grid, order), pressure=pressure[:, spread])


def surface_nodes(grid: CellGrid, order: int) -> Array:
    """Return the eccentric angles of the surface nodes in [0, pi) [rad]."""
    return _angles(grid, np.arange(grid.columns * order // 2) / order)


def _angles(grid: CellGrid, column: Array) -> Array:
    """Return eccentric angles [rad] at column coordinates in [0, columns/2)."""
    tip = grid.nearest_tip(np.floor(column).astype(np.intp))
    return np.asarray(grid.eccentric_angle(tip, column / grid.columns_per_quarter))


def surface_extremes(
    pressure: Array, grid: CellGrid, order: int
) -> tuple[Array, Array, Array, Array, Array]:
    """Return lowest, highest pressure, their eccentric angles [rad], the tip's, from (k, m)."""
    count = pressure.shape[1] * READINGS
    column = np.arange(count) / (READINGS * order)
    angles = _angles(grid, column)
    nodes, weights = lagrange_matrix(grid, order, np.mod(angles, 2.0 * np.pi))
    read = np.zeros((pressure.shape[1], count))
    np.add.at(read, (nodes % pressure.shape[1], np.arange(count)[:, None]), weights)
    values = pressure @ read
    rows = np.arange(len(values))
    found, places = [], []
    for sign in (-1.0, 1.0):
        at = np.argmax(sign * values, axis=1)
        before, top, after = (values[rows, (at + k) % count] for k in (-1, 0, 1))
        bend = before - 2.0 * top + after
        shift = np.where(
            bend != 0.0, 0.5 * (before - after) / np.where(bend != 0.0, bend, 1.0), 0.0
        )
        shift = np.clip(shift, -0.5, 0.5)
        found.append(top + 0.25 * (after - before) * shift)
        places.append(fold_angle(_angles(grid, np.mod(at + shift, count) / (READINGS * order))))
    return found[0], found[1], places[0], places[1], pressure[:, 0]


def _errors(table: ThinningResponse, answers: Answers, grid: CellGrid, order: int) -> Array:
    """Return how far a table is off answers (k, 2): spin, and extremes over the largest."""
    errors = []
    for (rate, phase), answer in answers.items():
        low, high, *_ = surface_extremes(answer.pressure[None], grid, order)
        found = [table.lowest_at(rate, phase), -table.lowest_at(rate, phase + np.pi)]
        gap = np.abs(np.array([low[0], high[0]]) - found)
        turn = abs(answer.spin - float(table.omega(rate, phase)))
        errors.append((turn, float(np.max(gap) / -table.bounds(rate)[0])))
    return np.array(errors)
