"""Flows that several tests look at, solved once."""

from __future__ import annotations

import pytest

from fibermelt.flow.deposition import FlowSolution, solve_deposition
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.streamlines import Streamline, trace_streamlines
from fibermelt.melt import Newtonian

COARSE = FlowNumerics().coarsened(4.0)
"""Edges four times the default's: the same physics in a second or two."""


@pytest.fixture(scope="session")
def paper_problem() -> Deposition:
    return Deposition(Nozzle(), Newtonian(viscosity=817.0))


@pytest.fixture(scope="session")
def paper_flow(paper_problem: Deposition) -> FlowSolution:
    return solve_deposition(paper_problem)


@pytest.fixture(scope="session")
def coarse_flow(paper_problem: Deposition) -> FlowSolution:
    return solve_deposition(paper_problem, COARSE)


@pytest.fixture(scope="session")
def paper_lines(paper_flow: FlowSolution) -> tuple[Streamline, ...]:
    return trace_streamlines(paper_flow)
