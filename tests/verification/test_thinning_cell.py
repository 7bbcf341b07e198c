"""The confined ellipse in a thinning melt: limits, anchors, the table against direct solves."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.fiber import Ellipse
from fibermelt.fiber.cell.stokes import solve_modes
from fibermelt.fiber.cell.table import THINNING_NUMERICS, solve_thinning, surface_extremes
from fibermelt.fiber.cell.thinning import ThinningCell
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.melt import CarreauYasuda, Cross, Newtonian, PowerLaw, ViscosityLaw

FIBER, CELL = Ellipse(1.0, 6.0), 4.0
"""The paper's fiber in its cell."""

LAWS = (
    Newtonian(817.0),
    PowerLaw(8213.0, 0.5),
    CarreauYasuda(10390.0, 0.35, 0.5, infinite_viscosity=10.0),
    Cross(4628.0, 0.2694, 30820.0),
)

COARSE = CellNumerics(order=4, estimate=False)


def test_newtonian_is_the_linear_cell() -> None:
    cell = ThinningCell(FIBER, CELL, PowerLaw(3.0, 1.0), THINNING_NUMERICS)
    modes = solve_modes(cell.mesh)
    assert abs(cell.answer(5.0, 0.5 * np.pi).spin - modes.shape_factor) < 1e-8
    # the sum of the modes, read at the surface
    mapped, around, outward = cell.nodes
    linear = [np.asarray(mode.components[1](mapped)).ravel() for mode in modes.functions]
    phase = 0.7
    sum_of_modes = np.cos(phase) * linear[0] + np.sin(phase) * linear[1]
    surface = np.empty(cell.grid.columns * THINNING_NUMERICS.order)
    surface[around[outward == 0]] = sum_of_modes[outward == 0]
    answer = cell.answer(5.0, phase).pressure
    expected = surface.reshape(2, -1).mean(axis=0)
    shift = answer - expected  # the modes' level is not taken off
    assert np.ptp(shift) < 1e-8 * np.max(np.abs(answer))


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_along_the_stretch_the_spin_is_the_melts(law: ViscosityLaw) -> None:
    # in simple shear: at 45 degrees a fiber turns at half the rate
    answer = ThinningCell(FIBER, CELL, law, COARSE).answer(20.0, 0.0)
    assert abs(answer.spin) < 1e-8


def test_a_circle_turns_with_the_vorticity() -> None:
    cell = ThinningCell(Ellipse(1.0, 1.0), CELL, LAWS[1], COARSE)
    # the elements' error: nothing deforms at four points that no element's edge is at (3e-4 found)
    assert max(abs(cell.answer(1.0, phase).spin) for phase in (0.3, 1.1)) < 1e-3


@pytest.mark.parametrize(
    ("ratio", "domain", "index", "lowest"),
    [
        (6.0, 4.0, 0.8, -7.86),
        (6.0, 4.0, 0.7, -6.98),
        (6.0, 4.0, 0.35, -4.43),
        (6.0, 40.0, 0.8, -5.93),
        (6.0, 40.0, 0.35, -3.65),
        (3.0, 40.0, 0.8, -3.53),
    ],
)
def test_lowest_pressure_along_the_stretch(
    ratio: float, domain: float, index: float, lowest: float
) -> None:
    # another code's values, converged in their order
    cell = ThinningCell(Ellipse(1.0, ratio), domain, PowerLaw(1.0, index, 1e-3), THINNING_NUMERICS)
    found, *_ = surface_extremes(cell.answer(1.0, 0.0).pressure[None], cell.grid, 5)
    assert 0.5 * found[0] == pytest.approx(lowest, rel=0.01)


@pytest.mark.xfail(reason="the table is not within 5e-3 at every point yet", strict=False)
@pytest.mark.slow
def test_table_against_direct_solves() -> None:
    law = CarreauYasuda(10390.0, 0.35, 0.5)
    table = solve_thinning(FIBER, CELL, law)
    assert table.pressure_error < 0.01
    cell = ThinningCell(FIBER, CELL, law, THINNING_NUMERICS)
    rng = np.random.default_rng(5)
    for rate, phase in zip(
        10.0 ** rng.uniform(-2.0, 2.0, 12), rng.uniform(0.0, 0.5 * np.pi, 12), strict=True
    ):
        answer = cell.answer(rate, phase)
        low, high, *_ = surface_extremes(answer.pressure[None], cell.grid, 5)
        largest = float(np.interp(np.log(rate), np.log(table.rate), table.largest))
        assert abs(table.lowest_at(rate, phase) - low[0]) < 5e-3 * largest
        assert abs(table.lowest_at(rate, phase + np.pi) + high[0]) < 5e-3 * largest
        assert abs(table.omega(rate, phase) - answer.spin) < 1e-3
