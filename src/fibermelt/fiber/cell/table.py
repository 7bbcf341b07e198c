"""The table of a confined fiber's answers in a thinning melt, from its cells."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.fiber.cell.thinning import CellAnswer, ThinningCell, thinning_grid
from fibermelt.fiber.cell.worker import Task, solve_tasks
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.cell_surface import lagrange_matrix
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.thinning import KNOTS, ThinningResponse, odd_cosines, odd_sines, table_rates
from fibermelt.melt import PowerLaw, ViscosityLaw
from fibermelt.threads import exclusive

__all__ = ["THINNING_NUMERICS", "solve_thinning"]

Array = NDArray[np.float64]

THINNING_NUMERICS = CellNumerics(order=5)
"""How a thinning cell is solved: its grid is ten times sharper than a Newtonian one, and order 7
gains 3e-4 of the largest pressure there at twice the cost (n = 0.35, M = 4, r_e = 6)."""

PHASES = 13
"""Directions in a quarter turn: every 7.5 degrees."""

RATES_PER_DECADE = 2.7
"""Rates at which a law that bends is solved for, nine for a Carreau law: ``eta`` and its index
change over decades."""

PLATEAU = 1e-3
"""Lowest rate of a power law over that of its table: at 1e-2 its pressures differ by 1e-3 where
they are small, by 1e-4 where they are large (n = 0.35)."""

READINGS = 8
"""Points between two nodes on the surface at which an extreme is looked for, before a parabola."""

CUBIC_GAIN = 1.0 / 8.0
"""What is left of an interpolation error when the spacing is halved: a cubic's falls to a sixteenth
where all is smooth, and here, with corners between, by an order less."""

FINER = 2
"""Orders that the estimate of the elements' error takes more."""


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
        As in `solve_cell`. An unbounded fiber is one in a large cell: at ``M`` = 40 the pressure
        is within 0.4 % of the closed form for n = 1, nearer in a thinning melt, whose disturbance
        fades faster.
    law : ViscosityLaw
        The melt.
    numerics : CellNumerics, optional
        Order, spacings, pressure level; `THINNING_NUMERICS` if not given. With ``estimate`` two
        cells are solved once more, two orders higher, and the table is compared with one of half
        its points.
    rates : (2,) tuple of float, optional
        Lowest and highest ``gamma_dot`` [1/s] that will be asked for; all if not given. A power law
        has the same answer at every rate.
    phases : int
        Directions in a quarter turn, odd, at least 5.
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
    spin, pressure = _solved(fiber, domain_size, inner, numerics, nodes, phase, workers)
    grid = thinning_grid(fiber, domain_size, numerics)
    whole = _response(fiber, law, nodes, spin, pressure, grid, numerics.order)
    if not numerics.estimate:
        return whole
    between = _interpolation_error(whole, spin, pressure, grid, numerics.order)
    elements = _element_error(fiber, domain_size, inner, numerics, whole)
    turn, worst = (CUBIC_GAIN * one + two for one, two in zip(between, elements, strict=True))
    return replace(whole, spin_error=turn, pressure_error=worst)


def _cell_law(law: ViscosityLaw) -> ViscosityLaw:
    """Return the law that the cells of a table have: a power law with a plateau far below."""
    return PowerLaw(law.consistency, law.index, PLATEAU) if isinstance(law, PowerLaw) else law


def _solved(
    fiber: Ellipse,
    domain_size: float,
    law: ViscosityLaw,
    numerics: CellNumerics,
    rates: Array,
    phases: Array,
    workers: int | None,
) -> tuple[Array, Array]:
    """Return spins (r, f) and surface pressures (r, f, m) at all points of the table."""
    cores = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    shape = (rates.size, phases.size)
    count = min(cores if workers is None else max(1, workers), max(shape))
    owner = np.empty(shape, dtype=np.intp)
    if rates.size >= count:  # every count-th rate each, as the high ones take longer
        owner[:] = (np.arange(shape[0]) % count)[:, None]
    else:
        owner[:] = np.arange(shape[1]) * count // shape[1]
    lots = []
    for worker in range(count):
        found = np.argwhere(owner == worker)
        # to and fro, so that each point's neighbour is the one before
        back = np.where(np.cumsum(np.diff(found[:, 0], prepend=found[0, 0]) != 0) % 2 == 0, 1, -1)
        lots.append(found[np.lexsort((back * found[:, 1], found[:, 0]))])
    tasks = [
        Task(
            fiber,
            domain_size,
            law,
            numerics,
            tuple((float(rates[i]), float(phases[j])) for i, j in lot),
        )
        for lot in lots
    ]
    answers: dict[tuple[int, int], CellAnswer] = {}
    for lot, solved in zip(lots, solve_tasks(tasks), strict=True):
        answers |= {(int(i), int(j)): one for (i, j), one in zip(lot, solved, strict=True)}
    order = [[answers[i, j] for j in range(shape[1])] for i in range(shape[0])]
    spin = np.array([[one.spin for one in row] for row in order])
    return spin, np.array([[one.pressure for one in row] for row in order])


def _response(
    fiber: Ellipse,
    law: ViscosityLaw,
    rates: Array,
    spin: Array,
    pressure: Array,
    grid: CellGrid,
    order: int,
) -> ThinningResponse:
    """Return the table from spins (r, f) and surface pressures (r, f, m)."""
    fine = np.linspace(0.0, 0.5 * np.pi, KNOTS + 1)
    found = [surface_extremes(_between(surface, fine), grid, order) for surface in pressure]
    lowest, highest, where_lowest, where_highest, tip = map(np.stack, zip(*found, strict=True))
    return ThinningResponse(
        aspect_ratio=fiber.aspect_ratio,
        law=law,
        rate=rates,
        spin=odd_sines(spin),
        lowest=lowest,
        highest=highest,
        where_lowest=where_lowest,
        where_highest=where_highest,
        tip=tip,
        surface=surface_nodes(grid, order),
        pressure=pressure,
    )


def _between(surface: Array, phase: Array) -> Array:
    """Return surface pressures (f', m) at phases in a quarter turn from the table's (f, m)."""
    mirrored = np.roll(surface[:, ::-1], 1, axis=1)
    wave = 2 * np.arange(surface.shape[0] - 1) + 1
    even = odd_cosines((0.5 * (surface + mirrored)).T)
    odd = odd_sines((0.5 * (surface - mirrored)).T)
    turned = np.outer(phase, wave)
    return np.asarray(np.cos(turned) @ even.T + np.sin(turned) @ odd.T)


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


def _interpolation_error(
    whole: ThinningResponse, spin: Array, pressure: Array, grid: CellGrid, order: int
) -> tuple[float, float]:
    """Return how far the table of every second rate and direction is off, spin and extremes.

    Extremes over the largest pressure of their rate, at the points left out.
    """
    sparse = slice(None, None, 2)
    rates = whole.rate[sparse]
    half = _response(
        Ellipse(1.0, whole.aspect_ratio),
        whole.law,
        rates,
        spin[sparse, sparse],
        pressure[sparse, sparse],
        grid,
        order,
    )
    phase = np.linspace(0.0, 0.5 * np.pi, spin.shape[1])
    at, to = np.meshgrid(whole.rate, phase, indexing="ij")
    turn = float(np.max(np.abs(half.omega(at, to) - spin)))
    worst = 0.0
    for side in (0.0, np.pi):
        gap = np.abs(half.lowest_at(at, to + side) - whole.lowest_at(at, to + side))
        worst = max(worst, float(np.max(gap / whole.largest[:, None])))
    return turn, worst


def _element_error(
    fiber: Ellipse,
    domain_size: float,
    law: ViscosityLaw,
    numerics: CellNumerics,
    whole: ThinningResponse,
) -> tuple[float, float]:
    """Return how far spin and extremes are off, in two directions, from two orders higher."""
    finer = CellNumerics(
        order=numerics.order + FINER,
        angular_spacing=numerics.angular_spacing,
        radial_spacing=numerics.radial_spacing,
        pressure_reference=numerics.pressure_reference,
    )
    cell, rate = ThinningCell(fiber, domain_size, law, finer), float(whole.rate[-1])
    turn, worst = 0.0, 0.0
    for phase in (0.0, 0.25 * np.pi):
        answer = cell.answer(rate, phase)
        low, high, *_ = surface_extremes(answer.pressure[None], cell.grid, finer.order)
        found = [whole.lowest_at(rate, phase), -whole.lowest_at(rate, phase + np.pi)]
        gap = np.abs(np.array([low[0], high[0]]) - found)
        turn = max(turn, abs(answer.spin - float(whole.omega(rate, phase))))
        worst = max(worst, float(np.max(gap) / whole.largest[-1]))
    return turn, worst
