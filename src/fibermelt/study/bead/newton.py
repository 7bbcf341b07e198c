"""The fibers of a study by the paper's own algorithm: what it will cost, and how far it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from time import perf_counter
from typing import TYPE_CHECKING

from fibermelt.study.progress import duration
from fibermelt.study.stages import Say

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.fiber.cell_data import CellSystem
    from fibermelt.fiber.newton_motion import NewtonMotion
    from fibermelt.fiber.shape import Ellipse
    from fibermelt.history import FlowHistory

__all__ = ["SOLVES_PER_STEP", "newton_motions"]

SOLVES_PER_STEP = 8
"""Linear solves of a Runge-Kutta step: four stages, each a trial and its correction (Eq. 13-22)."""

SAMPLE = 3
"""Solves timed for the first estimate, before any streamline is done."""


def newton_motions(
    system: CellSystem,
    fiber: Ellipse,
    histories: Sequence[FlowHistory],
    viscosity: float,
    angles: NDArray[np.float64],
    say: Say,
    clock: Callable[[], float] = perf_counter,
) -> Iterator[NewtonMotion]:
    """Yield the fibers of one streamline after the other, and say how long the rest will take.

    Parameters
    ----------
    system : CellSystem
        The fiber's cell.
    fiber : Ellipse
        The fiber.
    histories : sequence of FlowHistory
        The streamlines; each interval of a streamline is one Runge-Kutta step.
    viscosity : float
        ``mu`` [Pa s].
    angles : (n_angles,) array
        Angles from the x axis at the inlet [rad].
    say : callable
        Takes a line before the first streamline, with the cost that a timed solve leads to, and
        one after each, with the time to go at the pace so far.
    clock : callable
        Seconds that only go up [s].

    Raises
    ------
    ConfigError, ConvergenceError
        As in `fibermelt.fiber.follow_newton`.
    """
    from fibermelt.fiber.newton_motion import follow_newton  # noqa: PLC0415  lazy, as the stages

    solves = SOLVES_PER_STEP * len(angles) * sum(len(one) for one in histories)
    guess = solves * _seconds_per_solve(system, clock)
    say(
        f"the paper's algorithm, {len(angles)} angles on {len(histories)} streamlines: up to "
        f"{solves} solves of {system.free.size} unknowns, about {duration(guess)}; "
        'fiber.path = "superposition" takes seconds'
    )
    start = clock()
    for done, history in enumerate(histories, 1):
        yield follow_newton(system, fiber, history, viscosity, angles)
        left = (clock() - start) / done * (len(histories) - done)
        to_go = f", about {duration(left)} to go" if done < len(histories) else ""
        say(f"streamline {done} of {len(histories)} done{to_go}")


def _seconds_per_solve(system: CellSystem, clock: Callable[[], float]) -> float:
    """Return the time of one linear solve [s]; the first, which warms the caches, is not timed."""
    import numpy as np  # noqa: PLC0415  lazy: see the stages

    load = np.ones(system.free.size)
    system.solve(load)
    start = clock()
    for _ in range(SAMPLE):
        system.solve(load)
    return (clock() - start) / SAMPLE
