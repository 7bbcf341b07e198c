"""Sweeps: two workers against one, what a case costs besides its fibers, flows from neighbours.

Ratios, so that they mean the same on another machine; only a quiet one tells the truth.
"""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fibermelt.engine.parameters import flatten
from fibermelt.engine.stages import stage_parameters
from fibermelt.engine.store import Store
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import plan_sweep
from fibermelt.sweeps.runner import run_sweep

CASES = int(os.environ.get("BENCH_SWEEP_CASES", "600"))
"""Cases that need the fiber stages only; 10000 for the whole claim."""

FIBERS = f"""preset = "paper"
[fiber]
model = "ellipse"
[streamlines]
count = 3
points = 200
[numerics]
lip_edge = 0.05
contact_edge = 0.1
corner_edge = 0.2
surface_edge = 0.15
bulk_edge = 0.3
flow_tolerance = 1e-6
isotropic_angles = 20
[sweep]
"fiber.aspect_ratio" = {{ from = 2, to = 10, count = {CASES} }}
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return the study, and a folder that has its flow."""
    folder = tmp_path_factory.mktemp("sweep")
    study = folder / "swept.toml"
    study.write_text(FIBERS)
    one = load_study(str(study), [])
    first = replace(one, sweep={"fiber.aspect_ratio": [5.0]})
    run_sweep(read_sweep(first), first, folder / "out", CHAIN, workers=0)
    return study, folder / "out"


def cases_taken(swept: tuple[Path, Path], workers: int) -> float:
    """Return the time [s] of all cases, on workers that are warm."""
    study, out = swept
    for batch in out.glob("cases/batch-*"):
        batch.unlink()
    one = load_study(str(study))
    began: list[float] = []

    class Watch:
        def tick(self, stage: str, line: str) -> None:
            # The first line that counts cases is told when the workers are up.
            if " of " in line and not line.startswith("0 of "):
                began.append(time.perf_counter())

        def step(self, stage: str, line: str) -> None:
            pass

        done = step

    summary = run_sweep(read_sweep(one), one, out, CHAIN, workers=workers, observer=Watch())
    assert (summary["done"], summary["failed"]) == (CASES, 0)
    return time.perf_counter() - began[0]


def test_two_workers_against_one(benchmark: BenchmarkFixture, swept: tuple[Path, Path]) -> None:
    two = benchmark.pedantic(cases_taken, args=(swept, 2), rounds=1)
    one = cases_taken(swept, 1)
    benchmark.extra_info |= {"cases": CASES, "one_s": one, "two_s": two, "speedup": one / two}
    print(f"\n{CASES} cases: one worker {one:.1f} s, two {two:.1f} s: {one / two:.2f} times")


def test_overhead_of_a_case(benchmark: BenchmarkFixture, swept: tuple[Path, Path]) -> None:
    """The whole sweep on one worker, less the fiber stages alone in this process."""
    study, out = swept
    one = load_study(str(study))
    plan = plan_sweep(read_sweep(one), one, CHAIN)
    stages = {stage.name: stage for stage in CHAIN.stages}
    store = Store.open(out)
    record = store.find("streamlines", plan.cases[0].keys["streamlines"])
    assert record is not None
    lines = store.load(record)

    def fibers() -> None:
        for case in plan.cases[:50]:
            values = {**flatten(one.config), **case.changes}
            cell = stages["cell"].compute(stage_parameters(stages["cell"], values), {}, str)
            inputs = {"streamlines": lines, "cell": cell}
            stages["motion"].compute(stage_parameters(stages["motion"], values), inputs, str)

    fibers()
    benchmark.pedantic(fibers, rounds=3)
    alone = benchmark.stats["median"] / 50
    whole = cases_taken(swept, 0) / CASES
    benchmark.extra_info |= {"fibers_ms": alone * 1e3, "overhead_ms": (whole - alone) * 1e3}
    print(f"\na case: {alone * 1e3:.1f} ms of fibers, {(whole - alone) * 1e3:.1f} ms besides")


GAPS = """preset = "paper"
[fiber]
model = "ellipse"
[streamlines]
count = 3
points = 200
[sweep]
"flow.gap" = { from = "2.7 mm", to = "3.6 mm", count = 5 }
"""


def test_flows_from_neighbours(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """Five flows, the one in the middle from cold, against all from cold: their own times."""
    study = tmp_path / "gaps.toml"
    study.write_text(GAPS)
    one = load_study(str(study))

    def flows_took(name: str, *, cold: bool) -> list[float]:
        sweep, out = read_sweep(one, cold=cold), tmp_path / name
        run_sweep(sweep, one, out, CHAIN, workers=0)
        store, jobs = Store.open(out), plan_sweep(sweep, one, CHAIN).jobs.values()
        records = [store.find("flow", job.key) for job in jobs if job.stage == "flow"]
        costs = [record.cost for record in records if record is not None]
        assert len(costs) == 5
        return costs

    cold = flows_took("cold", cold=True)
    warm = benchmark.pedantic(flows_took, args=("warm",), kwargs={"cold": False}, rounds=1)
    benchmark.extra_info |= {"cold_s": cold, "warm_s": warm, "times_faster": sum(cold) / sum(warm)}
    print(f"\nflows: {sum(cold):.1f} s from cold, {sum(warm):.1f} s from one another")
