"""Workers of dask.distributed: what is sent to them, what comes back, and when they are gone."""

from __future__ import annotations

import math
import queue
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fibermelt.errors import FibermeltError
from fibermelt.sweeps.schedulers import GONE, distributed
from fibermelt.sweeps.tasks import Outcome, Task
from fibermelt.sweeps.worker import fulfil

__all__ = ["Cluster", "Died"]

COUNT_AGAIN = 5.0
"""Time [s] after which the workers are counted again: on a cluster they come and go."""


class Died:
    """In place of outcomes: the workers that had a task were killed, one after the other."""


class Cluster:
    """Workers of dask.distributed.

    Parameters
    ----------
    client : distributed.Client
        Their client.
    where : str
        What messages call their scheduler.
    folder : Path
        The results folder.
    patience : float
        Time [s] without any worker after which none is waited for.
    """

    def __init__(self, client: Any, where: str, folder: Path, patience: float = math.inf) -> None:
        self._client = client
        self._where, self._folder, self._patience = where, folder, patience
        self._finished: queue.SimpleQueue[tuple[Task, Any]] = queue.SimpleQueue()
        self._futures: set[Any] = set()
        self._threads, self._counted = 0, -COUNT_AGAIN
        self._manned = time.monotonic()

    def threads(self) -> int:
        """Return the number of threads of all workers; there may be none yet."""
        now = time.monotonic()
        if now - self._counted > COUNT_AGAIN:
            self._check()
            self._threads = sum(self._asked(self._client.nthreads).values())
            self._counted = now
            if self._threads:
                self._manned = now
            elif now - self._manned > self._patience:
                raise self._deserted()
        return self._threads

    def submit(self, task: Task) -> None:
        """Send it to the scheduler."""
        self._check()
        future = self._client.submit(_on_worker, task, pure=False)
        self._futures.add(future)
        future.add_done_callback(lambda done: self._finished.put((task, done)))

    def next(self, timeout: float) -> tuple[Task, list[Outcome] | Died] | None:
        """Wait for a task; nothing hangs when the scheduler is gone."""
        try:
            task, future = self._finished.get(timeout=timeout)
        except queue.Empty:
            self._check()
            return None
        self._futures.discard(future)
        try:
            if future.status == "error":
                raise future.exception()
            return task, self._asked(future.result)
        except distributed().KilledWorker:
            return task, Died()

    def _asked(self, question: Callable[[], Any]) -> Any:
        """Return what the scheduler answers, or raise that it is gone: it may go meanwhile."""
        try:
            return question()
        except GONE as error:
            raise self._lost() from error

    def _check(self) -> None:
        """Raise if the scheduler is gone."""
        link = self._client.scheduler_comm
        if self._client.status != "running" or link is None or link.comm.closed():
            raise self._lost()

    def _deserted(self) -> FibermeltError:
        return FibermeltError(
            f"no worker has been up for {self._patience / 60:g} minutes, and none comes in place "
            "of those that died: finished cases are kept; see whether memory or processes have "
            f"run out, and go on with fibermelt resume {self._folder}"
        )

    def _lost(self) -> FibermeltError:
        return FibermeltError(
            f"the scheduler {self._where} is gone: finished cases are kept; go on with fibermelt "
            f"resume {self._folder}, with --scheduler where there is another one"
        )


def _on_worker(task: Task) -> list[Outcome]:
    """Do a task on a worker of dask.

    Inside one, xarray would ask the scheduler for a lock on every file, also those in memory.
    """
    import dask  # noqa: PLC0415  lazy: see the module

    with dask.config.set(scheduler="synchronous"):
        return fulfil(task)
