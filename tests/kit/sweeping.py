"""Sweeps in processes of their own: started, waited for, and gone at the end."""

import os
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import fake_sweeps
import pytest
from patience import PATIENCE

PIPES = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}


@contextmanager
def process(arguments, options=PIPES, **environment):
    """Run Python in a process of its own, of which nothing is left at the end."""
    here = str(Path(fake_sweeps.__file__).parent)
    path = os.pathsep.join([here, *filter(None, [os.environ.get("PYTHONPATH")])])
    running = subprocess.Popen(
        [sys.executable, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": path, **environment},
        text=True,
        **options,
    )
    try:
        yield running
    finally:
        running.kill()
        running.communicate(timeout=PATIENCE)


def wait_for(condition, what, running=None):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if running is not None and running.poll() is not None:
            pytest.fail(f"ended before {what}: {running.communicate()}")
        assert time.monotonic() < deadline, f"no {what} in {PATIENCE} s"
        time.sleep(0.01)


def gate(folder, after):
    """Return a file, and the environment in which stages after so many wait until it is there."""
    path = folder / "gate"
    return path, {"FAKE_GATE": str(path), "FAKE_GATE_AFTER": str(after)}


def lines(log):
    return log.read_text().splitlines() if log.exists() else []


def workers_of(log):
    """Return the processes that computed something so far."""
    return sorted({int(line.split()[0]) for line in lines(log)})


def is_alive(pid):
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):  # the second if it goes while it is read
        return False
