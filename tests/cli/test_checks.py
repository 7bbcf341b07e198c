"""`fibermelt verify`: the quick ladder passes here, and a failure is told and exits with 1."""

import json

import pytest
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.errors import ConvergenceError
from fibermelt.verify import Rung, below, rungs

pytestmark = pytest.mark.end_to_end

BOUND = below("a bound", "This with that.", "a book", 1e-3, "a tenth of it")


def fibermelt(*arguments):
    return CliRunner().invoke(app, list(arguments))


def ladder(monkeypatch, measure, quick=True):
    monkeypatch.setattr(rungs, "LADDER", (Rung("flow", (BOUND,), measure, quick),))


def test_the_quick_ladder_passes():
    done = fibermelt("verify", "--quick", "--json")
    answer = json.loads(done.stdout)
    assert [check["name"] for check in answer["checks"] if not check["passed"]] == []
    assert done.exit_code == 0
    quick = sum(len(rung.expected) for rung in rungs.LADDER if rung.quick)
    assert (answer["passed"], answer["failed"]) == (quick, 0)
    assert "flow: die swell" in done.stderr


def test_a_failure_exits_with_1(monkeypatch):
    ladder(monkeypatch, lambda: (2e-3,))
    done = fibermelt("verify")
    assert done.exit_code == 1
    assert "FAIL  flow  a bound" in done.stdout
    assert "0 of 1 checks pass" in done.stdout
    answer = json.loads(fibermelt("verify", "--json").stdout)
    assert (answer["failed"], answer["checks"][0]["value"]) == (1, 2e-3)


def test_a_check_that_cannot_be_done_exits_with_1_and_its_reason(monkeypatch):
    def refuse():
        msg = "no steady surface"
        raise ConvergenceError(msg)

    ladder(monkeypatch, refuse)
    done = fibermelt("verify")
    assert done.exit_code == 1
    assert "no steady surface" in done.stdout


@pytest.mark.parametrize(("flags", "count"), [((), 1), (("--quick",), 0)])
def test_quick_leaves_out_the_slow_ones(monkeypatch, flags, count):
    ladder(monkeypatch, lambda: (0.0,), quick=False)
    done = fibermelt("verify", "--json", *flags)
    assert done.exit_code == 0
    assert len(json.loads(done.stdout)["checks"]) == count


def test_interrupted(monkeypatch):
    def stop():
        raise KeyboardInterrupt

    ladder(monkeypatch, stop)
    assert fibermelt("verify").exit_code == 130


def test_a_study_stores_the_ladder_and_a_failure_stops_nothing(monkeypatch, tmp_path):
    rungs_of = [
        Rung("flow", (BOUND,), lambda: (2e-3,), quick=True, brief=True),
        Rung("flow", (BOUND,), lambda: (0.0,), quick=False),
    ]
    monkeypatch.setattr(rungs, "LADDER", rungs_of)
    run = ("run", "paper", "-s", 'study.parts=["verification"]', "--out", str(tmp_path / "out"))
    done = fibermelt(*run)
    assert done.exit_code == 0
    assert "verification    0 of 1 checks pass (brief ladder)" in done.stdout
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["verification"]["checks"][0]["value"] == 2e-3
    assert "up to date" in fibermelt(*run).stderr
    longer = fibermelt(*run, "-s", "study.ladder=full")
    assert "1 of 2 checks pass (full ladder)" in longer.stdout
