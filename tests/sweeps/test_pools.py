"""Addresses of schedulers that are none are refused, and so are numbers of workers."""

import re
import socket
import threading
from contextlib import contextmanager
from functools import partial
from types import SimpleNamespace

import pytest
from distributed import KilledWorker
from patience import PATIENCE
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.errors import ConfigError, FibermeltError
from fibermelt.sweeps import schedulers
from fibermelt.sweeps.cluster import Cluster, Died
from fibermelt.sweeps.pools import MOST_PER_CORE, cores, open_pool


@pytest.mark.parametrize("address", ["foo://x", "tcp://", "tcp://host", "tcp://host:port"])
def test_what_is_no_address_is_refused(tmp_path, address):
    with (
        pytest.raises(ConfigError, match=f"--scheduler {address}: is no address such as tcp://"),
        open_pool(None, address, tmp_path),
    ):
        pass


@pytest.mark.parametrize(
    ("held", "said"),
    [
        ("garbage", "holds no address"),
        ("[]", "holds no address"),
        ('"text"', "holds no address"),
        ("{}", "holds no address"),
        ('{"address": 5}', "is no address such as tcp://host:8786, nor is 5 in it"),
    ],
)
def test_a_file_without_an_address_is_refused(tmp_path, held, said):
    file = tmp_path / "scheduler.json"
    file.write_text(held)
    with pytest.raises(ConfigError, match=said), open_pool(None, str(file), tmp_path / "results"):
        pass


@contextmanager
def listening(answer):
    """Yield the address of a service that takes connections and sends each of them some bytes."""
    taken = []

    def take():
        try:
            while True:
                taken.append(server.accept()[0])
                taken[-1].sendall(answer)
        except OSError:  # closed
            return

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=take)
        thread.start()
        try:
            yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
        finally:
            server.shutdown(socket.SHUT_RDWR)
            thread.join()
            for one in taken:
                one.close()


@pytest.mark.parametrize(
    ("answer", "limit", "said"),
    [
        (b"", 0.2, "nothing of dask has answered in 0.2 s"),
        (
            b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n",
            PATIENCE,
            "it sends what dask does not",
        ),
        (b"SSH-2.0-OpenSSH_9.6\r\n", PATIENCE, "it sends what dask does not"),
    ],
    ids=["silent", "http", "ssh"],
)
def test_another_service_is_no_scheduler(tmp_path, monkeypatch, answer, limit, said):
    monkeypatch.setattr(schedulers, "CONNECT", limit)
    message = rf"--scheduler \S+: does not answer as a scheduler does \({said}\): start one"
    with (
        listening(answer) as address,
        pytest.raises(FibermeltError, match=message),
        open_pool(None, address, tmp_path),
    ):
        pass


def test_a_worker_of_dask_is_no_scheduler(tmp_path, monkeypatch):
    monkeypatch.setattr(schedulers, "_kind_of", lambda address: "Worker")
    with (
        pytest.raises(ConfigError, match="is the address of a Worker of dask, not of its sched"),
        open_pool(None, "tcp://127.0.0.1:8786", tmp_path),
    ):
        pass


class Failing:
    """A client of dask whose link is open as yet, and a future that is done: every answer fails."""

    status = "running"
    scheduler_comm = SimpleNamespace(comm=SimpleNamespace(closed=lambda: False))

    def __init__(self, error):
        self.error = error

    def nthreads(self):
        raise self.error

    result = nthreads

    def submit(self, function, task, *, pure):
        return Failing(self.error)

    def add_done_callback(self, call):
        self.status = "finished"
        call(self)


@pytest.mark.parametrize("error", schedulers.GONE)
def test_a_scheduler_that_goes_while_it_is_asked_is_gone(tmp_path, error):
    """For the number of its workers, or for what a task has found."""
    pool = Cluster(Failing(error("Stream is closed")), "tcp://host:8786", tmp_path)
    pool.submit("a task")
    for asked in (pool.threads, partial(pool.next, 0.0)):
        with pytest.raises(FibermeltError, match="scheduler tcp://host:8786 is gone: finished"):
            asked()


def test_workers_that_die_of_a_task_whose_answer_was_lost_are_told_so(tmp_path):
    """Who had the answer died before it was fetched, and who tried again was killed."""
    pool = Cluster(Failing(KilledWorker("a task", None, 3)), "of this machine", tmp_path)
    pool.submit("a task")
    task, outcome = pool.next(0.0)
    assert (task, type(outcome)) == ("a task", Died)


class Deserted(Failing):
    """A client of a scheduler without workers."""

    def __init__(self):
        super().__init__(None)

    def nthreads(self):
        return {}


def test_workers_are_not_waited_for_without_end(tmp_path):
    """But in the queue of a cluster of other people, that may be days."""
    assert Cluster(Deserted(), "tcp://host:8786", tmp_path).threads() == 0
    message = r"no worker has been up for 0 minutes.*finished cases are kept.*resume"
    with pytest.raises(FibermeltError, match=message):
        Cluster(Deserted(), "of this machine", tmp_path, 0.0).threads()


@pytest.mark.parametrize("workers", [-1, MOST_PER_CORE * cores() + 1, 10**9])
def test_a_number_of_workers_that_was_meant_otherwise_is_refused(tmp_path, workers):
    message = rf"--workers {workers}: must be at (most|least)"
    with pytest.raises(ConfigError, match=message), open_pool(workers, None, tmp_path):
        pass
    given = ["nozzle", "--out", str(tmp_path / "out"), "--workers", str(workers)]
    told, planned = (CliRunner().invoke(app, [command, *given]) for command in ("sweep", "plan"))
    assert (told.exit_code, told.stdout) == (2, "")
    assert re.search(message, told.stderr)
    assert (planned.exit_code, planned.stdout, planned.stderr) == (2, "", told.stderr)
    assert not (tmp_path / "out").exists()
