"""Run a sweep: keep the stages that cases share, compute the numbers of each, lose nothing.

The client hands out tasks of about a second each, few at a time whatever the number of cases; the
workers write what they find to the results folder, so that nothing is lost with any of them.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.engine.progress import Observer, Silent, duration
from fibermelt.engine.runner import software_versions
from fibermelt.engine.schema import has_lost_mark
from fibermelt.engine.stages import stage_parameters
from fibermelt.errors import StoreError
from fibermelt.sweeps.agenda import AHEAD, Agenda, Item
from fibermelt.sweeps.cluster import Died
from fibermelt.sweeps.plan import Job, Plan, plan_sweep
from fibermelt.sweeps.pools import Pool, open_pool, refuse_workers
from fibermelt.sweeps.progress import Progress, add_progress
from fibermelt.sweeps.record import asked
from fibermelt.sweeps.store import CaseStore, Failure, open_case_store, stage_folder
from fibermelt.sweeps.tasks import Folder, Outcome, Task

if TYPE_CHECKING:
    from pathlib import Path

    from fibermelt.engine.loading import Study
    from fibermelt.engine.parts import Chain
    from fibermelt.sweeps.design import Sweep

__all__ = ["run_sweep"]

TELL, NOTE = 0.5, 5.0
"""Times [s] between two lines of progress, and between two notes of it in the folder."""

BUSY_PAUSE = 0.2
"""Time [s] after which a client asks again for what another one is at."""


def run_sweep(
    sweep: Sweep,
    study: Study,
    directory: Path,
    chain: Chain,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    retry_failed: bool = False,
    observer: Observer | None = None,
) -> dict[str, Any]:
    """Run a sweep into a folder; what is there already is not computed again.

    Parameters
    ----------
    sweep : Sweep
        What varies.
    study : Study
        The study that holds it.
    directory : Path
        The results folder; made if need be. Several clients may run into one at once.
    chain : Chain
        The stages to go through.
    workers : int, optional
        Processes on this machine; as many as it has cores by default, 0 for this process only.
    scheduler : str, optional
        Address or file of a dask scheduler whose workers are used instead.
    retry_failed : bool
        Whether cases without an answer are tried again.
    observer : Observer, optional
        Who is told how it goes.

    Returns
    -------
    dict
        ``"cases"``; ``"done"`` and ``"failed"`` of them; ``"reused_stages"``: stages that were
        found in the folder; ``"wall_s"``: wall time [s].

    Raises
    ------
    ConfigError
        If a case is no valid study, or the workers are none.
    StoreError
        If the folder cannot be read or written, a full disk included: what was finished is kept.
    FibermeltError
        If the scheduler is gone.
    """
    began = time.perf_counter()
    observer = observer or Silent()
    refuse_workers(workers, scheduler)
    observer.step("sweep", _cases(sweep.count))
    plan = plan_sweep(sweep, study, chain)
    if has_lost_mark(directory):
        observer.done("store", "stages/store.json was missing or damaged: written anew")
    cases = open_case_store(directory)
    cases.write_sweep(asked(sweep, study, plan))
    cases.forget_failures(lasting=retry_failed)
    done = cases.refresh()
    for path in cases.discard_damaged():
        observer.done("store", f"{path.name} was damaged: its cases are computed anew")
    stored = {key for key, job in plan.jobs.items() if _is_stored(directory, job)}
    agenda = Agenda(plan, done, stored, cases.failures())
    work = _Run(plan, agenda, cases, observer, began, len(stored))
    if work.agenda.cases_left:
        folder = Folder(str(directory.resolve()), plan.base, chain)
        with open_pool(workers, scheduler, directory) as pool:
            work.through(pool, folder)
    summary = work.summary()
    work.note(summary["wall_s"])
    observer.done(
        "sweep", f"{summary['done']} of {_cases(summary['cases'])} done, {summary['failed']} failed"
    )
    return summary


def _is_stored(directory: Path, job: Job) -> bool:
    return stage_folder(directory, job.stage, job.key).is_dir()


class _Run:
    """One client's run through a plan: hands out tasks, takes note of what comes back, tells."""

    def __init__(
        self,
        plan: Plan,
        agenda: Agenda,
        cases: CaseStore,
        observer: Observer,
        began: float,
        reused: int,
    ) -> None:
        self.plan, self.agenda, self.cases, self.observer = plan, agenda, cases, observer
        self.began, self.reused = began, reused
        self.later: deque[tuple[float, Item]] = deque()
        self.flying = self.computed = 0
        self.seconds = self.processor = 0.0
        self.told = self.noted = 0.0

    def through(self, pool: Pool, folder: Folder) -> None:
        """Hand out tasks until nothing is left.

        Raises
        ------
        StoreError
            If the folder cannot be written or read any more.
        """
        while self.agenda.cases_left:
            self._return_busy()
            while self.flying < AHEAD * max(1, pool.threads()) and (
                items := self.agenda.next(pool.threads())
            ):
                pool.submit(self._task(folder, items))
                self.flying += 1
            finished = pool.next(BUSY_PAUSE)
            if finished is not None:
                self.flying -= 1
                self._take(*finished)
            self._tell(pool)

    def _return_busy(self) -> None:
        now = time.monotonic()
        while self.later and self.later[0][0] <= now:
            self.agenda.add(self.later.popleft()[1])

    def _task(self, folder: Folder, items: Sequence[Item]) -> Task:
        """Return the task of some items of one kind."""
        stage = items[0].stage if isinstance(items[0], Job) else ""
        cases = tuple(item.case if isinstance(item, Job) else item for item in items)
        return Task(folder, stage, cases, self.plan.starts(cases))

    def _items(self, task: Task) -> list[Item]:
        if not task.stage:
            return list(task.cases)
        return [self.plan.jobs[case.keys[task.stage]] for case in task.cases]

    def _take(self, task: Task, outcomes: list[Outcome] | Died) -> None:
        """Take note of what became of a task."""
        if isinstance(outcomes, Died):
            self._take_dead(task)
            return
        items = {item.result_key: item for item in self._items(task)}
        computed = [outcome.seconds for outcome in outcomes if outcome.state == "done"]
        if computed:
            self.agenda.learn(next(iter(items.values())), sum(computed) / len(computed))
        for outcome in outcomes:
            item = items[outcome.key]
            if outcome.state == "storage":
                raise StoreError(outcome.note)
            if outcome.note:
                self.observer.done("store", outcome.note)
            if outcome.state == "busy":
                self.later.append((time.monotonic() + BUSY_PAUSE, item))
            elif outcome.state == "failed":
                self.agenda.fail(item, outcome.failed)
            else:
                self.reused += outcome.state == "found" and bool(task.stage)
                self.agenda.finish(item)
            if outcome.state == "done" and not task.stage:
                self.computed += 1
                self.seconds += outcome.seconds
                self.processor += outcome.processor

    def _take_dead(self, task: Task) -> None:
        """Try each part of a task by itself that workers died of; give up one that is by itself."""
        items = self._items(task)
        if len(items) > 1:
            self.agenda.part(items)
            return
        (case,) = task.cases
        name = task.stage or list(case.keys)[-1]
        stage = next(stage for stage in task.folder.chain.stages if stage.name == name)
        failure = Failure(
            stage=name,
            key=case.keys[name],
            kind="KilledWorker",
            reason=f"stage {name}: its workers were killed, one after the other: too little "
            "memory? fibermelt resume tries it again",
            parameters=dict(stage_parameters(stage, {**self.plan.base, **case.changes})),
            lasting=False,
        )
        self.cases.write_failure(failure)
        self.agenda.fail(items[0], failure.key)

    def _tell(self, pool: Pool) -> None:
        now = time.perf_counter()
        if now - self.told > TELL:
            self.told = now
            self.observer.tick("sweep", self._how_far(pool.threads()))
        if now - self.noted > NOTE:
            self.noted = now
            self.note(now - self.began)

    def _how_far(self, threads: int) -> str:
        """Return how many cases there are, the stages of which some are to come, and how long."""
        agenda = self.agenda
        done, failed = len(agenda.done), len(agenda.failed)
        told = [f"{done} of {done + failed + agenda.cases_left} cases"]
        told += [f"{failed} failed"] if failed else []
        stages = agenda.stages().items()
        told += [f"{name} {there} of {count}" for name, (there, count) in stages if there < count]
        left = agenda.seconds_left()
        if threads == 0:
            told.append("waiting for workers")
        elif left is not None:
            told.append(f"about {duration(left / threads)} to go")
        return ", ".join(told)

    def note(self, wall: float) -> None:
        """Note in the folder how far this run is after a time [s], and what is new since then."""
        since = Progress(
            wall_s=wall,
            reused_stages=self.reused,
            cases=self.computed,
            cases_s=self.seconds,
            cases_processor_s=self.processor,
            software=software_versions() if self.computed else {},
        )
        add_progress(self.cases, since)
        self.computed, self.seconds, self.processor = 0, 0.0, 0.0

    def summary(self) -> dict[str, Any]:
        """Return what became of all cases, those that are alike counted one by one."""
        return {
            "cases": len(self.plan.cases),
            "done": sum(case.result in self.agenda.done for case in self.plan.cases),
            "failed": sum(case.result in self.agenda.failed for case in self.plan.cases),
            "reused_stages": self.reused,
            "wall_s": time.perf_counter() - self.began,
        }


def _cases(count: int) -> str:
    return f"{count} case{'' if count == 1 else 's'}"
