"""What the commands for sweeps say to who meets them first, and what they foretell."""

import json
import re

import fake_sweeps
import pytest
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.files import read_sealed, write_sealed
from fibermelt.engine.store import Store
from fibermelt.study.loading import load_study
from fibermelt.sweeps.cost import estimate
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import plan_sweep
from fibermelt.sweeps.progress import Progress, read_progress, write_progress
from fibermelt.sweeps.status import sweep_status
from fibermelt.sweeps.store import CaseStore

pytestmark = pytest.mark.end_to_end

GRID = """preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.bed_speed, flow.inlet_speed" = [["101.6 mm/s", "24 mm/s"], ["50.8 mm/s", "12 mm/s"]]
"flow.gap" = ["2.5 mm", "3 mm", "3.5 mm"]
"""

CHAINED = """preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.gap" = ["3 mm", "3.9 mm", "5 mm", "6.4 mm"]
"fiber.aspect_ratio" = [4, 8]
"""
"""Each gap within reach of the next only: 3.9 mm is from cold, and one way has two steps."""

WIDE = "1000"
"""Columns of a terminal that breaks no line: what is said is looked for, not where it is broken."""

COLD, WARM, CASE = 30.0, 12.0, 0.5
"""Cost of flows and of a case [s], as made up as the chain."""


@pytest.fixture(autouse=True)
def cheap(monkeypatch):
    """Let the commands run the chain that costs nothing."""
    monkeypatch.setattr("fibermelt.study.chain.CHAIN", fake_sweeps.CHAIN)
    monkeypatch.setenv("COLUMNS", WIDE)


def fibermelt(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_validate_says_that_a_study_is_a_sweep(tmp_path):
    study = fake_sweeps.study_file(tmp_path, GRID)
    done = fibermelt("validate", study)
    assert (done.exit_code, done.stderr) == (0, "")
    over = "flow.bed_speed with flow.inlet_speed x flow.gap"
    assert f"a valid sweep of 6 cases over {over} (swept.toml, preset paper)" in done.stdout
    assert json.loads(fibermelt("validate", study, "--json").stdout)["cases"] == 6
    assert "cases" not in json.loads(fibermelt("validate", "paper", "--json").stdout)
    study.write_text(f'{GRID}design = "one-at-a-time"\n')
    assert "6 cases over flow.bed_speed with" in fibermelt("validate", study).stdout
    assert "flow.gap (one-at-a-time)" in fibermelt("validate", study).stdout


def test_validate_looks_at_every_case(tmp_path):
    study = fake_sweeps.study_file(tmp_path, GRID.replace("3.5 mm", "-1 mm"))
    done = fibermelt("validate", study)
    assert done.exit_code == 2
    assert re.match(r"error: case 3 of the sweep .*flow.gap", done.stderr)


@pytest.mark.parametrize("command", ["report", "status", "resume", "collect", "clean"])
def test_a_file_is_not_taken_for_a_folder_that_is_not_there(tmp_path, command):
    study = fake_sweeps.study_file(tmp_path, GRID)
    done = fibermelt(command, study)
    assert done.exit_code == 2
    assert f"{study}: is a file, not a results folder" in done.stderr
    assert "no such folder" in fibermelt(command, tmp_path / "nowhere").stderr


def test_clean_is_for_any_results_folder():
    told = fibermelt("clean", "--help").stdout
    assert "Results folder of runs, of a sweep, or of both." in told


def test_a_damaged_folder_is_named_in_the_way_out(tmp_path):
    study, out = fake_sweeps.study_file(tmp_path, GRID), tmp_path / "out"
    fake_sweeps.sweep(study, out)
    victim = min(out.glob("cases/batch-*"))
    victim.write_bytes(victim.read_bytes()[:-7])
    assert f"fibermelt resume {out} computes" in fibermelt("collect", out).stderr
    (out / "sweep.json").write_text("{}")
    assert f"--out {out} again" in fibermelt("status", out).stderr


def test_the_results_folder_has_the_name_of_the_study(tmp_path, monkeypatch):
    study = fake_sweeps.study_file(tmp_path, GRID)
    monkeypatch.chdir(tmp_path)
    done = fibermelt("sweep", study, "--workers", 0)
    assert (done.exit_code, "6 of 6 done" in done.stdout) == (0, True)
    assert (tmp_path / "results" / "swept" / "report.html").exists()
    assert "6 done, 0 failed, 0 to do" in fibermelt("plan", study).stdout


def test_a_sweep_tells_how_far_its_stages_are(tmp_path, monkeypatch):
    monkeypatch.setattr("fibermelt.sweeps.runner.TELL", 0.0)
    told = []
    monkeypatch.setattr(fake_sweeps.Notes, "tick", lambda self, *line: told.append(line))
    fake_sweeps.sweep(fake_sweeps.study_file(tmp_path, CHAINED), tmp_path / "out")
    lines = [line for stage, line in told if stage == "sweep"]
    assert any(line.startswith("0 of 8 cases, flow 1 of 4") for line in lines), lines


def test_a_sweep_needs_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    over = ("--over", "flow.gap=3 mm, 3.2 mm", "--over", "fiber.aspect_ratio=4, 6")
    assert "a valid sweep of 4 cases" in fibermelt("validate", "paper", *over).stdout
    assert json.loads(fibermelt("plan", "paper", *over, "--json").stdout)["shape"] == [2, 2]
    done = fibermelt("sweep", "paper", *over, "--out", "out", "--workers", 0, "--json")
    assert json.loads(done.stdout)["done"] == 4
    assert json.loads(fibermelt("resume", "out", "--workers", 0, "--json").stdout)["done"] == 4


def records(out):
    return {record.key: record for record, _ in Store(out, ()).records()}


def planned(study):
    swept = load_study(str(study))
    return plan_sweep(read_sweep(swept), swept, fake_sweeps.CHAIN)


@pytest.fixture
def chained(tmp_path):
    study, out = fake_sweeps.study_file(tmp_path, CHAINED), tmp_path / "out"
    fake_sweeps.sweep(study, out)
    return study, out


def test_a_stored_flow_tells_from_which_it_started(chained):
    study, out = chained
    found = records(out)
    started = {key: job.neighbour for key, job in planned(study).jobs.items()}
    assert {key: record.neighbour for key, record in found.items()} == started
    assert sum(not key for key in started.values()) == 1
    told = sweep_status(out)["stages"]["flow"]
    assert (told["needed"], told["stored"], told["from_neighbour"]) == (4, 4, 3)
    assert "flow            4 of 4 stored, 3 from a neighbour" in fibermelt("status", out).stdout
    assert told["processor"] == sum(record.processor for record in found.values())


def test_a_flow_whose_neighbour_failed_tells_that_it_started_from_cold(tmp_path):
    text = CHAINED.replace('"3 mm", "3.9 mm", "5 mm", "6.4 mm"', '"2 mm", "2.5 mm"')
    study, out = fake_sweeps.study_file(tmp_path, text), tmp_path / "out"
    fake_sweeps.sweep(study, out)
    (record,) = records(out).values()
    assert planned(study).jobs[record.key].neighbour
    assert record.neighbour == ""


def change(out, **values):
    """Change what all records say, as if they had been written so; None takes it away."""
    for path in out.glob("stages/flow-*/record.json"):
        content = read_sealed(path)
        for name, value in values.items():
            content[name] = value(content) if callable(value) else value
        write_sealed(path, {name: value for name, value in content.items() if value is not None})


def test_records_from_before_are_read(chained):
    study, out = chained
    change(out, neighbour=None, processor=None)
    assert all(record.neighbour == "" for record in records(out).values())
    summary, said = fake_sweeps.sweep(study, out)
    assert (summary["done"], summary["reused_stages"]) == (8, 4)
    assert not any("damaged" in line for line in said)


@pytest.fixture
def costly(chained):
    """A sweep that cost what it never did; a second one that has some flows in common with it."""
    study, out = chained
    change(out, cost=lambda content: WARM if content["neighbour"] else COLD)
    write_progress(CaseStore(out), Progress(cases=8, cases_s=8 * CASE))
    study.write_text(CHAINED.replace('"6.4 mm"', '"6.4 mm", "8.2 mm", "10.5 mm"'))
    return study, out


@pytest.mark.parametrize("workers", [1, 100])
def test_the_rest_will_cost_what_like_stages_did(costly, workers):
    """Two flows are new, one behind the other, with two cases each."""
    study, out = costly
    plan = planned(study)
    pending = [case for case in plan.cases if case.point["flow.gap"] > 7e-3]
    flows = {path.name: path for path in out.glob("stages/flow-*")}
    size = sum(file.stat().st_size for path in flows.values() for file in path.iterdir())
    batches = sum(path.stat().st_size for path in out.glob("cases/batch-*"))
    found = estimate(plan, out, pending, workers)
    new = [plan.jobs[case.keys["flow"]] for case in pending[::2]]
    assert new[1].neighbour == new[0].key
    assert found.work == pytest.approx(2 * WARM + 4 * CASE)
    expected = found.work if workers == 1 else 2 * WARM + CASE
    assert found.wall == pytest.approx(expected)
    # Each flow and each case as large as those there are, to the byte that rounding takes.
    assert found.size == pytest.approx(2 * size / 4 + 4 * batches / 8, abs=1)
    assert found.unknown == ()


def test_a_plan_foretells_time_and_disk(costly):
    study, out = costly
    told = fibermelt("plan", study, "--out", out, "--workers", 1).stdout
    assert re.search(r"to do +about 26 s on 1 worker, \d+ kB, as what is stored took\n", told)
    listed = json.loads(fibermelt("plan", study, "--out", out, "--workers", 1, "--json").stdout)
    assert listed["estimate"]["work"] == pytest.approx(2 * WARM + 4 * CASE)
    assert "flow.gap = 3.9 mm, fiber.aspect_ratio = 4\n" in told


def test_a_plan_says_what_it_cannot_foretell(costly, tmp_path):
    study, out = costly
    write_progress(CaseStore(out), Progress())
    told = fibermelt("plan", study, "--out", out, "--workers", 1).stdout
    assert "about 24 s on 1 worker" in told
    assert "not counted, as none is there yet: cases" in told
    told = fibermelt("plan", study, "--out", tmp_path / "empty").stdout
    assert "how long it takes is told once the folder has some of its flow" in told


def test_a_plan_has_the_units_and_words_of_a_study(tmp_path):
    text = CHAINED.replace('"fiber.aspect_ratio" = [4, 8]', '"melt.temperature" = ["225 degC"]')
    told = fibermelt("plan", fake_sweeps.study_file(tmp_path, text), "--out", tmp_path / "o").stdout
    assert "flow.gap = 6.4 mm, melt.temperature = 225 °C\n" in told
    assert re.search(r"once the folder has some of its .*\bflow from a neighbour,", told)
    assert "warm" not in told


def test_lines_are_as_long_as_the_terminal_is_wide(chained, monkeypatch):
    study, out = chained
    commands = (
        ("plan", study, "--out", out),
        ("validate", study),
        ("status", out),
        ("collect", out),
    )
    for command in commands:
        monkeypatch.setenv("COLUMNS", WIDE)
        whole = fibermelt(*command).stdout
        monkeypatch.setenv("COLUMNS", "80")
        told = fibermelt(*command).stdout
        assert told.split() == whole.split()
        # Paths are never broken.
        long = [line for line in told.splitlines() if len(line) > 80]
        assert [line for line in long if str(out) not in line and str(study) not in line] == []


@pytest.mark.parametrize("command", ["resume", "status", "report", "clean", "collect", "voids"])
def test_an_empty_name_of_a_folder_is_told_as_such(command):
    done = fibermelt(command, " ")
    assert done.exit_code == 2
    assert 'DIR "": is no name of a folder' in done.stderr
    assert "--out" not in done.stderr


def test_a_folder_is_no_file_to_collect_into(chained, tmp_path):
    _, out = chained
    (tmp_path / "mine").mkdir()
    done = fibermelt("collect", out, "--to", tmp_path / "mine")
    assert done.exit_code == 2
    told = f"--to {tmp_path}/mine: is a folder; name a file, such as {tmp_path}/mine/sweep.nc"
    assert told in done.stderr


def test_one_case_is_one_case(tmp_path):
    study = fake_sweeps.study_file(
        tmp_path, 'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n"flow.gap" = ["3 mm"]\n'
    )
    done = fibermelt("sweep", study, "--out", tmp_path / "out", "--workers", 0)
    assert "sweep: 1 case\n" in done.stderr
    assert "sweep: 1 of 1 case done, 0 failed" in done.stderr
    assert "1 of 1 case has an answer" in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_what_cases_cost_is_added_up_over_runs(tmp_path):
    study, out = fake_sweeps.study_file(tmp_path, GRID), tmp_path / "out"
    fake_sweeps.sweep(study, out)
    first = read_progress(CaseStore(out))
    assert (first.cases, first.cases_s > 0) == (6, True)
    study.write_text(GRID.replace('"3.5 mm"', '"3.5 mm", "4 mm"'))
    fake_sweeps.sweep(study, out)
    second = read_progress(CaseStore(out))
    assert (second.cases, second.cases_s > first.cases_s) == (8, True)
    assert second.software["fibermelt"]
