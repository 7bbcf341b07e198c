"""Sweeps that a person ends: Ctrl-C, a signal to end, a terminal that is closed.

Whatever ends the client, no worker is left; of Ctrl-C the terminal shows one line of ours.
"""

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress

import fake_sweeps
import fakes
import pytest
from patience import PATIENCE
from sweeping import PIPES, is_alive, process, wait_for, workers_of
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.sweeps.pools import open_pool

pytestmark = [pytest.mark.end_to_end, pytest.mark.slow]

COMMAND = """import fake_sweeps, fibermelt.study.chain
fibermelt.study.chain.CHAIN = fake_sweeps.CHAIN
from fibermelt.__main__ import main
main()
"""
"""The command line with the chain that costs what it is told to."""

TAKES = {"FAKE_FLOW_TAKES": "0.05", "FAKE_MOTION_TAKES": "0.5"}
"""Cost [s] of the stages: a worker is never far from the end of what it is at."""

ENDLESS = fake_sweeps.SWEPT.replace("count = 24", "count = 1000")
"""Its 3000 cases with an answer take 750 s on two workers: it is ended before."""

SHELL_INTERRUPTED, SHELL_ENDED, SHELL_HUNG_UP = 130, 143, 129


def sweeping(tmp_path, **options):
    """Run ``fibermelt sweep`` on two workers in a process group of its own, as a shell does."""
    study = fake_sweeps.study_file(tmp_path, ENDLESS)
    arguments = ["-c", COMMAND, "sweep", study, "--out", tmp_path / "out", "--workers", "2"]
    options = {"start_new_session": True, **options}
    return process(arguments, options, FAKE_LOG=str(tmp_path / "log"), **TAKES)


def workers(tmp_path):
    return workers_of(tmp_path / "log")


@pytest.mark.parametrize("times", [1, 3])
def test_control_c_is_answered_by_one_line(tmp_path, times):
    """A terminal sends SIGINT to client and workers alike, also to one that replaced another."""
    with sweeping(tmp_path, **PIPES) as running:
        wait_for(lambda: len(workers(tmp_path)) == 2, "two workers", running)
        os.kill(min(workers(tmp_path)), signal.SIGKILL)
        wait_for(lambda: len(workers(tmp_path)) == 3, "a worker in place of it", running)
        for _ in range(times):
            os.killpg(running.pid, signal.SIGINT)
            # As fast as a hand is; what comes later finds the client gone.
            time.sleep(0.1)
        told, complaints = running.communicate(timeout=PATIENCE)
    assert (running.returncode, told) == (SHELL_INTERRUPTED, "")
    *progress, last = complaints.splitlines()
    assert [line for line in progress if not line.startswith("sweep: ")] == []
    out = tmp_path / "out"
    assert last == f"interrupted: finished cases are kept, fibermelt resume {out} goes on"
    assert not any(map(is_alive, workers(tmp_path)))


LOADING = """import os, signal, sys
class Presses:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            {what}
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Presses())
from fibermelt.__main__ import main
main()
"""
"""The command line, with Ctrl-C pressed as a module is about to be loaded."""

PRESSED = [
    # while the command line is loaded, and while a command loads what it needs
    ("typer", "pass"),
    ("fibermelt.sweeps.runner", "pass"),
    # Python would end by the signal after this, though it is caught
    ("fibermelt.sweeps.runner", "eval('os.kill(os.getpid(), signal.SIGINT)')"),
    # once more, in the last that Python does
    (
        "fibermelt.sweeps.runner",
        "__import__('atexit').register(os.kill, os.getpid(), signal.SIGINT)",
    ),
]


@pytest.mark.parametrize(("name", "what"), PRESSED)
def test_control_c_while_modules_are_loaded_ends_alike(tmp_path, name, what):
    script = LOADING.format(name=name, what=what)
    arguments = ["sweep", fake_sweeps.study_file(tmp_path), "--out", tmp_path / "out"]
    ended = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
        preexec_fn=fakes.hears_ctrl_c,
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (SHELL_INTERRUPTED, "", "")
    assert not (tmp_path / "out").exists()


def test_control_c_before_anything_is_written_says_so(tmp_path, monkeypatch):
    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("fibermelt.sweeps.runner.plan_sweep", interrupted)
    arguments = ["sweep", fake_sweeps.study_file(tmp_path), "--out", tmp_path / "out"]
    told = CliRunner().invoke(app, [*map(str, arguments)])
    assert told.exit_code == SHELL_INTERRUPTED
    assert told.stderr.splitlines()[-1] == "interrupted: nothing was begun"
    assert not (tmp_path / "out").exists()


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    """Return a folder for temporary files, and what sweeps have in it."""
    (tmp_path / "scratch").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "scratch"))
    return lambda: list((tmp_path / "scratch").glob("fibermelt-*"))


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, SHELL_ENDED), (signal.SIGHUP, SHELL_HUNG_UP)]
)
def test_a_signal_to_end_leaves_nothing_behind(tmp_path, scratch, number, code):
    """Neither workers nor what they wrote beside the results, whoever of them it reaches."""
    with sweeping(tmp_path, **PIPES) as running:
        wait_for(lambda: len(workers(tmp_path)) == 2, "two workers", running)
        assert len(scratch()) == 1
        # A terminal tells all of its processes, `kill` one of them.
        (os.killpg if number == signal.SIGHUP else os.kill)(running.pid, number)
        _, complaints = running.communicate(timeout=PATIENCE)
    assert running.returncode == code
    # Python's own tracker of semaphores may complain after us, of those that workers ended with.
    told = complaints.splitlines()
    assert any(one.startswith("interrupted: finished cases are kept") for one in told)
    assert not any(map(is_alive, workers(tmp_path)))
    assert scratch() == []


def test_what_a_killed_client_left_is_removed_by_the_next(tmp_path, scratch, monkeypatch):
    with sweeping(tmp_path, **PIPES) as running:
        wait_for(lambda: len(workers(tmp_path)) == 2, "two workers", running)
        running.kill()
    wait_for(lambda: not any(map(is_alive, workers(tmp_path))), "end of the workers")
    (left,) = scratch()
    monkeypatch.setattr("tempfile.tempdir", None)
    with open_pool(1, None, tmp_path):
        assert left not in scratch()
        assert len(scratch()) == 1
    assert scratch() == []


@pytest.mark.skipif(not hasattr(os, "login_tty"), reason="needs pseudo-terminals")
def test_a_closed_terminal_ends_a_sweep_in_order(tmp_path, scratch):
    terminal, ours = os.openpty()
    try:
        inside = {"start_new_session": False, "preexec_fn": lambda: os.login_tty(ours)}
        with sweeping(tmp_path, **inside) as running:
            os.close(ours)
            wait_for(lambda: len(workers(tmp_path)) == 2, "two workers", running)
            os.close(terminal)
            terminal = -1
            assert running.wait(PATIENCE) == SHELL_HUNG_UP
    finally:
        if terminal >= 0:
            os.close(terminal)
    wait_for(lambda: not any(map(is_alive, workers(tmp_path))), "end of the workers")
    assert scratch() == []


def test_a_second_sweep_does_not_complain_of_the_first(tmp_path):
    """The first has dask's usual port: that is a warning of dask's, and so an error here."""
    with socket.socket() as first:
        # Where somebody has it already, so much the better.
        with suppress(OSError):
            first.bind(("127.0.0.1", 8787))
            first.listen()
        with open_pool(1, None, tmp_path) as pool:
            assert pool.threads() == 1
