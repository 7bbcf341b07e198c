"""Cells solved by a process of their own: NGSolve is entered by one thread of a process at a time.

``python -m fibermelt.fiber.cell.worker`` takes a pickled `Task` from its input and gives the
answers, or the error, to its output. A plain child process: it does not run the caller's script
again, as those of multiprocessing do, and a worker of a cluster may start it.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from fibermelt.errors import ConvergenceError, FibermeltError
from fibermelt.fiber.cell.thinning import CellAnswer, ThinningCell
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.shape import Ellipse
from fibermelt.melt import ViscosityLaw

__all__ = ["Task", "solve_tasks"]


@dataclass(frozen=True)
class Task:
    """The points ``(rate [1/s], phase [rad])`` of one cell, in an order in which they are near.

    The points ``again`` are solved for with ``finer`` numerics, and come after the others.
    """

    fiber: Ellipse
    domain_size: float
    law: ViscosityLaw
    numerics: CellNumerics
    points: tuple[tuple[float, float], ...]
    finer: CellNumerics
    again: tuple[tuple[float, float], ...] = ()

    def solve(self) -> list[CellAnswer]:
        """Return the answers, each from the one before."""
        cell = ThinningCell(self.fiber, self.domain_size, self.law, self.numerics)
        answers = [cell.answer(*point) for point in self.points]
        if self.again:
            better = ThinningCell(self.fiber, self.domain_size, self.law, self.finer)
            for point in self.again:
                cell.answer(*point)
                answers.append(better.answer(*point, like=cell))
        return answers


def solve_tasks(tasks: Sequence[Task]) -> list[list[CellAnswer]]:
    """Return the answers of tasks side by side: the first here, each other in its own process.

    Raises
    ------
    FibermeltError
        The first error that a task met.
    ConvergenceError
        If a process ended without an answer.
    """
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    running = []
    try:
        for task in tasks[1:]:
            process = subprocess.Popen(
                [sys.executable, "-m", "fibermelt.fiber.cell.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=environment,
            )
            running.append(process)
            assert process.stdin is not None
            process.stdin.write(pickle.dumps(task))
            process.stdin.close()
        return [tasks[0].solve(), *(_answers(process) for process in running)]
    finally:
        for process in running:
            if process.poll() is None:
                process.kill()
            process.wait()
            if process.stdout is not None:
                process.stdout.close()


def _answers(process: subprocess.Popen[bytes]) -> list[CellAnswer]:
    """Return what a process found, or raise what it met."""
    assert process.stdout is not None
    told = process.stdout.read()
    if process.wait() != 0 or not told:
        msg = (
            f"fiber cell: a process that solves cells ended with code {process.returncode}: try "
            "workers = 1"
        )
        raise ConvergenceError(msg)
    found: list[CellAnswer] | FibermeltError = pickle.loads(told)
    if isinstance(found, FibermeltError):
        raise found
    return found


def _main() -> None:
    """Solve the task on the input; what libraries print goes to the standard error."""
    with os.fdopen(os.dup(1), "wb") as output:
        os.dup2(2, 1)
        task: Task = pickle.loads(sys.stdin.buffer.read())
        try:
            found: list[CellAnswer] | FibermeltError = task.solve()
        except FibermeltError as error:
            found = error
        output.write(pickle.dumps(found))


if __name__ == "__main__":
    _main()
