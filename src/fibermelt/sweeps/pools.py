"""Who does the tasks of a sweep: this process, a cluster on this machine, or one that is there.

dask.distributed is imported when a cluster is wanted, and never for anything else.
"""

from __future__ import annotations

import logging
import os
import signal
import time
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Protocol

from fibermelt.errors import ConfigError
from fibermelt.sweeps.cluster import Cluster, Died
from fibermelt.sweeps.schedulers import CONNECT, connect, distributed
from fibermelt.sweeps.scratch import scratch_folder
from fibermelt.sweeps.tasks import Outcome, Task
from fibermelt.sweeps.worker import forget, fulfil, single_threaded

__all__ = ["Pool", "cores", "open_pool", "refuse_workers"]

MOST_PER_CORE = 64
"""Workers on a core of this machine, at most: each is a process of 150 MB and of seconds to start,
and more of them than cores bring nothing; far more were meant otherwise."""

ANY_PORT = "127.0.0.1:0"
"""Where a scheduler of ours serves HTTP, which it insists on: else port 8787, with a complaint if
another sweep has it."""

DEATHS = 3
"""Workers that may die over a task before it is given up, as dask counts them."""

COME_BACK = "1 d"
"""Time after which dask does without a worker that was killed and is not back, for good: its own
15 s are too few on a busy machine, and the sweep would be left without any."""

SPAWNED = "distributed.nanny.pre-spawn-environ"
"""Where dask has the environment that a worker starts with."""

MEMORY = {"MALLOC_TRIM_THRESHOLD_": 128 * 2**20, "MALLOC_MMAP_THRESHOLD_": 32 * 2**20}
"""Bytes above which the C library gives freed memory back to the system, in a worker of ours. Cases
take the same memory one after the other: with dask's 64 kB the system cleared it for each of them
anew, a sixth of a worker's time."""

WITHOUT_WORKERS = 600.0
"""Time [s] without any worker after which this machine is taken to start none any more. Those of
other schedulers may wait for their turn in a queue for days."""


def cores() -> int:
    """Return the cores of this machine that we may use: workers, unless told otherwise."""
    try:
        from dask.system import CPU_COUNT  # noqa: PLC0415  lazy: see the module
    except ImportError:
        return os.cpu_count() or 1
    return int(CPU_COUNT)


class Pool(Protocol):
    """Who does tasks."""

    def threads(self) -> int:
        """Return how many tasks can be done at once; none while there are no workers."""

    def submit(self, task: Task) -> None:
        """Have a task done some time."""

    def next(self, timeout: float) -> tuple[Task, list[Outcome] | Died] | None:
        """Return a task that is finished, or None if there is none in a time [s]."""


class _Here:
    """Does one task after the other, in this process."""

    def __init__(self) -> None:
        self._waiting: deque[Task] = deque()

    def threads(self) -> int:
        """Return one."""
        return 1

    def submit(self, task: Task) -> None:
        """Put it into the queue."""
        self._waiting.append(task)

    def next(self, timeout: float) -> tuple[Task, list[Outcome] | Died] | None:
        """Do the first task in the queue."""
        if not self._waiting:
            time.sleep(timeout)
            return None
        task = self._waiting.popleft()
        return task, fulfil(task)


def refuse_workers(workers: int | None, scheduler: str | None) -> None:
    """Refuse what no pool can be opened with, before anything is written.

    Raises
    ------
    ConfigError
        If both are given, or too few or too many workers.
    """
    if workers is not None and scheduler is not None:
        msg = f"--workers {workers} with --scheduler: a scheduler has workers of its own; drop one"
        raise ConfigError(msg)
    if workers is not None and workers < 0:
        msg = f"--workers {workers}: must be at least 0 (0: in this process, without a cluster)"
        raise ConfigError(msg)
    if workers is not None and workers > MOST_PER_CORE * cores():
        msg = (
            f"--workers {workers}: must be at most {MOST_PER_CORE * cores()} ({MOST_PER_CORE} for "
            f"each of {cores()} cores): each is a process of its own, and more than cores bring "
            "nothing; leave it away for one for each core"
        )
        raise ConfigError(msg)


@contextmanager
def open_pool(workers: int | None, scheduler: str | None, folder: Path) -> Iterator[Pool]:
    """Yield who does the tasks of a sweep.

    Parameters
    ----------
    workers : int, optional
        Workers of a cluster on this machine, a process with one thread each: as many as there
        are cores by default. 0 is this process itself.
    scheduler : str, optional
        Address of a scheduler (``"tcp://host:port"``) or path of its file, whose workers are
        used; each should have one thread.
    folder : Path
        The results folder, from which no scheduler is ever taken.

    Raises
    ------
    ConfigError
        If both are given, or what is given cannot be.
    FibermeltError
        If the scheduler does not answer.
    """
    refuse_workers(workers, scheduler)
    if workers == 0:
        forget()
        yield _Here()
        forget()
        return
    try:
        import dask  # noqa: PLC0415  lazy: see the module

        distributed()
    except ImportError:
        msg = (
            'a cluster needs dask.distributed: pip install "dask[distributed]", or take --workers 0'
        )
        raise ConfigError(msg) from None
    with ExitStack() as stack:
        # What dask has to say of a worker that died or a scheduler that left is told by the sweep.
        logger = logging.getLogger("distributed")
        stack.callback(logger.setLevel, logger.level)
        logger.setLevel(logging.CRITICAL)
        settings = {
            "distributed.scheduler.allowed-failures": DEATHS,
            "distributed.comm.timeouts.connect": f"{CONNECT:g}s",
            "distributed.deploy.lost-worker-timeout": COME_BACK,
            SPAWNED: {**dask.config.get(SPAWNED, {}), **MEMORY},
        }
        stack.enter_context(dask.config.set(settings))
        if scheduler is None:
            yield stack.enter_context(_local(workers, folder))
        else:
            yield stack.enter_context(_remote(scheduler, folder))


@contextmanager
def _local(workers: int | None, folder: Path) -> Iterator[Cluster]:
    """Yield a cluster on this machine, which goes with this process however that ends."""
    dd = distributed()
    with scratch_folder() as scratch, ExitStack() as stack:
        try:
            with _without_interrupts():
                cluster = dd.LocalCluster(
                    n_workers=workers or cores(),
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address=None,
                    scheduler_kwargs={"dashboard_address": ANY_PORT},
                    local_directory=str(scratch),
                    silence_logs=logging.CRITICAL,
                    env=single_threaded(),
                )
                client = dd.Client(stack.enter_context(cluster), set_as_default=False)
                stack.enter_context(client)
            yield Cluster(client, "of this machine", folder, WITHOUT_WORKERS)
        finally:
            # Ctrl-C once more must not leave it half closed.
            with _without_interrupts():
                stack.close()


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Let Ctrl-C and hanging up wait, and never reach processes that are started inside.

    A terminal sends SIGINT and SIGHUP to all of them. Threads and processes inherit what is
    blocked, so those of a cluster, also a worker that takes the place of a dead one, leave it to
    the client.
    """
    if not hasattr(signal, "pthread_sigmask"):  # there is none on Windows
        yield
        return
    # Started by the first process that needs it, it would let them through again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _remote(scheduler: str, folder: Path) -> Iterator[Cluster]:
    """Yield the workers of a scheduler that is there already."""
    client = connect(scheduler, folder)
    try:
        yield Cluster(client, scheduler, folder)
    finally:
        # A scheduler that is gone cannot be told that we leave.
        with suppress(Exception):
            client.close(timeout=2)
