"""A second process beside a run: the same results, whatever becomes of it."""

import sys
import time
from dataclasses import replace
from pathlib import Path

import fakes
import pytest
from patience import PATIENCE

from fibermelt.engine import runner
from fibermelt.engine.helper import Helper, HelperLostError, helped, one_helper
from fibermelt.errors import ConvergenceError

FLOW, CELL, MOTION = fakes.STAGES
CHAIN = replace(
    fakes.CHAIN, stages=(CELL, FLOW, replace(MOTION, version=2, inputs=("cell", "flow")))
)
"""A helper begins at the end with what waits for nothing: with the flow."""


@pytest.fixture(autouse=True)
def _helped(monkeypatch):
    """Start a helper for two stages, on a machine of two cores, that knows the tests' stages."""
    monkeypatch.setattr(runner, "WORTH_A_HELPER", 2)
    monkeypatch.setattr(runner, "cores", lambda: 2)
    monkeypatch.setenv("PYTHONPATH", str(Path(fakes.__file__).parent))


def stored(folder):
    return {path.parent.name: path.read_bytes() for path in folder.glob("stages/*/data.nc")}


@pytest.fixture
def alone(tmp_path, monkeypatch):
    """What one process stores."""
    with monkeypatch.context() as patched:
        patched.setattr(runner, "cores", lambda: 1)
        fakes.run(tmp_path / "alone", chain=CHAIN)
    return stored(tmp_path / "alone")


def test_a_helper_does_its_share_and_says_so(tmp_path, monkeypatch, alone):
    """The process here waits until the other has stored its stage."""
    out, here, execute = tmp_path / "out", [], runner.execute

    def slow(stage, *asked):
        end = time.monotonic() + PATIENCE
        while not list(out.glob("stages/flow-*")) and time.monotonic() < end:
            time.sleep(0.01)
        here.append(stage.name)
        return execute(stage, *asked)

    monkeypatch.setattr(runner, "execute", slow)
    notes = fakes.run(out, chain=CHAIN)
    assert stored(out) == alone
    assert here[0] == "cell"
    assert "flow" not in here
    assert "flow: mesh 1 of 1, Newton step 1: residual 1.0e-10" in notes.lines


def test_without_an_answer_of_the_helper_all_is_done_here(tmp_path, monkeypatch, alone):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    fakes.run(tmp_path / "out", chain=CHAIN)
    assert stored(tmp_path / "out") == alone


def test_what_fails_beside_is_told_as_if_it_failed_here(tmp_path):
    with pytest.raises(ConvergenceError, match="no steady surface; try a larger gap"):
        fakes.run(tmp_path / "out", "flow.gap=2 mm", chain=CHAIN)


def test_what_fails_here_ends_the_helper(tmp_path, monkeypatch):
    def fails(*asked):
        msg = "here"
        raise ConvergenceError(msg)

    monkeypatch.setattr(runner, "execute", fails)
    monkeypatch.setenv("FAKE_MOTION_WAITS", str(tmp_path / "never"))
    with pytest.raises(ConvergenceError, match="here"):
        fakes.run(tmp_path / "out", chain=CHAIN)


def test_a_disk_that_is_full_for_what_the_helper_found_ends_the_run(tmp_path, monkeypatch):
    save = runner.Store.save

    def full(store, record, data, *, replace):
        if record.stage == "flow":
            raise OSError(28, "No space left on device")
        return save(store, record, data, replace=replace)

    monkeypatch.setattr(runner.Store, "save", full)
    with pytest.raises(OSError, match="No space left"):
        fakes.run(tmp_path / "out", chain=CHAIN)


def test_what_cannot_be_handed_over_is_lost():
    helper = Helper()
    with pytest.raises(HelperLostError):
        helper.call("operator:add", lambda: None)
    helper.kill()
    helper.close()


def test_one_after_the_other_is_helped_by_one_process():
    found = []

    def work(helper):
        found.append(helper.call("fakes:process_of"))

    with one_helper():
        for _ in range(2):
            with helped(work):
                pass
    with helped(work):
        pass
    assert found[0] == found[1] != found[2]


def test_who_is_lost_helps_nobody_else():
    found = []

    def is_lost(helper):
        with pytest.raises(HelperLostError):
            helper.call("operator:add", lambda: None)

    def work(helper):
        found.append(helper.call("fakes:process_of"))

    with one_helper():
        with helped(is_lost):
            pass
        with helped(work):
            pass
    assert len(found) == 1
