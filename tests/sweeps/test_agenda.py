"""What comes next in a sweep: nothing before what it needs, nothing twice, nothing forgotten."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.agenda import LARGEST_TASK, Agenda
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import Job, plan_sweep


def planned(*over):
    study = load_study("paper", ["study.parts=['bead']"], over)
    return plan_sweep(read_sweep(study), study, CHAIN)


GRID = planned("flow.gap=2.5 mm, 2.8 mm, 3.1 mm, 3.4 mm, 5 mm", "fiber.aspect_ratio=4, 6, 8")
"""Five flows, of which three start from one and one is out of reach; three cells; 15 cases."""


def needs(item):
    if isinstance(item, Job):
        return {*item.needs, *([item.neighbour] if item.neighbour else [])}
    return {item.keys[name] for name in item.kept}


def taken(agenda, dice, fails=()):
    """Return the keys of what is done, in order; some tasks come back late, and some fail."""
    order, flying = [], []
    while agenda.cases_left:
        while items := agenda.next(threads=2):
            flying.append(items)
        assert flying, "nothing to do, and something left"
        for item in flying.pop(dice.randrange(len(flying))):
            assert item.result_key not in order
            order.append(item.result_key)
            if item.result_key in fails:
                agenda.fail(item, item.result_key)
            else:
                agenda.learn(item, dice.uniform(0.01, 3))
                agenda.finish(item)
    return order


@given(st.integers(0, 10**6))
def test_everything_comes_once_and_after_what_it_needs(seed):
    agenda = Agenda(GRID, (), (), ())
    order = taken(agenda, random.Random(seed))
    assert sorted(order) == sorted([*GRID.jobs, *GRID.results()])
    place = {key: at for at, key in enumerate(order)}
    for item in (*GRID.jobs.values(), *GRID.cases):
        assert all(place[need] < place[item.result_key] for need in needs(item))
    assert agenda.done == set(GRID.results())
    assert all(there == count for there, count in agenda.stages().values())


@given(st.integers(0, 10**6), st.sampled_from(sorted(GRID.jobs)))
def test_what_needs_a_failure_fails_and_nothing_else(seed, failing):
    agenda = Agenda(GRID, (), (), ())
    taken(agenda, random.Random(seed), fails={failing})
    without = {failing}
    for key, job in GRID.jobs.items():  # inputs first
        if without & set(job.needs):
            without.add(key)
    lost = {case.result for case in GRID.cases if without & set(case.keys.values())}
    assert set(agenda.failed) == lost
    assert agenda.done == set(GRID.results()) - lost
    assert set(agenda.failed.values()) <= {failing}


@given(st.integers(0, 10**6), st.sets(st.sampled_from(sorted(GRID.results()))))
def test_what_is_there_is_not_done_again(seed, done):
    stored = {key for case in GRID.cases if case.result in done for key in case.keys.values()}
    agenda = Agenda(GRID, done, stored & set(GRID.jobs), ())
    order = taken(agenda, random.Random(seed))
    assert not (done | stored) & set(order)
    assert agenda.done == set(GRID.results())


def test_what_others_start_from_comes_first():
    agenda = Agenda(GRID, (), (), ())
    first = agenda.next(threads=2)
    parents = {job.neighbour for job in GRID.jobs.values()}
    assert [item.result_key in parents for item in first] == [True]


def test_known_failures_leave_out_their_cases_from_the_beginning():
    cell = next(job for job in GRID.jobs.values() if job.stage == "cell")
    agenda = Agenda(GRID, (), (), (cell.key,))
    assert (len(agenda.failed), agenda.cases_left) == (5, 10)
    assert agenda.stages()["cell"] == (0, 2)


def ready(count):
    """Return an agenda of cases that only wait for their fibers: all stages are there."""
    plan = planned(f"fiber.aspect_ratio={{from=2, to=9, count={count}}}", "fiber.model=ellipse")
    return Agenda(plan, (), set(plan.jobs), ())


@pytest.mark.parametrize(
    ("seconds", "size"), [(0.1, 10), (10.0, 1), (1e-6, LARGEST_TASK), (0.3, 3)]
)
def test_a_task_takes_about_a_second(seconds, size):
    agenda = ready(300)
    (first,) = agenda.next(threads=1)
    agenda.learn(first, seconds)
    assert len(agenda.next(threads=1)) == size


def test_the_last_tasks_are_shared_out():
    agenda = ready(9)
    (first,) = agenda.next(threads=2)
    agenda.learn(first, 1e-3)
    assert [len(agenda.next(threads=2)) for _ in range(6)] == [2, 2, 1, 1, 1, 1]


def test_those_that_killed_their_workers_come_one_by_one():
    agenda = ready(20)
    items = [agenda.next(threads=1)[0] for _ in range(3)]
    agenda.learn(items[0], 0.1)
    agenda.part(items)
    assert [agenda.next(threads=1) for _ in items] == [[item] for item in items]


def test_the_time_to_go_is_told_when_every_kind_is_known():
    agenda = Agenda(GRID, (), (), ())
    kinds = {job.kind for job in GRID.jobs.values()}
    assert kinds >= {"flow", "flow from a neighbour", "streamlines", "cell"}
    for job in {job.kind: job for job in GRID.jobs.values()}.values():
        assert agenda.seconds_left() is None
        agenda.learn(job, 2.0)
    agenda.learn(GRID.cases[0], 0.5)
    assert agenda.seconds_left() == pytest.approx(2.0 * len(GRID.jobs) + 0.5 * len(GRID.cases))
