"""The paper's study as a user runs it: from cold, and again with nothing changed."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

from pytest_benchmark.fixture import BenchmarkFixture

from timing import seconds


def test_paper_study(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    folder = tmp_path / "paper"
    command = [sys.executable, "-m", "fibermelt", "run", "paper", "--out", str(folder), "--json"]

    def run() -> None:
        subprocess.run(command, check=True, capture_output=True)

    benchmark.pedantic(run, rounds=1)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024
    repeat = seconds(run, repeats=3)
    ratio = benchmark.stats["median"] / repeat
    benchmark.extra_info |= {"peak_bytes": peak, "repeat_s": repeat, "cold_over_repeat": ratio}
    print(f"\npaper study: peak {peak / 1e9:.2f} GB; a repeat is {ratio:.0f} times faster")
