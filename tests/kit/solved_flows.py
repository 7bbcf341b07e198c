"""Flows that several tests look at, solved once; tests of anything else load no finite elements."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from fibermelt.flow.deposition import FlowSolution
    from fibermelt.flow.problem import Deposition
    from fibermelt.flow.space.bead import BeadSolution
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
def coarse_bead() -> BeadSolution:
    """A bead in space on the coarsest mesh that Newton converges on: 25 s on a quiet core."""
    from round_bead import BEAD_COARSE, BEAD_PROBLEM  # noqa: PLC0415

    from fibermelt.flow.problem import BeadNumerics  # noqa: PLC0415
    from fibermelt.flow.space.bead import solve_bead  # noqa: PLC0415

    return solve_bead(BEAD_PROBLEM, BeadNumerics(**BEAD_COARSE))


@pytest.fixture(scope="session")
def paper_lines(paper_flow: FlowSolution) -> tuple[Streamline, ...]:
    from fibermelt.flow.streamlines import trace_streamlines  # noqa: PLC0415

    return trace_streamlines(paper_flow)
