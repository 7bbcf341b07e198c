"""Schedulers that are none and numbers of workers are refused; what the killed left is removed."""

import fcntl
import os
import re
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager
from functools import partial
from types import SimpleNamespace

import pytest
from distributed import KilledWorker
from patience import PATIENCE
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.files import has_dead_maker, made_name
from fibermelt.errors import ConfigError, FibermeltError, StoreError
from fibermelt.sweeps import pools
from fibermelt.sweeps.pools import (
    MOST_PER_CORE,
    PREFIX,
    Cluster,
    Died,
    cores,
    open_pool,
    scratch_folder,
)


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
    monkeypatch.setattr(pools, "CONNECT", limit)
    message = rf"--scheduler \S+: does not answer as a scheduler does \({said}\): start one"
    with (
        listening(answer) as address,
        pytest.raises(FibermeltError, match=message),
        open_pool(None, address, tmp_path),
    ):
        pass


def test_a_worker_of_dask_is_no_scheduler(tmp_path, monkeypatch):
    monkeypatch.setattr(pools, "_kind_of", lambda address: "Worker")
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


@pytest.mark.parametrize("error", pools.GONE)
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


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Have temporary files in a folder of their own."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


@pytest.fixture
def left(place):
    """Return the folder that a dead process left."""
    ended = subprocess.Popen([sys.executable, "-S", "-c", ""])
    ended.wait()
    folder = place / made_name(PREFIX).replace(f"-{os.getpid()}-", f"-{ended.pid}-")
    (folder / "dask-scratch-space").mkdir(parents=True)
    (folder / "dask-scratch-space" / "worker.dirlock").touch()
    return folder


def test_a_scratch_folder_is_ours_alone_and_goes(place):
    with scratch_folder() as folder:
        assert (folder.parent, folder.stat().st_mode & 0o777) == (place, 0o700)
        assert has_dead_maker(folder.name, PREFIX) is False
        (folder / "file").touch()
        with scratch_folder() as another:
            assert another != folder
        assert folder.is_dir()
    assert list(place.iterdir()) == []


def test_what_the_dead_left_is_removed(place, left):
    with scratch_folder() as folder:
        assert list(place.iterdir()) == [folder]


def test_what_a_worker_still_uses_is_not(left):
    with (left / "dask-scratch-space" / "worker.dirlock").open("wb") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        with scratch_folder():
            assert left.is_dir()
    with scratch_folder():
        assert not left.exists()


def test_what_is_not_known_to_be_left_stays(place, left):
    """Folders of a living process, of another machine, of nobody, of somebody else, and links."""
    _, host, dead, token = left.name.split("-")
    stay = [
        place / f"{PREFIX}{host}-{os.getppid()}-{token}",
        place / f"{PREFIX}other_{host}-{dead}-{token}",
        place / f"{PREFIX}mine",
        place / f"{PREFIX}{host}-x-{token}",
    ]
    for folder in stay:
        folder.mkdir()
    link = place / f"{PREFIX}{host}-{dead}-{token}0"
    link.symlink_to(left.parent)
    with scratch_folder():
        assert not left.exists()
        assert all(folder.is_dir() for folder in stay)
        assert link.is_symlink()


def test_what_is_of_another_user_stays(left, monkeypatch):
    monkeypatch.setattr("os.getuid", lambda: left.stat().st_uid + 1)
    with scratch_folder():
        assert left.is_dir()


def test_no_place_for_temporary_files_is_one_line(place, monkeypatch):
    (place / "file").touch()
    monkeypatch.setattr("tempfile.tempdir", str(place / "file"))
    message = "no place for the temporary files of workers: not a directory; have TMPDIR name"
    with pytest.raises(StoreError, match=message), scratch_folder():
        pass
