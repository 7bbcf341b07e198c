"""The fiber stage against the paper's own algorithm, and the cell's cost."""

from __future__ import annotations

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import fibermelt as fm
from conftest import seconds
from fibermelt.fiber import CellNumerics, build_system, follow_newton
from fibermelt.flow.streamlines import Streamline

FIBER = fm.Ellipse(half_length=42e-6, aspect_ratio=6.0)
NEWTON_STEPS = 300
"""Steps of the paper's algorithm that are timed; the rest is scaled."""


def test_fiber_stage_against_the_papers_algorithm(
    benchmark: BenchmarkFixture, lines: tuple[Streamline, ...]
) -> None:
    """22 x 13 trajectories with extremes at every step; Newton-Raphson at every RK4 stage.

    The paper's algorithm runs on the paper's own mesh, its matrix factorised once by the fastest
    solver at hand.
    """
    path = fm.PathBundle([line.history for line in lines])
    middle = np.array([line.middle_time for line in lines])
    cell = fm.solve_cell(FIBER, domain_size=4.0)
    angles = fm.paper_angles()

    def stage() -> object:
        motion = fm.follow(path, cell.shape_factor, angles)
        pressure = fm.surface_pressure(path, cell.response, 817.0, motion)
        return fm.extremes(path, pressure, motion, middle), pressure.where_lowest

    benchmark(stage)
    steps = len(lines) * len(angles) * (len(lines[0].history) - 1)

    history = lines[9].history
    part = slice(0, NEWTON_STEPS + 1)
    short = fm.FlowHistory(
        history.time[part],
        history.position[part],
        history.velocity[part],
        history.gradient[part],
        history.pressure[part],
    )
    system = build_system(FIBER, 4.0, CellNumerics(mesh="paper"))
    took = seconds(lambda: follow_newton(system, FIBER, short, 817.0, 0.3))
    scaled = took / NEWTON_STEPS * steps
    ratio = scaled / benchmark.stats["median"]
    benchmark.extra_info |= {"unknowns": system.matrix.shape[0]}
    benchmark.extra_info |= {"steps": steps, "newton_scaled_s": scaled, "times_faster": ratio}
    print(f"\nfiber stage: {steps} steps, {ratio:,.0f} times faster than the paper's algorithm")


@pytest.mark.parametrize("estimate", [False, True])
def test_cell(benchmark: BenchmarkFixture, estimate: bool) -> None:
    """The cell's two solutions, without and with the error estimate."""
    numerics = CellNumerics(estimate=estimate)
    benchmark(lambda: fm.solve_cell(FIBER, 4.0, numerics))
