"""Orientation tensors along many histories against a loop over a library of single tensors."""

from __future__ import annotations

import fiberoripy.orientation as single
import numpy as np
import pytest
from fiberoripy.closures import compute_closure
from pytest_benchmark.fixture import BenchmarkFixture

from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.evolve import NODES, follow_orientation
from fibermelt.orientation.flows import FLOWS, strain_and_spin
from fibermelt.orientation.fokker_planck import steady_distribution
from fibermelt.orientation.models import FolgarTucker, shape_factor
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import isotropic
from timing import seconds

XI = shape_factor(6.0)
INTERACTION = 0.0128
STAGES = len(NODES) - 1
"""Rates per step: the last stage of a step is the first of the next."""

LOOP = 100
"""Rates of the loop that are timed."""


@pytest.mark.parametrize("lines", [22, 2000])
@pytest.mark.parametrize("name", ["hybrid", "ORF", "ORW3", "IBOF", "ORE", "exact"])
def test_along_many_histories(benchmark: BenchmarkFixture, name: str, lines: int) -> None:
    """22 streamlines, or 2000 tensors (a bead's section); Folgar-Tucker, a rate of the loop each.

    The library has no ORE and no exact closure: those are measured against its ORF.
    """
    points = 21
    rates = np.random.default_rng(0).uniform(0.5, 2.0, size=(lines, 1, 1, 1))
    L = rates * np.broadcast_to(FLOWS["mixed"], (lines, points, 3, 3))
    time = np.broadcast_to(np.linspace(0.0, 2.0, points), (lines, points))
    model, closure = FolgarTucker(XI, INTERACTION), CLOSURES[name]
    start = isotropic()
    found = follow_orientation(model, closure, (time, L), start, rtol=1e-6)

    benchmark.pedantic(
        lambda: follow_orientation(model, closure, (time, L), start, rtol=1e-6), rounds=3
    )
    theirs = name.upper() if name not in {"ORE", "exact"} else "ORF"
    a = found.a[0, points // 2]
    D, W = strain_and_spin(L[0, 0])

    def loop() -> None:
        for _ in range(LOOP):
            single.folgar_tucker_ode(a, compute_closure(a, theirs), D, W, XI, Ci=INTERACTION)

    of_loop = seconds(loop, 5) / LOOP * STAGES
    ours = benchmark.stats["min"] / (lines * (found.steps + found.rejected))
    benchmark.extra_info |= {"tensor_step_us": 1e6 * ours, "times_faster": of_loop / ours}
    print(f"\n{name}, {lines} tensors: {1e6 * ours:.1f} us per tensor-step, ", end="")
    print(f"{of_loop / ours:.0f} times faster than the loop")


@pytest.mark.parametrize("name", ["ORE", "exact"])
def test_steady_state(benchmark: BenchmarkFixture, name: str) -> None:
    """The paper's fiber in simple shear, continuation included."""
    model = FolgarTucker(XI, INTERACTION)
    benchmark(lambda: steady_state(model, FLOWS["simple-shear"], CLOSURES[name]))


@pytest.mark.parametrize("interaction", [1e-3, INTERACTION, 0.1])
def test_steady_distribution(benchmark: BenchmarkFixture, interaction: float) -> None:
    """The distribution itself in simple shear; at the paper's ``C_I`` it is asked within 0.1 s."""
    found = benchmark(lambda: steady_distribution(FLOWS["simple-shear"], XI, interaction))
    benchmark.extra_info |= {"degree": found.degree, "residual": found.residual}
