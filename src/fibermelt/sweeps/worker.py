"""What a worker of a sweep does: keep stages, and compute the numbers of cases.

What it is told and tells are values that travel between processes; no error does. What is in a task
may be imported wherever fibermelt is; the results folder must be the same for all.
"""

from __future__ import annotations

import os
import socket
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, Literal

from fibermelt.engine.execution import execute
from fibermelt.engine.files import claimed
from fibermelt.engine.stages import Neighbour, stage_parameters
from fibermelt.engine.store import Record, Store, stage_name
from fibermelt.errors import DamagedError, FibermeltError, StoreError
from fibermelt.sweeps.collection import Kept, Reduced, reduce_results, stack
from fibermelt.sweeps.store import CaseStore, Failure

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.parameters import Value
    from fibermelt.engine.parts import Chain
    from fibermelt.engine.stages import Scaled, Stage
    from fibermelt.sweeps.plan import PlannedCase

__all__ = ["Folder", "Outcome", "Task", "forget", "fulfil", "single_threaded"]

CACHE_BYTES = 256 * 2**20
"""Data of stages that a worker holds at most [bytes]: some tens of flows with their streamlines."""


def single_threaded() -> dict[str, str]:
    """Return the environment in which a worker solves on one thread."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NGS_NUM_THREADS")
    return dict.fromkeys(names, "1")


State = Literal["done", "found", "failed", "busy", "storage"]


@dataclass(frozen=True)
class Folder:
    """Where a sweep writes, and what all of its tasks have in common.

    Parameters
    ----------
    directory : str
        The results folder, absolute.
    base : dict
        The study without its sweep, resolved, in SI.
    chain : Chain
        The stages that there are.
    """

    directory: str
    base: Mapping[str, Value]
    chain: Chain


@dataclass(frozen=True)
class Task:
    """Some work of one kind, done one after the other.

    Parameters
    ----------
    folder : Folder
        Where.
    stage : str
        The stage to keep for each of the cases; empty for the numbers of the cases themselves.
    cases : tuple of PlannedCase
        For which cases.
    starts : dict
        For each of their stages that starts from a neighbour, by its key: a case with that one.
    """

    folder: Folder
    stage: str
    cases: tuple[PlannedCase, ...]
    starts: Mapping[str, PlannedCase] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What became of one case, or of one stage.

    Parameters
    ----------
    key : str
        Key of the case's numbers, or of the stage.
    state : str
        ``"done"``; ``"found"``: it was there; ``"failed"``; ``"busy"``: somebody else is at it;
        ``"storage"``: the folder cannot be written or read.
    seconds, processor : float
        Wall time and processor time that it took [s].
    failed : str
        Key of the stage that has no answer.
    note : str
        What went wrong with the folder, or what was mended in it.
    """

    key: str
    state: State
    seconds: float = 0.0
    processor: float = 0.0
    failed: str = ""
    note: str = ""


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
        self._cache: OrderedDict[tuple[Any, ...], _Held] = OrderedDict()
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
                    self._remember((key,), self._produce(name, case, values))
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
                _, data = self._compute(name, case, values)
                found |= reduce_results(self._scaled(name, values).of(data))
        return found

    def _scaled(self, name: str, values: Mapping[str, Value]) -> Scaled:
        """Return of which stored result that of a stage is a multiple."""
        stage = self._stages[name]
        return stage.multiple(stage_parameters(stage, values))

    def _data(self, name: str, case: PlannedCase, values: Mapping[str, Value]) -> _Held:
        """Return the data of a stage, in the case's own scale."""
        scaled = self._scaled(name, values)
        if not scaled.factors:
            return self._unscaled(name, case, values)
        at = (case.keys[name], *scaled.factors.values())
        return self._at(at, lambda: scaled.of(self._unscaled(name, case, values).data))

    def _unscaled(self, name: str, case: PlannedCase, values: Mapping[str, Value]) -> _Held:
        """Return the data of a stage as they are stored."""
        return self._at((case.keys[name],), lambda: self._found(name, case, values))

    def _at(self, at: tuple[Any, ...], find: Callable[[], xr.Dataset]) -> _Held:
        """Return data that are at hand, or find them and have them at hand."""
        if at not in self._cache:
            self._remember(at, find())
        self._cache.move_to_end(at)
        return self._cache[at]

    def _found(self, name: str, case: PlannedCase, values: Mapping[str, Value]) -> xr.Dataset:
        """Return the data of a stage: stored, or computed."""
        if name not in case.kept:
            return self._compute(name, case, values)[1]
        data = self._stored(name, case.keys[name])
        if data is None:
            with claimed(self._cases.lock(case.keys[name]), wait=True):
                data = self._stored(name, case.keys[name])
                if data is None:
                    data = self._produce(name, case, values)
        return data

    def _stored(self, name: str, key: str) -> xr.Dataset | None:
        """Return a stored stage, or None if there is none that is whole."""
        try:
            record = self._store.find(name, key)
            return None if record is None else self._store.load(record)
        except DamagedError:
            self._mended = f"{stage_name(name, key)} was damaged: computed anew"
            return None

    def _remember(self, at: tuple[Any, ...], data: xr.Dataset) -> None:
        self._cache[at] = _Held(data, reduce_results(data), data.nbytes)
        self._held += data.nbytes
        while self._held > CACHE_BYTES and len(self._cache) > 1:
            _, oldest = self._cache.popitem(last=False)
            self._held -= oldest.size

    def _compute(
        self, name: str, case: PlannedCase, values: Mapping[str, Value]
    ) -> tuple[Record, xr.Dataset]:
        """Return the record and the data of a stage, as they are stored.

        Raises
        ------
        _NoAnswer
            If it fails, in whatever way: the other cases go on.
        """
        stage, key = self._stages[name], case.keys[name]
        if known := self._cases.failure(name, key):
            raise _NoAnswer(known)
        inputs = {other: self._data(other, case, values).data for other in stage.fed(values)}
        start = self._neighbour(stage, case)
        try:
            return execute(stage, values, case.keys, inputs, _ignore, start)
        except Exception as error:
            expected = isinstance(error, FibermeltError)
            failure = Failure(
                stage=name,
                key=key,
                kind=type(error).__name__,
                reason=str(error) if expected else f"{type(error).__name__}: {error}",
                parameters=dict(stage_parameters(stage, values)),
                lasting=expected,
            )
            raise _NoAnswer(failure) from error

    def _neighbour(self, stage: Stage, case: PlannedCase) -> Neighbour | None:
        """Return what a stage starts from, or None: from cold, as when its neighbour failed."""
        other = self.starts.get(case.keys[stage.name])
        if stage.compute_from is None or other is None:
            return None
        values = {**self.folder.base, **other.changes}
        try:
            data = self._unscaled(stage.name, other, values).data
        except _NoAnswer as no_answer:
            self._cases.write_failure(no_answer.failure)
            return None
        return Neighbour(other.keys[stage.name], data)

    def _produce(self, name: str, case: PlannedCase, values: Mapping[str, Value]) -> xr.Dataset:
        """Compute a stage and store it in place of a damaged one; whoever calls holds its lock."""
        was_damaged = bool(self._mended)
        record, data = self._compute(name, case, values)
        self._store.save(record, data, replace=was_damaged)
        return data


def _ignore(line: str) -> None:
    """Ignore a line of progress: a sweep tells of cases, not of their steps."""


def _now() -> tuple[float, float]:
    """Return wall time and processor time of this process [s]."""
    return time.perf_counter(), time.process_time()


def _since(began: tuple[float, float]) -> tuple[float, float]:
    """Return what passed of both [s]."""
    seconds, processor = _now()
    return seconds - began[0], processor - began[1]
