"""Cells solved by a process of their own: NGSolve is entered by one thread of a process at a time.

``python -m fibermelt.fiber.cell.worker`` takes pickled `Task` values from its input and gives the
answers, or the error, to its output. A plain child process: it does not run the caller's script
again, as those of multiprocessing do, and a worker of a cluster may start it.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections import ChainMap
from collections.abc import Sequence
from dataclasses import dataclass, replace

from fibermelt.errors import ConvergenceError, FibermeltError
from fibermelt.fiber.cell.thinning import CellAnswer, ThinningCell
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.shape import Ellipse
from fibermelt.melt import ViscosityLaw

__all__ = ["Answers", "Point", "Task", "solve_tasks"]


Point = tuple[float, float]
"""A rate [1/s] and a phase [rad]."""

Answers = dict[Point, CellAnswer]


@dataclass(frozen=True)
class Task:
    """Points at which one cell is solved."""

    fiber: Ellipse
    domain_size: float
    law: ViscosityLaw
    numerics: CellNumerics
    points: tuple[Point, ...]

    def solve(self) -> Answers:
        """Return the answer at each point."""
        if not self.points:
            return {}
        cell = ThinningCell(self.fiber, self.domain_size, self.law, self.numerics)
        return {point: cell.answer(*point) for point in self.points}


def solve_tasks(tasks: Sequence[Task], workers: int) -> list[Answers]:
    """Return the answers of tasks, each shared out: to this process, and others side by side.

    Raises
    ------
    FibermeltError
        The first error that was met.
    ConvergenceError
        If a process ended without an answer.
    """
    count = max(1, min(workers, max(len(task.points) for task in tasks)))
    lots = [[replace(task, points=task.points[k::count]) for task in tasks] for k in range(count)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    running = []
    try:
        for lot in lots[1:]:
            process = subprocess.Popen(
                [sys.executable, "-m", "fibermelt.fiber.cell.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=environment,
            )
            running.append(process)
            assert process.stdin is not None
            process.stdin.write(pickle.dumps(lot))
            process.stdin.close()
        found = [[task.solve() for task in lots[0]], *(_answers(process) for process in running)]
    finally:
        for process in running:
            if process.poll() is None:
                process.kill()
            process.wait()
            if process.stdout is not None:
                process.stdout.close()
    return [dict(ChainMap(*parts)) for parts in zip(*found, strict=True)]


def _answers(process: subprocess.Popen[bytes]) -> list[Answers]:
    """Return what a process found, or raise what it met."""
    assert process.stdout is not None
    told = process.stdout.read()
    if process.wait() != 0 or not told:
        msg = (
            f"fiber cell: a process that solves cells ended with code {process.returncode}: try "
            "workers = 1"
        )
        raise ConvergenceError(msg)
    found: list[Answers] | FibermeltError = pickle.loads(told)
    if isinstance(found, FibermeltError):
        raise found
    return found


def _main() -> None:
    """Solve the tasks on the input; what libraries print goes to the standard error."""
    with os.fdopen(os.dup(1), "wb") as output:
        os.dup2(2, 1)
        tasks: list[Task] = pickle.loads(sys.stdin.buffer.read())
        try:
            found: list[Answers] | FibermeltError = [task.solve() for task in tasks]
        except FibermeltError as error:
            found = error
        output.write(pickle.dumps(found))


if __name__ == "__main__":
    _main()
