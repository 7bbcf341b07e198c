"""The fibers of a study by the paper's own algorithm: what it will cost, and how far it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from fibermelt.engine.progress import duration
from fibermelt.engine.stages import Say
from fibermelt.fiber.newton_motion import follow_newton

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fibermelt.fiber.newton import FreeFiber
    from fibermelt.fiber.newton_motion import NewtonMotion
    from fibermelt.fiber.shape import Ellipse
    from fibermelt.history import FlowHistory

__all__ = ["SOLVES_PER_STEP", "newton_motions"]

SOLVES_PER_STEP = 8
"""Linear solves of a Runge-Kutta step: four stages, each a trial and its correction (Eq. 13-22)."""

SAMPLE_TURNS = (0.1, 0.2)
"""Angles [rad] that are timed for the first estimate, before any streamline is done."""


def newton_motions(
    free: FreeFiber,
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
    free : FreeFiber
        The fiber in its cell.
    fiber : Ellipse
        The fiber.
    histories : sequence of FlowHistory
        The streamlines; each interval of a streamline is one Runge-Kutta step.
    viscosity : float
        ``mu`` [Pa s], or 1 in a melt that thins.
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
    solves = SOLVES_PER_STEP * len(angles) * sum(len(one) for one in histories)
    seconds = _seconds_per_solve(free, histories[0], clock)
    say(
        f"the paper's algorithm, {len(angles)} angles on {len(histories)} streamlines: up to "
        f"{solves} solves of {free.unknowns} unknowns, about {duration(solves * seconds)}; "
        'fiber.path = "superposition" takes seconds'
    )
    start = clock()
    for done, history in enumerate(histories, 1):
        yield follow_newton(free, fiber, history, viscosity, angles)
        left = (clock() - start) / done * (len(histories) - done)
        to_go = f", about {duration(left)} to go" if done < len(histories) else ""
        say(f"streamline {done} of {len(histories)} done{to_go}")


def _seconds_per_solve(free: FreeFiber, history: FlowHistory, clock: Callable[[], float]) -> float:
    """Return the time of one linear solve [s]; the first ones, which warm caches, are not timed."""
    melt, rest = (
        np.array([*history.velocity[0, :2], *history.plane_gradient[0].ravel()]),
        np.zeros(3),
    )
    free.motion(1.0, melt, 0.0, rest)
    solves, start = free.solves, clock()
    for turn in SAMPLE_TURNS:
        free.motion(1.0, melt, turn, rest)
    return (clock() - start) / (free.solves - solves)
