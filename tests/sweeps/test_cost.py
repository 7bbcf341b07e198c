"""What the rest of a sweep will cost: sums and chains with known answers."""

import pytest
import xarray as xr

from fibermelt.engine.store import Record, Store
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.cost import estimate
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import plan_sweep
from fibermelt.sweeps.progress import Progress, write_progress
from fibermelt.sweeps.store import open_case_store

GAPS = """preset = "paper"
[study]
parts = ["bead"]
[sweep]
"flow.gap" = ["2.5 mm", "3 mm", "3.5 mm"]
"melt.viscosity" = ["400 Pa s", "817 Pa s"]
"""
"""Three gaps are solved, one from cold and two from it; the other melt's flows are scaled."""

FLOW, LINES, CELL, CASE = 30.0, 4.0, 2.0, 0.5
"""Times [s] of a flow from cold, its streamlines, the fiber's cell, and the numbers of a case."""


@pytest.fixture
def planned(tmp_path):
    """Return a sweep and a folder that has one of each stage, of another study."""
    (tmp_path / "swept.toml").write_text(GAPS)
    study, out = load_study(str(tmp_path / "swept.toml")), tmp_path / "out"
    store = Store.open(out)
    for stage, cost in (("flow", FLOW), ("streamlines", LINES), ("cell", CELL)):
        store.save(Record(stage, 1, "f" * 64, {}, {}, cost, "", {}), xr.Dataset())
    write_progress(open_case_store(out), Progress(cases=2, cases_s=2 * CASE))
    return plan_sweep(read_sweep(study), study, CHAIN), out


def test_all_of_it_by_one_worker(planned):
    """None of the folder started from a neighbour: a cold start stands for those that will."""
    plan, out = planned
    found = estimate(plan, out, plan.cases, workers=1)
    assert found.unknown == ()
    assert found.work == pytest.approx(3 * FLOW + 6 * LINES + CELL + 6 * CASE)
    assert found.wall == pytest.approx(found.work)


def test_what_waits_for_one_another_is_no_faster_with_more_workers(planned):
    """The flow in the middle, one that starts from it, its streamlines, the case."""
    plan, out = planned
    found = estimate(plan, out, plan.cases, workers=1000)
    assert found.wall == pytest.approx(2 * FLOW + LINES + CASE)


def test_nothing_is_left_of_a_finished_sweep(planned):
    plan, out = planned
    found = estimate(plan, out, [], workers=2)
    assert (found.work, found.wall, found.size, found.unknown) == (0.0, 0.0, 0, ())
