"""The flow of a melt that thins, the table of a fiber in it, and fibers that follow it.

Each figure is a ratio of processor times measured in one run: of a flow over a Newtonian one, of
a table over the default cell of a Newtonian melt (two flows and the estimate), of the quantiles
over the paper's 13 fibers, of the fiber stage with a table over that with a Newtonian response (2.0
at n = 0.5). Where the time of a table goes: 40 % assembly of the tangent, 40 % its
factorisation; half a cell halves both, and Newton from the stress takes 2 to 5 steps, without a
neighbour, where it took 4 to 12 with one.
"""

from __future__ import annotations

import os
import resource
from collections.abc import Callable

import ngsolve as ng
import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import fibermelt as fm
from fibermelt.fiber import (
    FiberResponse,
    ThinningResponse,
    extremes,
    follow,
    isotropic_angles,
    isotropic_pressure,
    paper_angles,
    solve_cell,
    solve_thinning,
    surface_pressure,
)
from fibermelt.fiber.pressure import Viscosity
from fibermelt.flow.deposition import solve_deposition
from fibermelt.flow.problem import Deposition, Nozzle
from fibermelt.history import FlowHistory
from fibermelt.melt import CarreauYasuda, Newtonian, PowerLaw, ViscosityLaw

FIBER, CELL = fm.Ellipse(1.0, 6.0), 4.0


def spent(work: Callable[[], object]) -> float:
    """Return the processor time [s] of a call, that of its processes included."""

    def used() -> float:
        whose = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        usage = [resource.getrusage(who) for who in whose]
        return sum(one.ru_utime + one.ru_stime for one in usage)

    before = used()
    work()
    return used() - before


FLOWS = {
    "0.5, 1 s": CarreauYasuda(817.0, 0.5, 1.0),
    "0.35, 1 s": CarreauYasuda(817.0, 0.35, 1.0),
    "0.25, 0.01 s": CarreauYasuda(817.0, 0.25, 0.01),
    "0.25, 1 s": CarreauYasuda(817.0, 0.25, 1.0),
    "0.25, 10 s": CarreauYasuda(817.0, 0.25, 10.0),
    "power law 0.25": PowerLaw(25836.0, 0.25),
}
"""Index and time constant, the paper's viscosity at rest."""


def test_thinning_flow(benchmark: BenchmarkFixture) -> None:
    ng.SetNumThreads(1)

    def flow(law: ViscosityLaw) -> float:
        return spent(lambda: solve_deposition(Deposition(Nozzle(), law)))

    newtonian = [flow(Newtonian(817.0)) for _ in range(2)][1:]  # the first warms up
    for name, law in FLOWS.items():
        thinning = flow(law)
        newtonian.append(flow(Newtonian(817.0)))
        ratio = 2 * thinning / sum(newtonian[-2:])  # those before and after: machines change pace
        benchmark.extra_info[name] = ratio
        print(f"\n{name}: {ratio:.2f} Newtonian flows ({thinning:.1f} s)")
    benchmark.pedantic(lambda: flow(Newtonian(817.0)), rounds=1)
    ng.SetNumThreads(os.cpu_count())


@pytest.mark.parametrize(
    "law", [PowerLaw(8213.0, 0.5), CarreauYasuda(10390.0, 0.35, 0.5)], ids=["power", "carreau"]
)
def test_thinning_table(benchmark: BenchmarkFixture, law: ViscosityLaw) -> None:
    cell = min(spent(lambda: solve_cell(FIBER, CELL)) for _ in range(3))
    table = spent(lambda: solve_thinning(FIBER, CELL, law))
    print(f"\ntable: {table / cell:.0f} Newtonian cells ({table:.0f} s of processors)")
    benchmark.extra_info |= {"newtonian_cells": table / cell}
    benchmark.pedantic(lambda: solve_cell(FIBER, CELL), rounds=1)


def test_thinning_fibers(benchmark: BenchmarkFixture) -> None:
    law = PowerLaw(8213.0, 0.5)
    table, newtonian = solve_thinning(FIBER, CELL, law), solve_cell(FIBER, CELL).response
    t = np.linspace(0.0, 3.0, 1500)  # as many points as a bead's streamlines, and as much strain
    paths = []
    for strength in np.linspace(0.2, 1.0, 22):
        gradient = np.zeros((t.size, 2, 2))
        gradient[:, 0, 0] = 0.75 * strength * np.sin(3.0 * t)
        gradient[:, 1, 1] = -gradient[:, 0, 0]
        gradient[:, 0, 1] = 12.5 * strength * np.cos(t)
        zero = np.zeros((t.size, 2))
        paths.append(FlowHistory(t, zero, zero + 1.0, gradient, t))
    bundle = FlowHistory.stack(paths)

    def stage(
        response: FiberResponse | ThinningResponse, turns: float | ThinningResponse, melt: Viscosity
    ) -> None:
        for path, tolerance in ((bundle.every_second(), 1e-4), (bundle, 1e-8)):
            motion = follow(path, turns, paper_angles(), tolerance)
            extremes(path, surface_pressure(path, response, melt, motion), motion)
        isotropic_pressure(bundle, response, melt, None)

    whole = min(spent(lambda: stage(table, table, law)) for _ in range(3))
    linear = min(spent(lambda: stage(newtonian, newtonian.shape_factor, 817.0)) for _ in range(3))
    print(f"\nfiber stage: {whole / linear:.2f} of the Newtonian one's time ({whole:.2f} s)")
    benchmark.extra_info |= {"stage_over_newtonian": whole / linear, "stage": whole}
    few = spent(lambda: follow(bundle, table, paper_angles()))
    many = spent(lambda: follow(bundle, table, isotropic_angles(200)))
    print(f"\n200 fibers after 13: {many / few:.2f} of their time ({few:.2f} s)")
    benchmark.extra_info |= {"quantiles_over_fibers": many / few, "fibers": few}
    benchmark.pedantic(lambda: follow(bundle, table, paper_angles()), rounds=1)
