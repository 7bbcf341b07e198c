"""The surfaces of a melt that is drawn down, by continuation: the gap is opened in steps.

Where the gap is about two bead heights or more, a small change of the gap moves the contact point
far, and a search from a guess loses it. From a gap at which the search finds the surfaces, each
wider one is near enough to its neighbour for Newton.
"""

from __future__ import annotations

from dataclasses import replace

from fibermelt.errors import ConvergenceError, MeshError
from fibermelt.flow.mesh import Surfaces
from fibermelt.flow.problem import Deposition
from fibermelt.flow.search import (
    DRAWN_DOWN,
    UNDER_BED_COARSE,
    SurfaceSearch,
    UnderBedError,
    coarse_numerics,
)
from fibermelt.flow.start import StartShape, surfaces_from

__all__ = ["cold_surfaces"]

FIRST_RATIO = 1.4
"""Gap over bead height at which the melt is drawn down so little that the search finds it."""

RATIO_STEP = 0.2
"""Step of gap over bead height; halved where it fails."""

SMALLEST_RATIO_STEP = 0.04
"""A step cut below this has met the end of the steady surfaces, within 3 per cent of the gap."""

STEP_TOLERANCE = 1e-4
"""Last step of an intermediate problem [widths]: it only has to start the next."""


def cold_surfaces(search: SurfaceSearch, contact_guess: float | None) -> Surfaces:
    """Return the surfaces found on coarse meshes: by a search, else by opening the gap in steps.

    Raises
    ------
    ConvergenceError
        If neither finds any; for a melt that is drawn down it says up to which gap there are some.
    """
    problem = search.problem
    try:
        return search.find_surfaces(contact_guess)
    except ConvergenceError as reason:
        if problem.nozzle.gap <= max(DRAWN_DOWN, FIRST_RATIO) * problem.mass_balance_height:
            raise
        return _opened(search, reason)


def _at_ratio(problem: Deposition, ratio: float) -> Deposition:
    """Return the problem with a gap of ``ratio`` bead heights."""
    gap = ratio * problem.mass_balance_height
    return replace(problem, nozzle=replace(problem.nozzle, gap=gap))


def _opened(search: SurfaceSearch, failure: ConvergenceError) -> Surfaces:
    """Return the surfaces reached from a narrower gap, on one coarse mesh for each step."""
    target = search.problem
    goal = target.nozzle.gap / target.mass_balance_height
    width = target.nozzle.capillary_width
    search.tell(f"the search failed at a gap of {goal:.3g} bead heights: opening it in steps")
    ratio, step = FIRST_RATIO, RATIO_STEP
    first = search.towards(_at_ratio(target, ratio))
    try:
        surfaces = first.find_surfaces()
    except ConvergenceError:
        raise failure from None
    search.count(first)
    while ratio < goal:
        wider = min(goal, ratio + step)
        problem = target if wider == goal else _at_ratio(target, wider)
        inner = search.towards(problem)
        start = StartShape(surfaces.upstream * width, surfaces.downstream * width)
        numerics = replace(coarse_numerics(problem), flow_tolerance=STEP_TOLERANCE)
        try:
            _, surfaces = inner.converge(
                surfaces_from(start, problem), numerics, chords=True, under_bed=UNDER_BED_COARSE
            )
            ratio = wider
        except (ConvergenceError, MeshError) as reason:
            step /= 2
            if step < SMALLEST_RATIO_STEP or isinstance(reason, UnderBedError):
                widest = ratio * target.mass_balance_height
                raise _end_of_steady(target, widest, reason) from failure
        finally:
            search.count(inner)
    return surfaces


def _end_of_steady(problem: Deposition, gap: float, reason: Exception) -> ConvergenceError:
    """Return what to say of a gap that steps do not reach, the widest being ``gap`` [m]."""
    goal, height = problem.nozzle.gap, problem.mass_balance_height
    beyond = (
        "beyond, it would pass under the bed before it ends on it"
        if isinstance(reason, UnderBedError)
        else "beyond, it comes down so flat that its contact runs away from every step"
    )
    return ConvergenceError(
        f"deposition flow: no steady free surface found for flow.gap = {goal:g} m and a bead "
        f"{height:.4g} m high ({goal / height:.3g} bead heights): opened in steps from a narrower "
        f"one, the gap has an upstream surface up to {gap:.4g} m at least; {beyond}, whatever "
        f"flow.outlet; lower flow.gap to {gap:.4g} m or less, lower flow.bed_speed, or raise "
        "flow.inlet_speed"
    )
