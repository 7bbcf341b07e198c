"""What of a sweep is left to do: who waits for whom, what comes next, and how long it will take.

Pure bookkeeping: it reads no file, starts nothing, and knows no clock.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Collection, Mapping, Sequence

from fibermelt.sweeps.plan import Job, Plan, PlannedCase

__all__ = ["AHEAD", "Agenda", "Item"]

Item = Job | PlannedCase
"""A stage to keep, or a case whose numbers are to be computed."""

TASK_SECONDS = 1.0
"""What a task should take [s]: long against the millisecond that dask spends on each."""

LARGEST_TASK = 64
"""Cases of a task, at most: what a killed worker loses, and open locks."""

AHEAD = 2
"""Tasks for each thread that are with the scheduler: one works, one waits."""

MEMORY = 0.3
"""Weight of the last task in the mean time of its kind."""

CASE = "case"
"""The kind of all cases; that of a stage is its own (`Job.kind`)."""


class Agenda:
    """What is left of a plan.

    Parameters
    ----------
    plan : Plan
        What the sweep comes to.
    done : collection of str
        Keys of the numbers that are there.
    stored : collection of str
        Keys of the stages that are there.
    failures : collection of str
        Keys of the stages that have no answer.
    """

    def __init__(
        self,
        plan: Plan,
        done: Collection[str],
        stored: Collection[str],
        failures: Collection[str],
    ) -> None:
        self.plan = plan
        results = plan.results()
        self.done = set(done) & set(results)
        self.failed: dict[str, str] = {}
        self._blocked: dict[str, int] = {}
        self._waiting: dict[str, list[Item]] = {}
        self._ready: dict[str, deque[Item]] = {}
        self._alone: deque[Item] = deque()
        self._leading: deque[Item] = deque()
        self._pace: dict[str, float] = {}
        todo = [case for key, case in results.items() if key not in self.done]
        for case in todo:
            if reason := next((key for key in case.keys.values() if key in failures), ""):
                self.failed[case.result] = reason
        todo = [case for case in todo if case.result not in self.failed]
        self.cases_left = len(todo)
        self._stages_left = self._needed(todo, {*stored, *failures})
        jobs = [job for key, job in plan.jobs.items() if key in self._stages_left]
        self._stages = Counter(job.stage for job in jobs)
        self._leaders = {job.neighbour for job in jobs}
        for job in jobs:
            self._await(job, {*job.needs, job.neighbour} & self._stages_left)
        # Cases that share their stages follow one another: each worker reads them once.
        for case in sorted(todo, key=lambda case: tuple(case.keys.values())):
            self._await(case, {case.keys[name] for name in case.kept} & self._stages_left)

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

    def _await(self, item: Item, needs: set[str]) -> None:
        """Have an item wait for stages, or be ready if there are none."""
        if not needs:
            self.add(item)
            return
        self._blocked[item.result_key] = len(needs)
        for need in sorted(needs):
            self._waiting.setdefault(need, []).append(item)

    def add(self, item: Item) -> None:
        """Have an item done: before all others if the next ones start from it."""
        if item.result_key in self._leaders:
            self._leading.append(item)
        else:
            self._ready.setdefault(_kind(item), deque()).append(item)

    def part(self, items: Sequence[Item]) -> None:
        """Have items done one by one, before all others: together they killed their workers."""
        self._alone.extend(items)

    def next(self, threads: int) -> list[Item]:
        """Return what should be done next, of one kind and about `TASK_SECONDS` long, if anything.

        Numbers of cases come first, which are then out of mind. Only that from which others start
        comes before, so that these do not wait at the end.

        Parameters
        ----------
        threads : int
            How many tasks are done at once.
        """
        for single in (self._alone, self._leading):
            if single:
                return [single.popleft()]
        kinds = [kind for kind, items in self._ready.items() if items]
        if not kinds:
            return []
        kind = CASE if CASE in kinds else kinds[-1]
        items, count = self._ready[kind], 1
        if kind in self._pace:
            share = math.ceil(len(items) / (AHEAD * max(1, threads)))
            count = min(LARGEST_TASK, share, int(TASK_SECONDS / max(self._pace[kind], 1e-3)))
        return [items.popleft() for _ in range(min(max(1, count), len(items)))]

    def learn(self, item: Item, seconds: float) -> None:
        """Take note of how long one of an item's kind took [s]."""
        last = self._pace.get(_kind(item), seconds)
        self._pace[_kind(item)] = last + MEMORY * (seconds - last)

    def finish(self, item: Item) -> None:
        """Take note that an item is done."""
        if isinstance(item, PlannedCase):
            self.done.add(item.result)
            self.cases_left -= 1
            return
        self._stages_left.discard(item.key)
        for other in self._waiting.pop(item.key, []):
            self._release(other)

    def fail(self, item: Item, reason: str) -> None:
        """Take note that an item has no answer, nor has what needs it.

        What would only have started from it starts from cold.

        Parameters
        ----------
        item : Job or PlannedCase
            The item.
        reason : str
            Key of the stage that failed.
        """
        if isinstance(item, PlannedCase):
            self.failed[item.result] = reason
            self.cases_left -= 1
            return
        self._stages_left.discard(item.key)
        for other in self._waiting.pop(item.key, []):
            if isinstance(other, Job) and other.neighbour == item.key:
                self._release(other)
            elif self._blocked.pop(other.result_key, 0):
                self.fail(other, reason)

    def _release(self, item: Item) -> None:
        """Take note that an item waits for one stage less."""
        key = item.result_key
        if key in self._blocked:
            self._blocked[key] -= 1
            if self._blocked[key] == 0:
                del self._blocked[key]
                self.add(item)

    def stages(self) -> Mapping[str, tuple[int, int]]:
        """Return how many results of each stage are there by now of those that this run needs."""
        left = Counter(self.plan.jobs[key].stage for key in self._stages_left)
        return {name: (count - left[name], count) for name, count in self._stages.items()}

    def seconds_left(self) -> float | None:
        """Return how long all that is left takes one thread [s]; None while a kind is unknown."""
        left = Counter(self.plan.jobs[key].kind for key in self._stages_left)
        left[CASE] += self.cases_left
        kinds = [kind for kind, count in left.items() if count]
        if any(kind not in self._pace for kind in kinds):
            return None
        return sum(left[kind] * self._pace[kind] for kind in kinds)


def _kind(item: Item) -> str:
    return item.kind if isinstance(item, Job) else CASE
