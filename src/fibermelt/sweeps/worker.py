"""What a worker of a sweep does: keep stages, and compute the numbers of cases."""

from __future__ import annotations

import os
import socket
import time
from collections import OrderedDict
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from fibermelt.engine.files import claimed
from fibermelt.engine.runner import software_versions
from fibermelt.engine.stages import Neighbour, Parameters, stage_parameters
from fibermelt.engine.store import Record, Store, stage_name
from fibermelt.errors import DamagedError, FibermeltError, StoreError
from fibermelt.sweeps.collection import Kept, Reduced, reduce_results, stack
from fibermelt.sweeps.store import CaseStore, Failure
from fibermelt.sweeps.tasks import Folder, Outcome, Task

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.parameters import Value
    from fibermelt.engine.stages import Stage
    from fibermelt.sweeps.plan import PlannedCase

__all__ = ["forget", "fulfil", "single_threaded"]

CACHE_BYTES = 256 * 2**20
"""Data of stages that a worker holds at most [bytes]: some tens of flows with their streamlines."""


def single_threaded() -> dict[str, str]:
    """Return the environment in which a worker solves on one thread."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NGS_NUM_THREADS")
    return dict.fromkeys(names, "1")


class _NoAnswer(Exception):  # noqa: N818  not an error of anybody: it carries one
    """A stage has no answer."""

    def __init__(self, failure: Failure) -> None:
        super().__init__(failure.reason)
        self.failure = failure


def fulfil(task: Task) -> list[Outcome]:
    """Do a task and return what became of each part of it; other threads wait for their turn."""
    from threadpoolctl import threadpool_limits  # noqa: PLC0415  lazy: planning needs none of it

    # Read when the solver is loaded, which is later than this.
    os.environ.setdefault("NGS_NUM_THREADS", "1")
    try:
        with _ONE_TASK, threadpool_limits(limits=1):
            worker = _worker(task.folder)
            worker.starts = task.starts
            if task.stage:
                return [worker.keep(task.stage, case) for case in task.cases]
            return worker.compute(task.cases)
    except StoreError as error:
        keys = [case.keys[task.stage] if task.stage else case.result for case in task.cases]
        return [Outcome(key, "storage", note=str(error)) for key in keys]


_ONE_TASK = Lock()
"""Held while a task is done: a worker of dask has as many threads as it was given, and what this
process holds, and the threads of its BLAS, are for one task."""

_WORKERS: dict[str, _Worker] = {}
"""What this process holds of the folder that it works for: one at a time."""


def forget() -> None:
    """Forget what this process holds of a folder: another sweep may find it changed."""
    _WORKERS.clear()


def _worker(folder: Folder) -> _Worker:
    worker = _WORKERS.get(folder.directory)
    if worker is None or worker.folder.base != folder.base:
        if not (Path(folder.directory) / "sweep.json").exists():
            msg = (
                f"{folder.directory}: is not there on {socket.gethostname()}: all workers must see "
                "the results folder under the same path"
            )
            raise StoreError(msg)
        _WORKERS.clear()
        worker = _WORKERS[folder.directory] = _Worker(folder)
    return worker


@dataclass(frozen=True)
class _Held:
    """The data of a stage, the numbers kept of it, and its size [bytes]."""

    data: xr.Dataset
    numbers: Reduced
    size: int


class _Worker:
    """A process that works for a folder, with the data of stages that it used last."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.starts: Mapping[str, PlannedCase] = {}
        self._stages: dict[str, Stage] = {stage.name: stage for stage in folder.chain.stages}
        self._store = Store(Path(folder.directory), ())
        self._cases = CaseStore(Path(folder.directory))
        self._cache: OrderedDict[str, _Held] = OrderedDict()
        self._held = 0
        self._mended = ""

    def keep(self, name: str, case: PlannedCase) -> Outcome:
        """Compute a stage and store it, unless it is there."""
        key, began = case.keys[name], _now()
        self._mended = ""
        with claimed(self._cases.lock(key), wait=False) as ours:
            if not ours:
                return Outcome(key, "busy")
            try:
                was_there = self._stored(name, key) is not None
                if not was_there:
                    values = {**self.folder.base, **case.changes}
                    self._remember(key, self._produce(name, case, values))
            except _NoAnswer as no_answer:
                self._cases.write_failure(no_answer.failure)
                return Outcome(key, "failed", failed=no_answer.failure.key)
        return Outcome(key, "found" if was_there else "done", *_since(began), note=self._mended)

    def compute(self, cases: tuple[PlannedCase, ...]) -> list[Outcome]:
        """Compute the numbers of cases, and write all of them in one file."""
        outcomes: list[Outcome] = []
        numbers: list[tuple[str, Reduced]] = []
        with ExitStack() as stack_of_locks:
            ours = []
            for case in cases:
                lock = claimed(self._cases.lock(case.result), wait=False)
                if stack_of_locks.enter_context(lock):
                    ours.append(case)
                else:
                    outcomes.append(Outcome(case.result, "busy"))
            finished = self._cases.refresh()
            for case in ours:
                if case.result in finished:
                    outcomes.append(Outcome(case.result, "found"))
                    continue
                began, self._mended = _now(), ""
                try:
                    numbers.append((case.result, self._numbers(case)))
                except _NoAnswer as no_answer:
                    self._cases.write_failure(no_answer.failure)
                    outcomes.append(Outcome(case.result, "failed", failed=no_answer.failure.key))
                else:
                    spent = _since(began)
                    outcomes.append(Outcome(case.result, "done", *spent, note=self._mended))
            for batch in stack(numbers):
                self._cases.write_batch(batch)
        return outcomes

    def _numbers(self, case: PlannedCase) -> dict[str, Kept]:
        """Return what is kept of a case: the numbers of all its stages."""
        values = {**self.folder.base, **case.changes}
        feeding = {other for name in case.keys for other in self._stages[name].fed(values)}
        found: dict[str, Kept] = {}
        for name in case.keys:
            if name in feeding or name in case.kept:
                found |= self._data(name, case, values).numbers
            else:
                found |= reduce_results(self._compute(name, case, values)[0])
        return found

    def _data(self, name: str, case: PlannedCase, values: Mapping[str, Value]) -> _Held:
        """Return the data of a stage: at hand, stored, or computed."""
        key = case.keys[name]
        if key in self._cache:
            self._cache.move_to_end(key)
            return self._cache[key]
        if name not in case.kept:
            return self._remember(key, self._compute(name, case, values)[0])
        data = self._stored(name, key)
        if data is None:
            with claimed(self._cases.lock(key), wait=True):
                data = self._stored(name, key)
                if data is None:
                    data = self._produce(name, case, values)
        return self._remember(key, data)

    def _stored(self, name: str, key: str) -> xr.Dataset | None:
        """Return a stored stage, or None if there is none that is whole."""
        try:
            record = self._store.find(name, key)
            return None if record is None else self._store.load(record)
        except DamagedError:
            self._mended = f"{stage_name(name, key)} was damaged: computed anew"
            return None

    def _remember(self, key: str, data: xr.Dataset) -> _Held:
        entry = self._cache[key] = _Held(data, reduce_results(data), data.nbytes)
        self._held += entry.size
        while self._held > CACHE_BYTES and len(self._cache) > 1:
            _, oldest = self._cache.popitem(last=False)
            self._held -= oldest.size
        return entry

    def _compute(
        self, name: str, case: PlannedCase, values: Mapping[str, Value]
    ) -> tuple[xr.Dataset, str]:
        """Return the data of a stage, and the key of the neighbour that they came from, if any."""
        stage = self._stages[name]
        if known := self._cases.failure(name, case.keys[name]):
            raise _NoAnswer(known)
        inputs = {other: self._data(other, case, values).data for other in stage.fed(values)}
        start = self._neighbour(stage, case)
        return _answer(stage, case.keys[name], stage_parameters(stage, values), inputs, start)

    def _neighbour(self, stage: Stage, case: PlannedCase) -> Neighbour | None:
        """Return what a stage starts from, or None: from cold, as when its neighbour failed."""
        other = self.starts.get(case.keys[stage.name])
        if stage.compute_from is None or other is None:
            return None
        values = {**self.folder.base, **other.changes}
        try:
            data = self._data(stage.name, other, values).data
        except _NoAnswer as no_answer:
            self._cases.write_failure(no_answer.failure)
            return None
        return Neighbour(stage_parameters(stage, values), data, other.keys[stage.name])

    def _produce(self, name: str, case: PlannedCase, values: Mapping[str, Value]) -> xr.Dataset:
        """Compute a stage and store it in place of a damaged one; whoever calls holds its lock."""
        was_damaged = bool(self._mended)
        began = _now()
        data, neighbour = self._compute(name, case, values)
        seconds, processor = _since(began)
        stage = self._stages[name]
        record = Record(
            stage=name,
            version=stage.version,
            key=case.keys[name],
            parameters=dict(stage_parameters(stage, values)),
            inputs={other: case.keys[other] for other in stage.fed(values)},
            cost=seconds,
            data="",
            software=software_versions(),
            processor=processor,
            neighbour=neighbour,
        )
        self._store.save(record, data, replace=was_damaged)
        return data


def _now() -> tuple[float, float]:
    """Return wall time and processor time of this process [s]."""
    return time.perf_counter(), time.process_time()


def _since(began: tuple[float, float]) -> tuple[float, float]:
    """Return what passed of both [s]."""
    seconds, processor = _now()
    return seconds - began[0], processor - began[1]


def _answer(
    stage: Stage,
    key: str,
    parameters: Parameters,
    inputs: Mapping[str, xr.Dataset],
    start: Neighbour | None,
) -> tuple[xr.Dataset, str]:
    """Return what a stage computes, as `Stage.begin` does.

    Raises
    ------
    _NoAnswer
        If it fails, in whatever way: the other cases go on.
    """

    def say(line: str) -> None:
        """Ignore it: a sweep tells of cases, not of their steps."""

    try:
        return stage.begin(parameters, inputs, say, start)
    except Exception as error:
        expected = isinstance(error, FibermeltError)
        failure = Failure(
            stage=stage.name,
            key=key,
            kind=type(error).__name__,
            reason=str(error) if expected else f"{type(error).__name__}: {error}",
            parameters=dict(parameters),
            lasting=expected,
        )
        raise _NoAnswer(failure) from error
