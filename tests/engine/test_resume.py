"""A run that is killed or interrupted loses at most the stage that it was in."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import fakes
import pytest
from patience import PATIENCE

pytestmark = pytest.mark.end_to_end


def start_and_wait_in_motion(folder, marker):
    process = subprocess.Popen(
        [sys.executable, Path(fakes.__file__), folder],
        env={**os.environ, "FAKE_MOTION_WAITS": str(marker)},
        stderr=subprocess.PIPE,
        preexec_fn=fakes.hears_ctrl_c,  # noqa: PLW1509  no thread is about here
    )
    deadline = time.monotonic() + PATIENCE
    while not marker.exists():
        assert process.poll() is None, process.stderr.read().decode()
        assert time.monotonic() < deadline, "the stage was not reached"
        time.sleep(0.02)
    return process


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_finished_stages_survive(tmp_path, how):
    process = start_and_wait_in_motion(tmp_path / "out", tmp_path / "marker")
    process.send_signal(how)
    process.communicate(timeout=PATIENCE)
    assert not (tmp_path / "out/summary.json").exists()
    notes = fakes.run(tmp_path / "out")
    assert notes.reused() == ["flow", "cell"]
    assert (tmp_path / "out/summary.json").exists()


def test_leftovers_of_a_killed_run_are_removed(tmp_path):
    fakes.run(tmp_path / "out")
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    host = os.uname().nodename.replace("-", "_")
    for folder in ("out", "out/stages"):
        leftover = tmp_path / folder / f".partial-{host}-{dead.pid}-0badcafe"
        leftover.mkdir()
        (leftover / "data.nc").write_bytes(b"half")
    fakes.run(tmp_path / "out")
    assert not list(tmp_path.rglob(".partial-*"))


def test_what_a_living_process_writes_is_left_alone(tmp_path):
    fakes.run(tmp_path / "out")
    host = os.uname().nodename.replace("-", "_")
    being_written = tmp_path / f"out/stages/.partial-{host}-{os.getppid()}-0badcafe"
    being_written.mkdir()
    fakes.run(tmp_path / "out")
    assert being_written.exists()


def test_killed_while_publishing(tmp_path, monkeypatch):
    """Results on show may then be of two runs: the next run notices, and writes them all."""
    fakes.run(tmp_path / "out")

    def die(path, content):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("fibermelt.engine.outputs.write_sealed", die)
        # Both stages are there: the only sealed file left to write is the list of outputs.
        fakes_run_interrupted(tmp_path / "out")
    assert fakes.run(tmp_path / "out").reused() == ["flow", "cell", "motion"]
    assert fakes.run(tmp_path / "out").lines == [
        "study: nothing has changed: all results are up to date"
    ]


def fakes_run_interrupted(folder):
    (folder / "figures/bead.svg").unlink()
    with pytest.raises(KeyboardInterrupt):
        fakes.run(folder)


def test_runs_that_share_a_folder_do_not_harm_each_other(tmp_path):
    command = [sys.executable, fakes.__file__, tmp_path / "out"]
    together = [subprocess.Popen(command, stderr=subprocess.PIPE) for _ in range(3)]
    for process in together:
        _, said = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0, said.decode()
    assert fakes.run(tmp_path / "out").lines == [
        "study: nothing has changed: all results are up to date"
    ]
    assert not list(tmp_path.rglob(".partial-*"))
