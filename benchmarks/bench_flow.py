"""The deposition flow from cold, and the die swell against its peer.

Where the processor time of the default flow goes (33,700 unknowns, one thread of a busy machine,
3.3 s in all): 0.5 s finds the surfaces on coarse meshes, 0.8 s solves the middle mesh for the
error estimate, 1.7 s the fine one (3 Newton steps: factorisation two thirds, assembly a quarter),
0.2 s recovers gradient, stream function and their error, 0.1 s makes the two meshes. Displacement
at full order on the surfaces alone took the unknowns from twice those of Stokes to 1.1 times;
quadrature of high order on curved elements alone, terms apart and compiled took assembly from two
thirds of a step to a quarter; unknowns inside elements, eliminated first, a third off the
factorisation.
"""

from __future__ import annotations

import json
import os
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import ngsolve as ng
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import fibermelt as fm
from fibermelt.flow.dieswell import solve_die_swell
from fibermelt.flow.start import StartShape
from fibermelt.melt import ViscosityLaw

SWELL = 1.18669
"""Limit of the P3 sequence at first order of the lip's edge; 1.1867 in the literature."""

ERROR = 3e-4
PEER = Path(__file__).parent / "peers"
PEER_PYTHON = Path(os.environ.get("FIBERMELT_PEER_PYTHON", PEER / ".venv" / "bin" / "python"))


def test_deposition_flow_from_cold(benchmark: BenchmarkFixture, problem: fm.Deposition) -> None:
    flow = benchmark.pedantic(lambda: fm.solve_deposition(problem), rounds=3, warmup_rounds=1)
    benchmark.extra_info |= {"unknowns": flow.unknowns, "newton_steps": flow.newton_steps}


NEIGHBOURS = (0.9, 1.05, 1.2)
"""Gap and bed speed of a neighbour over those of the flow that it starts from."""


def test_deposition_flow_from_a_neighbour(
    benchmark: BenchmarkFixture, problem: fm.Deposition
) -> None:
    """Warm against cold, each in processor time and one thread, best of two, over neighbours."""
    ng.SetNumThreads(1)
    solved = fm.solve_deposition(problem)
    start = StartShape(solved.upstream_surface, solved.downstream_surface)
    nozzle = problem.nozzle
    neighbours = [replace(problem, nozzle=replace(nozzle, gap=k * nozzle.gap)) for k in NEIGHBOURS]
    neighbours += [replace(problem, bed_speed=k * problem.bed_speed) for k in NEIGHBOURS]

    def cost(neighbour: fm.Deposition, shape: StartShape | None) -> float:
        times = []
        for _ in range(2):
            begun = time.process_time()
            fm.solve_deposition(neighbour, start=shape)
            times.append(time.process_time() - begun)
        return min(times)

    ratios, cold, warm = [], 0.0, 0.0
    for neighbour in neighbours:
        one, other = cost(neighbour, None), cost(neighbour, start)
        cold, warm = cold + one, warm + other
        ratios.append(round(one / other, 2))
    print(f"\nwarm start: {cold / warm:.2f} times faster than cold, each {ratios}")
    benchmark.extra_info |= {"times_faster_than_cold": cold / warm, "each": ratios}
    benchmark.pedantic(
        lambda: fm.solve_deposition(neighbours[1], start=start), rounds=2, warmup_rounds=0
    )
    ng.SetNumThreads(os.cpu_count())


THINNING = {
    "Carreau 0.5, 0.1 s": fm.CarreauYasuda(817.0, 0.5, 0.1),
    "Carreau 0.35, 1 s": fm.CarreauYasuda(817.0, 0.35, 1.0),
    "Carreau 0.25, 0.01 s": fm.CarreauYasuda(817.0, 0.25, 0.01),
    "Carreau 0.25, 10 s": fm.CarreauYasuda(817.0, 0.25, 10.0),
    "power law 0.25": fm.PowerLaw(25836.0, 0.25),
}


def test_thinning_flows_against_the_newtonian(
    benchmark: BenchmarkFixture, problem: fm.Deposition
) -> None:
    """From cold, in processor time and one thread, as multiples of the Newtonian flow."""
    ng.SetNumThreads(1)

    def cost(melt: ViscosityLaw) -> float:
        begun = time.process_time()
        fm.solve_deposition(replace(problem, melt=melt))
        return time.process_time() - begun

    newtonian = min(cost(problem.melt) for _ in range(3))
    ratios = {name: round(cost(law) / newtonian, 2) for name, law in THINNING.items()}
    print(f"\nthinning over Newtonian: {ratios}")
    benchmark.extra_info |= ratios
    benchmark.pedantic(
        lambda: fm.solve_deposition(replace(problem, melt=THINNING["Carreau 0.5, 0.1 s"])),
        rounds=1,
        warmup_rounds=0,
    )
    ng.SetNumThreads(os.cpu_count())


@pytest.mark.parametrize(
    ("order", "lip_edge", "bulk_edge"), [(2, 2.5e-4, 0.5), (3, 1e-3, 0.5)], ids=["P2", "P3"]
)
def test_die_swell(
    benchmark: BenchmarkFixture, order: int, lip_edge: float, bulk_edge: float
) -> None:
    """To an error of 3e-4, meshing included, one thread; beside it pyoomph, solves only."""
    threads = ng.SetNumThreads
    threads(1)
    result = benchmark.pedantic(
        lambda: solve_die_swell(lip_edge, order=order, bulk_edge=bulk_edge, growth=0.4),
        rounds=7,
        warmup_rounds=1,
    )
    threads(os.cpu_count())
    assert abs(result.swell - SWELL) < ERROR
    benchmark.extra_info |= {"swell": result.swell, "unknowns": result.unknowns}
    if not PEER_PYTHON.exists():
        print(f"\nno peer: {PEER / 'README.md'} says how to install it")
        return
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    for formulation in ("standard", "upwind"):
        script = [PEER_PYTHON, PEER / "die_swell_pyoomph.py", "--json"]
        command = [*map(str, script), "--formulation", formulation]
        runs = []
        for _ in range(3):
            printed = subprocess.run(
                command, env=environment, capture_output=True, text=True, check=True
            ).stdout
            runs.append(json.loads(printed.strip().splitlines()[-1]))
        peer = sorted(runs, key=lambda run: run["solve_s"])[1]
        ratio = peer["solve_s"] / benchmark.stats["median"]
        benchmark.extra_info[f"times_faster_than_pyoomph_{formulation}"] = ratio
        print(
            f"\ndie swell P{order} ({result.unknowns} unknowns, {result.swell:.5f}): "
            f"{ratio:.1f} times faster than pyoomph {formulation} "
            f"({peer['unknowns']} unknowns, {peer['swell']:.5f})"
        )
