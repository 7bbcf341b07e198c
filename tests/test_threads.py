"""NGSolve is entered by one thread of a process at a time, and threads get what one gets alone."""

import subprocess
import sys
from dataclasses import replace
from threading import Thread

import ngsolve as ng
import numpy as np
import pytest
from patience import PATIENCE

import fibermelt as fm
from fibermelt import threads
from fibermelt.fiber.cell import build_system, solve, solve_cell
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.flow.dieswell import solve_die_swell, swell_problem
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.search import COARSE

pytestmark = pytest.mark.verification

FIBER = fm.Ellipse(1.0, 3.0)
ROUGH = CellNumerics(order=3, estimate=False)
PAPER = fm.Deposition(fm.Nozzle(), fm.Newtonian(817.0))


def _free_surface():
    flow = FreeSurfaceFlow(*swell_problem(0.05), 2)
    flow.step()
    flow.surface("free", np.array([0.0, 1.0]))
    flow.kinematic_residual()


ENTRIES = {
    "cell": lambda: solve_cell(FIBER, 4.0, ROUGH),
    "system": lambda: build_system(FIBER, 4.0, ROUGH),
    "deposition": lambda: fm.solve_deposition(PAPER, COARSE),
    "die swell": lambda: solve_die_swell(0.05, order=2),
    "free surface": _free_surface,
}


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_who_uses_the_finite_elements_holds_the_lock(entry, monkeypatch):
    used = []

    def watched(name, make):
        def made(*args, **kwargs):
            used.append((name, threads._INSIDE._is_owned()))
            return make(*args, **kwargs)

        return made

    for name in ("CF", "GridFunction", "Integrate", "IntegrationRule", "Mesh"):
        monkeypatch.setattr(ng, name, watched(name, getattr(ng, name)))
    entry()
    assert used
    assert {name for name, is_held in used if not is_held} == set()


def test_the_solver_of_a_system_waits_for_its_turn():
    """It is a function of the result: whoever has it enters long after the system was built."""
    system = build_system(FIBER, 4.0, ROUGH)
    load, answers = np.ones(system.free.size), []
    other = Thread(target=lambda: answers.append(system.solve(load)))
    with threads._INSIDE:
        other.start()
        other.join(0.3)
        assert answers == []
    other.join(PATIENCE)
    np.testing.assert_array_equal(answers[0], system.solve(load))


def test_a_thread_enters_from_within_an_entry():
    """Such as by the line of progress of a flow."""
    cells = []

    def progress(line):
        if not cells:
            cells.append(solve_cell(FIBER, 4.0, ROUGH).shape_factor)

    fm.solve_deposition(PAPER, COARSE, progress)
    assert cells == [pytest.approx(solve_cell(FIBER, 4.0, ROUGH).shape_factor, abs=1e-12)]


IN_THREADS = """
from concurrent.futures import ThreadPoolExecutor
import fibermelt as fm
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.flow.search import COARSE

def cell(aspect_ratio):
    rough = CellNumerics(order=4, estimate=False)
    return fm.solve_cell(fm.Ellipse(1.0, aspect_ratio), 4.0, rough).shape_factor

def flow(gap):
    problem = fm.Deposition(fm.Nozzle(gap=gap), fm.Newtonian(817.0))
    return fm.solve_deposition(problem, COARSE).inlet_pressure

work = [(cell, 3.0), (flow, 3e-3), (cell, 6.0), (cell, 4.0), (cell, 5.0)] * 2
with ThreadPoolExecutor(3) as pool:
    there = [pool.submit(*one) for one in work]
    found = [one.result() for one in there]
alone = [function(value) for function, value in work]
worst = max(abs(one / other - 1.0) for one, other in zip(found, alone))
# Solved on several threads, the last bits of a flow's mesh may differ: Newton's tolerance is 1e-7.
assert worst < 1e-6, worst
"""


def test_threads_get_what_one_gets_alone():
    """In a process of its own, which without the lock is killed more often than it is wrong."""
    command = [sys.executable, "-c", IN_THREADS]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_cell_that_lost_its_symmetry_is_no_answer(monkeypatch):
    """What gets between two halves of a solve has no mirror image, and need leave no residual."""
    modes = solve.solve_modes
    monkeypatch.setattr(solve, "solve_modes", lambda mesh: replace(modes(mesh), handedness=-2e-6))
    with pytest.raises(fm.ConvergenceError, match=r"spins at -2\.0e-06"):
        solve_cell(FIBER, 4.0, ROUGH)
