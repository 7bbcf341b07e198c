"""What the benchmarks share: the paper's flow, solved once, and how a ratio is written down."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

import fibermelt as fm
from fibermelt.flow.streamlines import Streamline


@pytest.fixture(scope="session")
def problem() -> fm.Deposition:
    return fm.Deposition(fm.Nozzle(), fm.Newtonian(viscosity=817.0))


@pytest.fixture(scope="session")
def lines(problem: fm.Deposition) -> tuple[Streamline, ...]:
    return fm.trace_streamlines(fm.solve_deposition(problem))


def seconds(action: Callable[[], object], repeats: int = 1) -> float:
    """Return the median wall time of ``action`` [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return sorted(times)[len(times) // 2]
