"""Run a sweep: keep the stages that cases share, compute the numbers of each, lose nothing.

The client hands out tasks of about a second each, few at a time whatever the number of cases; the
workers write what they find to the results folder, so that nothing is lost with any of them.
"""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from fibermelt.errors import StoreError
from fibermelt.study.progress import Observer, Silent, duration
from fibermelt.study.runner import software_versions
from fibermelt.study.stages import stage_parameters
from fibermelt.study.sweep.cost import Progress, read_progress, write_progress
from fibermelt.study.sweep.plan import Job, Plan, PlannedCase, plan_sweep
from fibermelt.study.sweep.pools import Died, Pool, open_pool
from fibermelt.study.sweep.record import asked
from fibermelt.study.sweep.store import CaseStore, Failure, open_case_store, stage_folder
from fibermelt.study.sweep.tasks import Folder, Outcome, Task

if TYPE_CHECKING:
    from pathlib import Path

    from fibermelt.study.loading import Study
    from fibermelt.study.parts import Chain
    from fibermelt.study.sweep.design import Sweep

__all__ = ["run_sweep"]

TASK_SECONDS = 1.0
"""What a task should take [s]: long against the millisecond that dask spends on each."""

LARGEST_TASK = 64
"""Cases of a task, at most: what a killed worker loses, and open locks."""

AHEAD = 2
"""Tasks for each thread that are with the scheduler: one works, one waits."""

TELL, NOTE = 0.5, 5.0
"""Times [s] between two lines of progress, and between two notes of it in the folder."""

BUSY_PAUSE = 0.2
"""Time [s] after which a client asks again for what another one is at."""

MEMORY = 0.3
"""Weight of the last task in the mean time of its kind."""


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
        If a case is no valid study.
    StoreError
        If the folder cannot be read or written, a full disk included: what was finished is kept.
    FibermeltError
        If the scheduler is gone.
    """
    began = time.perf_counter()
    observer = observer or Silent()
    observer.step("sweep", f"{sweep.count} cases")
    plan = plan_sweep(sweep, study, chain)
    cases = open_case_store(directory)
    cases.write_sweep(asked(sweep, study, plan))
    cases.forget_failures(lasting=retry_failed)
    work = _Work(plan, chain, cases, observer, began, read_progress(cases))
    work.begin()
    if work.left():
        folder = Folder(str(directory.resolve()), plan.base, chain)
        with open_pool(workers, scheduler, directory) as pool:
            work.through(pool, folder)
    summary = work.summary()
    write_progress(cases, replace(work.progress(), wall_s=summary["wall_s"]))
    observer.done(
        "sweep", f"{summary['done']} of {summary['cases']} cases done, {summary['failed']} failed"
    )
    return summary


@dataclass
class _Pace:
    """How long one of a kind takes [s], as far as known."""

    seconds: float = 0.0
    known: bool = False

    def learn(self, seconds: float) -> None:
        """Take note of the mean time of one in a task."""
        self.seconds += (MEMORY if self.known else 1.0) * (seconds - self.seconds)
        self.known = True


@dataclass
class _Work:
    """What is left of a sweep; the only state that changes while it runs."""

    plan: Plan
    chain: Chain
    cases: CaseStore
    observer: Observer
    began: float
    before: Progress
    done: set[str] = field(default_factory=set)
    failed: dict[str, str] = field(default_factory=dict)
    reused: int = 0
    blocked: dict[str, int] = field(default_factory=dict)
    waiting: dict[str, list[Job | PlannedCase]] = field(default_factory=dict)
    ready: dict[str, deque[Job | PlannedCase]] = field(default_factory=dict)
    alone: deque[Job | PlannedCase] = field(default_factory=deque)
    leading: deque[Job | PlannedCase] = field(default_factory=deque)
    leaders: set[str] = field(default_factory=set)
    later: deque[tuple[float, Job | PlannedCase]] = field(default_factory=deque)
    pace: dict[str, _Pace] = field(default_factory=dict)
    stages_left: set[str] = field(default_factory=set)
    planned: Counter[str] = field(default_factory=Counter)
    cases_left: int = 0
    flying: int = 0
    computed: int = 0
    seconds: float = 0.0
    processor: float = 0.0
    told: float = 0.0
    noted: float = 0.0

    def begin(self) -> None:
        """Find what is there, and what can be begun."""
        results = self.plan.results()
        self.done = self.cases.refresh() & set(results)
        for path in self.cases.discard_damaged():
            self.observer.done("store", f"{path.name} was damaged: its cases are computed anew")
        failures = self.cases.failures()
        todo = [case for case in results.values() if case.result not in self.done]
        for case in todo:
            if reason := next((k for k in case.keys.values() if k in failures), ""):
                self.failed[case.result] = reason
        todo = [case for case in todo if case.result not in self.failed]
        there = {key for key, job in self.plan.jobs.items() if self._is_stored(job)}
        self.reused = len(there)
        self.stages_left = self._needed(todo, there | set(failures))
        left = (job.stage for key, job in self.plan.jobs.items() if key in self.stages_left)
        self.planned = Counter(left)
        self.leaders = {self.plan.jobs[key].neighbour for key in self.stages_left}
        for key, job in self.plan.jobs.items():
            if key in self.stages_left:
                needs = {*job.needs, job.neighbour} & self.stages_left
                self._await(job, key, sorted(needs))
        # Cases that share their stages follow one another: each worker reads them once.
        for case in sorted(todo, key=lambda case: tuple(case.keys.values())):
            needs = {case.keys[name] for name in case.kept} & self.stages_left
            self._await(case, case.result, sorted(needs))
        self.cases_left = len(todo)

    def _is_stored(self, job: Job) -> bool:
        return stage_folder(self.cases.directory, job.stage, job.key).is_dir()

    def _needed(self, todo: list[PlannedCase], settled: set[str]) -> set[str]:
        """Return the keys of all stages to keep that some cases need, and of their neighbours."""
        needed: set[str] = set()
        left = {case.keys[name] for case in todo for name in case.kept} - settled
        while left:
            needed |= left
            jobs = [self.plan.jobs[key] for key in left]
            left = {key for job in jobs if job.neighbour for key in (*job.needs, job.neighbour)}
            left -= needed | settled
        return needed

    def _await(self, item: Job | PlannedCase, key: str, needs: list[str]) -> None:
        """Have an item wait for stages, or be begun if there are none."""
        if not needs:
            self._queue(item)
            return
        self.blocked[key] = len(needs)
        for need in needs:
            self.waiting.setdefault(need, []).append(item)

    def _queue(self, item: Job | PlannedCase) -> None:
        """Have an item done: before all others if the next ones start from it."""
        if _key(item) in self.leaders:
            self.leading.append(item)
            return
        self.ready.setdefault(_kind(item), deque()).append(item)

    def left(self) -> int:
        """Return how many cases have no numbers and no failure yet."""
        return self.cases_left

    def through(self, pool: Pool, folder: Folder) -> None:
        """Hand out tasks until nothing is left.

        Raises
        ------
        StoreError
            If the folder cannot be written or read any more.
        """
        while self.left():
            self._return_busy()
            while self.flying < AHEAD * max(1, pool.threads()) and (
                task := self._next_task(pool, folder)
            ):
                pool.submit(task)
                self.flying += 1
            finished = pool.next(BUSY_PAUSE)
            if finished is not None:
                self.flying -= 1
                self._take(*finished)
            self._tell(pool)

    def _return_busy(self) -> None:
        now = time.monotonic()
        while self.later and self.later[0][0] <= now:
            self._queue(self.later.popleft()[1])

    def _next_task(self, pool: Pool, folder: Folder) -> Task | None:
        """Return what should be done next: numbers of cases first, which are then out of mind.

        Only that from which others start comes before, so that these do not wait at the end.
        """
        for single in (self.alone, self.leading):
            if single:
                return self._task(folder, [single.popleft()])
        kinds = [kind for kind, items in self.ready.items() if items]
        if not kinds:
            return None
        kind = "case" if "case" in kinds else kinds[-1]
        items, pace = self.ready[kind], self.pace.setdefault(kind, _Pace())
        count = 1
        if pace.known:
            share = math.ceil(len(items) / (AHEAD * max(1, pool.threads())))
            count = min(LARGEST_TASK, share, int(TASK_SECONDS / max(pace.seconds, 1e-3)))
        return self._task(folder, [items.popleft() for _ in range(min(max(1, count), len(items)))])

    def _task(self, folder: Folder, items: list[Job | PlannedCase]) -> Task:
        """Return the task of some items of one kind."""
        stage = items[0].stage if isinstance(items[0], Job) else ""
        cases = tuple(item.case if isinstance(item, Job) else item for item in items)
        return Task(folder, stage, cases, self.plan.starts(cases))

    def _take(self, task: Task, outcomes: list[Outcome] | Died) -> None:
        """Take note of what became of a task."""
        if isinstance(outcomes, Died):
            self._take_dead(task)
            return
        items = {_key(item): item for item in self._items(task)}
        computed = [outcome.seconds for outcome in outcomes if outcome.state == "done"]
        if computed:
            pace = self.pace.setdefault(_kind(next(iter(items.values()))), _Pace())
            pace.learn(sum(computed) / len(computed))
        for outcome in outcomes:
            if outcome.state == "storage":
                raise StoreError(outcome.note)
            if outcome.note:
                self.observer.done("store", outcome.note)
            if outcome.state == "busy":
                self.later.append((time.monotonic() + BUSY_PAUSE, items[outcome.key]))
            elif outcome.state == "failed":
                self._fail(items[outcome.key], outcome.failed)
            else:
                self.reused += outcome.state == "found" and bool(task.stage)
                self._finish(items[outcome.key])
            if outcome.state == "done" and not task.stage:
                self.computed += 1
                self.seconds += outcome.seconds
                self.processor += outcome.processor

    def _take_dead(self, task: Task) -> None:
        """Try each part of a task by itself that workers died of; give up one that is by itself."""
        items = self._items(task)
        if len(items) > 1:
            self.alone.extend(items)
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
        self._fail(items[0], failure.key)

    def _items(self, task: Task) -> list[Job | PlannedCase]:
        if not task.stage:
            return list(task.cases)
        return [self.plan.jobs[case.keys[task.stage]] for case in task.cases]

    def _finish(self, item: Job | PlannedCase) -> None:
        if isinstance(item, PlannedCase):
            self.done.add(item.result)
            self.cases_left -= 1
            return
        self.stages_left.discard(item.key)
        for other in self.waiting.pop(item.key, []):
            self._release(other)

    def _release(self, item: Job | PlannedCase) -> None:
        """Take note that an item waits for one stage less."""
        key = _key(item)
        if key in self.blocked:
            self.blocked[key] -= 1
            if self.blocked[key] == 0:
                del self.blocked[key]
                self._queue(item)

    def _fail(self, item: Job | PlannedCase, reason: str) -> None:
        """Fail what has no answer, and all that waits for it but what would only start from it."""
        if isinstance(item, PlannedCase):
            self.failed[item.result] = reason
            self.cases_left -= 1
            return
        self.stages_left.discard(item.key)
        for other in self.waiting.pop(item.key, []):
            if isinstance(other, Job) and other.neighbour == item.key:
                self._release(other)
            elif self.blocked.pop(_key(other), 0):
                self._fail(other, reason)

    def _tell(self, pool: Pool) -> None:
        now = time.perf_counter()
        if now - self.told > TELL:
            self.told = now
            count, total = len(self.done), len(self.done) + len(self.failed) + self.cases_left
            failed = f", {len(self.failed)} failed" if self.failed else ""
            line = f"{count} of {total} cases{failed}{self._stages_told()}{self._to_go(pool)}"
            self.observer.tick("sweep", line)
        if now - self.noted > NOTE:
            self.noted = now
            write_progress(self.cases, self.progress())

    def _stages_told(self) -> str:
        """Return how many of the stages to keep there are, those of which some are to come."""
        left = Counter(self.plan.jobs[key].stage for key in self.stages_left)
        told = ((name, count) for name, count in self.planned.items() if left[name])
        return "".join(f", {name} {count - left[name]} of {count}" for name, count in told)

    def _to_go(self, pool: Pool) -> str:
        """Return the time to go in words, as far as every kind of work left has been seen."""
        if pool.threads() == 0:
            return ", waiting for workers"
        left: dict[str, int] = {"case": self.cases_left}
        for key in self.stages_left:
            name = self.plan.jobs[key].kind
            left[name] = left.get(name, 0) + 1
        if not all(self.pace.get(kind, _Pace()).known for kind, count in left.items() if count):
            return ""
        seconds = sum(count * self.pace[kind].seconds for kind, count in left.items() if count)
        return f", about {duration(seconds / pool.threads())} to go"

    def progress(self) -> Progress:
        """Return how far this run is, with what the ones before it computed."""
        return Progress(
            wall_s=time.perf_counter() - self.began,
            reused_stages=self.reused,
            cases=self.before.cases + self.computed,
            cases_s=self.before.cases_s + self.seconds,
            cases_processor_s=self.before.cases_processor_s + self.processor,
            software=software_versions() if self.computed else self.before.software,
        )

    def summary(self) -> dict[str, Any]:
        """Return what became of all cases, those that are alike counted one by one."""
        return {
            "cases": len(self.plan.cases),
            "done": sum(case.result in self.done for case in self.plan.cases),
            "failed": sum(case.result in self.failed for case in self.plan.cases),
            "reused_stages": self.reused,
            "wall_s": time.perf_counter() - self.began,
        }


def _key(item: Job | PlannedCase) -> str:
    return item.key if isinstance(item, Job) else item.result


def _kind(item: Job | PlannedCase) -> str:
    return item.kind if isinstance(item, Job) else "case"
