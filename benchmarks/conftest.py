"""What the benchmarks share: the paper's flow, solved once."""

from __future__ import annotations

import pytest

import fibermelt as fm
from fibermelt.flow.streamlines import Streamline


@pytest.fixture(scope="session")
def problem() -> fm.Deposition:
    return fm.Deposition(fm.Nozzle(), fm.Newtonian(viscosity=817.0))


@pytest.fixture(scope="session")
def lines(problem: fm.Deposition) -> tuple[Streamline, ...]:
    return fm.trace_streamlines(fm.solve_deposition(problem))
