"""The flow from a neighbour's surfaces, the drawn-down melt, and the melt of another viscosity."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from fibermelt.engine.quantities import labelled
from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.flow.continuation import cold_surfaces
from fibermelt.flow.deposition import LARGEST_ERROR, FlowSolution, solve_deposition
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.search import SurfaceSearch, _chords_end
from fibermelt.flow.start import StartShape, surfaces_from
from fibermelt.melt import Newtonian
from fibermelt.parts.flow.stages import start_from
from fibermelt.study.quantities import QUANTITIES

pytestmark = pytest.mark.verification

COARSE = FlowNumerics().coarsened(4.0)
NEIGHBOURS = [
    {"gap": 3.6e-3},
    {"bed_speed": 0.122},
    {"inlet_speed": 25.2e-3},
]


def _problem(gap: float = 3e-3, **speeds: float) -> Deposition:
    return Deposition(Nozzle(gap=gap), Newtonian(817.0), **speeds)


@cache
def _cold(**change: float) -> FlowSolution:
    return solve_deposition(_problem(**change), COARSE)


def _shape(flow: FlowSolution) -> StartShape:
    return StartShape(flow.upstream_surface, flow.downstream_surface)


def _assert_same(warm: FlowSolution, cold: FlowSolution) -> None:
    for name in ("contact_point", "heel", "inlet_pressure"):
        moved = abs(getattr(warm, name) - getattr(cold, name))
        # two meshes can agree by luck, so the stated error of either is one to stay within
        stated = max(getattr(cold.error, name), getattr(warm.error, name))
        assert moved <= stated, name


@pytest.mark.parametrize("change", NEIGHBOURS, ids=str)
def test_answer_is_that_from_cold_both_ways(
    coarse_flow: FlowSolution, change: dict[str, float]
) -> None:
    lines: list[str] = []
    cold = _cold(**change)
    there = solve_deposition(_problem(**change), COARSE, lines.append, _shape(coarse_flow))
    back = solve_deposition(_problem(), COARSE, lines.append, _shape(there))
    _assert_same(there, cold)
    _assert_same(back, coarse_flow)
    assert not [line for line in lines if "from cold" in line]
    assert there.newton_steps < cold.newton_steps
    assert there.is_warm
    assert not cold.is_warm


def test_answer_does_not_depend_on_the_way(coarse_flow: FlowSolution) -> None:
    goal = _problem(gap=3.3e-3, bed_speed=0.107)
    ways = [_problem(gap=3.3e-3), _problem(bed_speed=0.107)]
    ends = []
    for way in ways:
        between = solve_deposition(way, COARSE, start=_shape(coarse_flow))
        ends.append(solve_deposition(goal, COARSE, start=_shape(between)))
    _assert_same(*ends)


def test_a_start_that_leads_nowhere_gives_the_answer_from_cold(coarse_flow: FlowSolution) -> None:
    up = coarse_flow.upstream_surface.copy()
    up[:, 0] += 8e-3 * (1 - up[:, 1] / up[0, 1]) ** 0.2
    lines: list[str] = []
    start = StartShape(up, coarse_flow.downstream_surface)
    flow = solve_deposition(_problem(), COARSE, lines.append, start)
    assert [line for line in lines if "from cold" in line]
    assert not flow.is_warm
    np.testing.assert_array_equal(flow.upstream_surface, coarse_flow.upstream_surface)


@pytest.mark.parametrize("change", NEIGHBOURS, ids=str)
def test_the_guess_is_most_of_the_way(coarse_flow: FlowSolution, change: dict[str, float]) -> None:
    """The upstream surface at equal parts of the gap [widths], and the bead over its length."""
    problem = _problem(**change)
    solved, width = _cold(**change), problem.nozzle.capillary_width
    guess = surfaces_from(_shape(coarse_flow), problem)
    part, along = np.linspace(0.02, 0.98, 25), np.linspace(0.6, 6.0, 25)

    def lines(upstream: np.ndarray, downstream: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        height = upstream[:, 1] / upstream[0, 1]
        return np.interp(-part, -height, upstream[:, 0]), np.interp(along, *downstream.T)

    there = lines(solved.upstream_surface / width, solved.downstream_surface / width)
    here = lines(coarse_flow.upstream_surface / width, coarse_flow.downstream_surface / width)
    guessed = lines(guess.upstream, guess.downstream)
    for k in range(2):
        # a third of the largest move is left at most: the fits are good to a tenth of theirs
        assert np.abs(guessed[k] - there[k]).max() < np.abs(here[k] - there[k]).max() / 3


def test_chord_steps_leave_less_than_the_tolerance(coarse_flow: FlowSolution) -> None:
    """Newton's next step is what they have left; the search takes it to be a quarter at most."""
    problem = _problem(bed_speed=0.122)
    search = SurfaceSearch(problem)
    guess = surfaces_from(_shape(coarse_flow), problem)
    flow, _ = search.converge(guess, COARSE, chords=True)
    assert flow.step().size < COARSE.flow_tolerance


@pytest.mark.parametrize("rate", [0.02, 0.3, 0.9])
def test_chord_steps_end_by_what_is_to_come(rate: float) -> None:
    steps = 1e-7 * rate ** np.arange(400)
    ends = [_chords_end(size, rate, 1e-7) for size in steps]
    first = ends.index(True)
    assert all(ends[first:])
    # the sum of all later steps, a quarter of the tolerance at most
    assert steps[first + 1 :].sum() < 0.25e-7
    assert first == 0 or steps[first:].sum() > 0.25e-7
    assert not _chords_end(1e-20, 1.0, 1e-7)


@pytest.mark.parametrize("outlet", [14e-3, 26e-3])
def test_surfaces_are_fitted_to_lips_bed_bead_and_outlet(
    coarse_flow: FlowSolution, outlet: float
) -> None:
    problem = Deposition(
        Nozzle(gap=3.4e-3, outlet=outlet, capillary_width=3e-3), Newtonian(817.0), bed_speed=0.11
    )
    fitted, width = surfaces_from(_shape(coarse_flow), problem), problem.nozzle.capillary_width
    np.testing.assert_allclose(fitted.upstream[0] * width, [-1.5e-3, 3.4e-3])
    np.testing.assert_allclose(fitted.downstream[0] * width, [1.5e-3, 3.4e-3])
    assert fitted.upstream[-1, 1] == 0.0
    end = fitted.downstream[-1] * width
    # the old bead is 5e-5 from its last height at the outlet
    np.testing.assert_allclose(end, [outlet, problem.mass_balance_height], rtol=1e-3)
    assert np.all(np.diff(fitted.downstream[:, 0]) > 0)


def test_a_start_must_be_the_surfaces_of_a_nozzle(coarse_flow: FlowSolution) -> None:
    up, down = coarse_flow.upstream_surface, coarse_flow.downstream_surface
    with pytest.raises(ConfigError, match=r"start\.upstream has shape"):
        StartShape(up[:3], down)
    with pytest.raises(ConfigError, match=r"start\.downstream has values that are not finite"):
        StartShape(up, down * np.nan)
    with pytest.raises(ConfigError, match="start begins at the lips"):
        StartShape(down, up)


def test_a_start_is_read_from_a_stored_flow(coarse_flow: FlowSolution) -> None:
    names = ("upstream_surface", "downstream_surface")
    start = start_from(labelled({name: getattr(coarse_flow, name) for name in names}, QUANTITIES))
    assert start.capillary_width == pytest.approx(3.175e-3, rel=1e-12)
    assert start.gap == pytest.approx(3e-3, rel=1e-12)
    assert start.bead_height == coarse_flow.bead_height


def test_a_wide_gap_is_reached_in_steps() -> None:
    """A gap of 2.33 bead heights, which a search from a guess loses through the outlet."""
    lines: list[str] = []
    flow = solve_deposition(_problem(gap=7e-3), COARSE, lines.append)
    assert [line for line in lines if "opening it in steps" in line]
    # found on a mesh four times as fine too: 6.150 mm
    assert abs(flow.contact_point - 6.150e-3) < 2 * flow.error.contact_point
    longer = Deposition(Nozzle(gap=7e-3, outlet=30e-3), Newtonian(817.0))
    assert solve_deposition(longer, COARSE, start=_shape(flow)).contact_point == pytest.approx(
        flow.contact_point, abs=2 * flow.error.contact_point
    )


@pytest.mark.slow
def test_a_melt_that_comes_down_flat_is_found_on_the_fine_mesh() -> None:
    """A gap of 2.67 bead heights: the coarse meshes on the way dip under the bed, the flow not."""
    problem = Deposition(Nozzle(gap=8e-3, outlet=40e-3), Newtonian(817.0))
    flow = solve_deposition(problem)
    assert flow.upstream_surface[:-1, 1].min() > 0.0
    # found on a mesh twice as fine too, from a neighbour: 9.504 mm
    bound = LARGEST_ERROR * problem.nozzle.capillary_width
    assert flow.contact_point == pytest.approx(9.504e-3, abs=bound)


@pytest.mark.slow
def test_a_gap_beyond_the_last_surface_is_told_its_widest() -> None:
    """As with half of that outlet: the contact at the widest gap is near 10 mm."""
    problem = Deposition(Nozzle(gap=9e-3, outlet=40e-3), Newtonian(817.0))
    with pytest.raises(
        ConvergenceError, match=r"up to 0\.0081 m at least; .*whatever flow\.outlet"
    ):
        cold_surfaces(SurfaceSearch(problem), None)


def test_a_surface_under_the_bed_is_none() -> None:
    with pytest.raises(ConvergenceError, match="under the bed"):
        solve_deposition(_problem(bed_speed=0.19), COARSE)


@pytest.mark.slow
def test_a_start_does_not_carry_past_the_last_steady_surface() -> None:
    last = solve_deposition(_problem(bed_speed=0.186), COARSE)
    with pytest.raises(ConvergenceError, match="under the bed"):
        solve_deposition(_problem(bed_speed=0.195), COARSE, start=_shape(last))
