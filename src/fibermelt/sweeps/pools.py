"""Who does the tasks of a sweep: this process, a cluster on this machine, or one that is there.

dask.distributed is imported when a cluster is wanted, and never for anything else.
"""

from __future__ import annotations

import asyncio
import json
import logging
import math
import os
import queue
import re
import shutil
import signal
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent import futures
from contextlib import ExitStack, contextmanager, suppress
from importlib import import_module
from multiprocessing import resource_tracker
from pathlib import Path
from threading import Thread
from typing import Any, Protocol

from fibermelt.engine.files import has_dead_maker, made_name
from fibermelt.engine.parameters import excerpt
from fibermelt.errors import ConfigError, FibermeltError, StoreError
from fibermelt.sweeps.worker import Outcome, Task, forget, fulfil, single_threaded

__all__ = ["Cluster", "Died", "Pool", "cores", "open_pool", "refuse_workers"]

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

COUNT_AGAIN = 5.0
"""Time [s] after which the workers are counted again: on a cluster they come and go."""

CONNECT = 20.0
"""Time [s] in which a scheduler has to answer: it is there, or it is not."""

ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://[^/\s]+:\d{1,5}/?")
"""What dask takes for the address of a scheduler."""

GONE = (OSError, RuntimeError, asyncio.CancelledError, futures.CancelledError)
"""What a client of dask raises whose scheduler goes while it is asked: a connection that breaks or
cannot be made, one wanted of a client that was closed, a future that is given up."""

PREFIX = "fibermelt-"
"""How the names begin, in the folder of all temporary files of this machine."""

LOCKS = "*.dirlock"
"""Files that workers of dask lock as long as they live."""


def distributed() -> Any:
    """Return dask.distributed, of whose functions some have types and some have not."""
    return import_module("distributed")


def cores() -> int:
    """Return the cores of this machine that we may use: workers, unless told otherwise."""
    try:
        from dask.system import CPU_COUNT  # noqa: PLC0415  lazy: see the module
    except ImportError:
        return os.cpu_count() or 1
    return int(CPU_COUNT)


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


def connect(scheduler: str, folder: Path) -> Any:
    """Return a client of a scheduler.

    Parameters
    ----------
    scheduler : str
        Its address (``"tcp://host:port"``) or the path of its file.
    folder : Path
        The results folder, from which no scheduler is ever taken.

    Raises
    ------
    ConfigError
        If that is no address, no file with one, or the address of something else of dask.
    FibermeltError
        If no scheduler answers there.
    """
    address = _address(scheduler, folder)
    try:
        kind = _kind_of(address)
        client = None
        if kind == "Scheduler":
            client = distributed().Client(address, timeout=CONNECT, set_as_default=False)
    except Exception as error:
        is_told = isinstance(error, OSError | ValueError | TypeError | ImportError)
        reason = (str(error) or type(error).__name__) if is_told else "it sends what dask does not"
        msg = (
            f"--scheduler {scheduler}: does not answer as a scheduler does ({reason}): "
            "start one with dask scheduler, or drop --scheduler"
        )
        raise FibermeltError(msg) from error
    if client is None:
        msg = (
            f"--scheduler {scheduler}: is the address of a {excerpt(kind)} of dask, not of its "
            "scheduler, which dask scheduler tells as it starts"
        )
        raise ConfigError(msg)
    return client


def _address(scheduler: str, folder: Path) -> str:
    """Return the address of a scheduler that is told by it or by a file."""
    address = scheduler
    if "://" not in scheduler:
        path = Path(scheduler)
        if not path.is_file():
            msg = (
                f"--scheduler {scheduler}: neither an address such as tcp://host:8786 nor a "
                "scheduler file"
            )
            raise ConfigError(msg)
        if path.resolve().is_relative_to(folder.resolve()):
            msg = (
                f"--scheduler {scheduler}: lies in the results folder, whose content is never "
                "taken for the address of a scheduler: keep it elsewhere"
            )
            raise ConfigError(msg)
        address = _written(path)
    if not ADDRESS.fullmatch(address):
        # dask would answer with a client half made, that hangs and complains as it is dropped.
        msg = f"--scheduler {scheduler}: is no address such as tcp://host:8786"
        raise ConfigError(
            msg if address == scheduler else f"{msg}, nor is {excerpt(address)} in it"
        )
    return address


def _kind_of(address: str) -> str:
    """Return what of dask listens at an address, such as ``"Scheduler"``.

    A client of dask bounds the time of a connection only: it would wait forever for the first
    word of another service that keeps silent.

    Raises
    ------
    TimeoutError
        If nothing of dask has answered in `CONNECT`.
    Exception
        Whatever dask makes of what answers.
    """
    dd = distributed()

    async def ask() -> str:
        secrets = dd.Security().get_connection_args("client")
        # Bounded by who waits, below: of two limits that are alike, now one would end it, now one.
        async with dd.rpc(address, timeout=2 * CONNECT, connection_args=secrets) as link:
            return str((await link.identity())["type"])

    answer: futures.Future[str] = futures.Future()

    def wait() -> None:
        try:
            answer.set_result(asyncio.run(asyncio.wait_for(ask(), CONNECT)))
        except Exception as error:
            answer.set_exception(error)

    # A loop of its own: there may be one in this thread, as in a notebook.
    Thread(target=wait, daemon=True).start()
    try:
        return answer.result(CONNECT + 1.0)
    except TimeoutError:
        msg = f"nothing of dask has answered in {CONNECT:g} s"
        raise TimeoutError(msg) from None


def _written(path: Path) -> str:
    """Return the address that a scheduler file holds."""
    try:
        return str(json.loads(path.read_text(encoding="utf-8"))["address"])
    except (OSError, ValueError, LookupError, TypeError):
        msg = (
            f"--scheduler {path}: holds no address of a scheduler: have dask scheduler "
            "--scheduler-file write it"
        )
        raise ConfigError(msg) from None


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Yield a new folder for temporary files, which is gone at the end.

    A client that is killed leaves its folder there: the next one removes it, once no process of
    ours is left that may use it.

    Raises
    ------
    StoreError
        If there is no place for it.
    """
    try:
        parent = Path(tempfile.gettempdir())
        _remove_leftovers(parent)
        folder = parent / made_name(PREFIX)
        folder.mkdir(mode=0o700)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = (
            f"no place for the temporary files of workers: {reason}; have TMPDIR name a folder "
            "that can be written, or take --workers 0"
        )
        raise StoreError(msg) from error
    try:
        yield folder
    finally:
        # A worker that is slow to end may still write there: then the next sweep removes it.
        shutil.rmtree(folder, ignore_errors=True)


def _remove_leftovers(parent: Path) -> None:
    for folder in parent.glob(f"{PREFIX}*"):
        if has_dead_maker(folder.name, PREFIX) and _is_ours(folder) and not _is_used(folder):
            shutil.rmtree(folder, ignore_errors=True)


def _is_ours(folder: Path) -> bool:
    """Tell whether this user made a folder: others share the place, and may put links there."""
    try:
        return not folder.is_symlink() and folder.stat().st_uid == os.getuid()
    except OSError:
        return False


def _is_used(folder: Path) -> bool:
    """Tell whether a worker outlived its client, and holds its lock."""
    import fcntl  # noqa: PLC0415  there is none on Windows, where no maker is known to be dead

    for lock in folder.rglob(LOCKS):
        try:
            with lock.open("rb") as stream:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except FileNotFoundError:
            continue
        except OSError:
            return True
    return False
