"""Flows that several tests look at, solved once; tests of anything else load no finite elements."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from fibermelt.flow.deposition import FlowSolution
    from fibermelt.flow.problem import Deposition
    from fibermelt.flow.streamlines import Streamline


@pytest.fixture(scope="session")
def paper_problem() -> Deposition:
    from fibermelt.flow.problem import Deposition, Nozzle  # noqa: PLC0415
    from fibermelt.melt import Newtonian  # noqa: PLC0415

    return Deposition(Nozzle(), Newtonian(viscosity=817.0))


@pytest.fixture(scope="session")
def paper_flow(paper_problem: Deposition) -> FlowSolution:
    from fibermelt.flow.deposition import solve_deposition  # noqa: PLC0415

    return solve_deposition(paper_problem)


@pytest.fixture(scope="session")
def coarse_flow(paper_problem: Deposition) -> FlowSolution:
    """Edges four times the default's: the same physics in a second or two."""
    from fibermelt.flow.deposition import solve_deposition  # noqa: PLC0415
    from fibermelt.flow.problem import FlowNumerics  # noqa: PLC0415

    return solve_deposition(paper_problem, FlowNumerics().coarsened(4.0))


@pytest.fixture(scope="session")
def paper_lines(paper_flow: FlowSolution) -> tuple[Streamline, ...]:
    from fibermelt.flow.streamlines import trace_streamlines  # noqa: PLC0415

    return trace_streamlines(paper_flow)
