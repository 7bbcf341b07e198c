"""The commands for sweeps: what they print, what they refuse, and that a case is a run."""

import csv
import json
import re
import subprocess
import sys
from dataclasses import replace

import fake_sweeps
import numpy as np
import pytest
import xarray as xr
from coarse_runs import COARSE
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.study.chain import CHAIN

pytestmark = pytest.mark.end_to_end

SMALL = """preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.gap" = ["2 mm", "3 mm"]
"fiber.aspect_ratio" = [4, 6, 8]
"""


@pytest.fixture(autouse=True)
def cheap(monkeypatch):
    """Let the commands run the chain that costs nothing."""
    monkeypatch.setattr("fibermelt.study.chain.CHAIN", fake_sweeps.CHAIN)


def fibermelt(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def swept(tmp_path, text=SMALL):
    """Return a study file and the folder that its sweep was run into, in this process."""
    study, out = fake_sweeps.study_file(tmp_path, text), tmp_path / "out"
    done = fibermelt("sweep", study, "--out", out, "--workers", 0, "--json")
    summary = json.loads(done.stdout)
    assert (done.exit_code, done.stderr) == (int(summary["done"] < summary["cases"]), "")
    return study, out, summary


def test_a_sweep_tells_what_became_of_its_cases(tmp_path):
    study, out, summary = swept(tmp_path)
    assert set(summary) == {"cases", "done", "failed", "reused_stages", "wall_s"}
    assert (summary["cases"], summary["done"], summary["failed"]) == (6, 3, 3)
    assert summary["reused_stages"] == 0
    told = json.loads(fibermelt("status", out, "--json").stdout)
    assert {key: told[key] for key in ("cases", "done", "failed", "pending")} == {
        "cases": 6,
        "done": 3,
        "failed": 3,
        "pending": 0,
    }
    assert told["wall_s"] == summary["wall_s"]
    went_on = fibermelt("resume", out, "--workers", 0, "--json")
    assert (went_on.exit_code, went_on.stderr) == (1, "")
    again = json.loads(went_on.stdout)
    assert (again["done"], again["failed"], again["reused_stages"]) == (3, 3, 1)
    words = fibermelt("status", out).stdout
    assert "3 of 6 done, 3 failed, 0 to do" in words
    assert "3 failed: flow.gap = 0.002 m: no steady surface" in words
    assert "3 of 6 done" in fibermelt("sweep", study, "--out", out, "--workers", 0).stdout


GAPS = {"all": ("3 mm", 0), "some": ("2 mm, 3 mm", 1), "none": ("2 mm", 1)}
"""Gaps for two fibers, of which 2 mm has no steady surface, and what the exit code is."""


@pytest.mark.parametrize(("gaps", "code"), GAPS.values(), ids=GAPS)
@pytest.mark.parametrize("how", [[], ["--json"]], ids=["words", "json"])
def test_the_exit_code_says_whether_every_case_is_done(tmp_path, gaps, code, how):
    out = tmp_path / "out"
    over = ["--over", f"flow.gap={gaps}", "--over", "fiber.aspect_ratio=4, 6"]
    begun = fibermelt("sweep", "paper", *over, "--out", out, "--workers", 0, *how)
    told = [
        fibermelt("status", out, *how),
        fibermelt("resume", out, "--workers", 0, *how),
        fibermelt("collect", out, *how),
    ]
    assert [done.exit_code for done in (begun, *told)] == [code] * 4
    assert (out / "sweep.nc").exists()
    assert (out / "report.html").exists()


def test_a_sweep_tells_of_a_table_without_effect(tmp_path, monkeypatch):
    chain = fake_sweeps.CHAIN
    moist = Stage("voids", 1, ("voids.moisture",), (), fake_sweeps.flow)
    asked = Part("voids", ("voids",), lambda results: {}, lambda summary: [])
    both = replace(chain, stages=(*chain.stages, moist), parts=(*chain.parts, asked))
    monkeypatch.setattr("fibermelt.study.chain.CHAIN", both)
    study = fake_sweeps.study_file(
        tmp_path, SMALL.replace("[sweep]", "voids.moisture = 1e-3\n[sweep]")
    )
    done = fibermelt("sweep", study, "--out", tmp_path / "out", "--workers", 0, "--json")
    (line,) = done.stderr.splitlines()
    assert line.startswith("warning: [voids] is read by no part of this study")
    assert json.loads(done.stdout)["done"] == 3


def test_the_exit_code_of_a_sweep_that_is_not_finished(tmp_path):
    _, out, _ = swept(tmp_path, SMALL.replace('"2 mm", ', ""))
    for batch in (out / "cases").glob("batch-*.npz"):
        batch.unlink()
    assert json.loads(fibermelt("status", out, "--json").stdout)["pending"] == 3
    assert [fibermelt(name, out).exit_code for name in ("status", "collect")] == [1, 1]
    assert fibermelt("resume", out, "--workers", 0).exit_code == 0
    assert fibermelt("status", out).exit_code == 0


@pytest.mark.parametrize("name", ["status", "resume", "collect"])
def test_the_exit_code_where_there_is_no_sweep(tmp_path, name):
    assert fibermelt(name, tmp_path / "nothing").exit_code == 2


def test_progress_goes_to_standard_error(tmp_path):
    study = fake_sweeps.study_file(tmp_path, SMALL)
    done = fibermelt("sweep", study, "--out", tmp_path / "out", "--workers", 0)
    assert "sweep: 3 of 6 cases done, 3 failed" in done.stderr
    assert "sweep: " not in done.stdout


def test_a_plan_shows_what_is_shared_and_what_is_done(tmp_path):
    study = fake_sweeps.study_file(tmp_path, SMALL)
    out = tmp_path / "out"
    before = json.loads(fibermelt("plan", study, "--out", out, "--json").stdout)
    assert not out.exists()
    assert (before["cases"], before["shape"], before["pending"]) == (6, [2, 3], 6)
    assert before["stages"]["flow"] == {"results": 2, "kept": 2, "stored": 0}
    assert before["stages"]["motion"] == {"results": 6, "kept": 0, "stored": 0}
    fibermelt("sweep", study, "--out", out, "--workers", 0)
    after = json.loads(fibermelt("plan", study, "--out", out, "--json").stdout)
    assert (after["done"], after["failed"], after["pending"]) == (3, 3, 0)
    assert after["stages"]["flow"]["stored"] == 1
    assert [case["status"] for case in after["each"]] == ["failed"] * 3 + ["done"] * 3
    words = fibermelt("plan", study, "--out", out).stdout
    assert "6 (2 x 3): 3 done, 3 failed, 0 to do" in words
    assert "flow.gap = 3 mm, fiber.aspect_ratio = 8" in words


def test_a_grid_is_collected_over_its_axes(tmp_path):
    _, out, _ = swept(tmp_path)
    told = json.loads(fibermelt("collect", out, "--json").stdout)
    assert told == {"cases": 6, "done": 3, "failed": 3, "pending": 0, "file": str(out / "sweep.nc")}
    with xr.open_dataset(out / "sweep.nc", engine="h5netcdf") as found:
        assert found["product"].dims == ("flow.gap", "fiber.aspect_ratio")
        assert found["flow.gap"].values.tolist() == [0.002, 0.003]
        assert found["flow.gap"].attrs["units"] == "m"
        expected = 2 * 0.003 * np.sqrt([4, 6, 8])
        np.testing.assert_array_equal(found["product"].sel({"flow.gap": 0.003}), expected)
        assert np.isnan(found["product"].sel({"flow.gap": 0.002})).all()
        assert found["status"].values.tolist() == [["failed"] * 3, ["done"] * 3]
        assert "no steady surface" in str(found["reason"].values[0, 0])
        assert found["extreme_max"].sel(kind="max").shape == (2, 3)
        assert "path" not in found


def test_a_table_is_collected_by_its_suffix(tmp_path):
    _, out, _ = swept(tmp_path)
    table = tmp_path / "x.csv"
    for _ in range(2):  # the second takes the place of the first
        # three of its cases have no answer: 1, and the table is written all the same
        assert fibermelt("collect", out, "--to", table).exit_code == 1
    with table.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["status"] for row in rows] == ["failed"] * 3 + ["done"] * 3
    assert [float(row["fiber.aspect_ratio"]) for row in rows] == [4, 6, 8] * 2
    found = [float(row["product"]) for row in rows[3:]]
    assert found == pytest.approx(list(2 * 0.003 * np.sqrt([4, 6, 8])), rel=1e-15)
    assert rows[0]["product"] == ""
    assert "no steady surface" in rows[0]["reason"]
    table.write_text("a,b\n1,2\n")
    refused = fibermelt("collect", out, "--to", table)
    assert (refused.exit_code, table.read_text()) == (2, "a,b\n1,2\n")
    unknown = fibermelt("collect", out, "--to", tmp_path / "x.xlsx")
    assert (unknown.exit_code, (tmp_path / "x.xlsx").exists()) == (2, False)
    assert ".nc, .nc4, .h5, .hdf5, .csv" in " ".join(unknown.stderr.split())


def test_other_designs_are_collected_over_their_cases(tmp_path):
    text = (
        'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n'
        '"fiber.aspect_ratio" = { low = 2, high = 10 }\n'
        '"flow.gap" = { low = "3 mm", high = "4 mm" }\ndesign = "latin-hypercube"\nsamples = 5\n'
    )
    _, out, _ = swept(tmp_path, text)
    nowhere = fibermelt("collect", out, "--to", tmp_path / "mine" / "numbers.nc")
    assert nowhere.exit_code == 2
    assert "there is no folder" in nowhere.stderr
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    taken = fibermelt("collect", out, "--to", tmp_path / "mine/notes.txt")
    assert (taken.exit_code, (tmp_path / "mine/notes.txt").read_text()) == (2, "mine")
    fibermelt("collect", out, "--to", tmp_path / "mine" / "numbers.nc")
    with xr.open_dataset(tmp_path / "mine/numbers.nc", engine="h5netcdf") as found:
        assert found["product"].dims == ("case",)
        expected = 2 * found["flow.gap"] * np.sqrt(found["fiber.aspect_ratio"])
        np.testing.assert_allclose(found["product"], expected, rtol=1e-15)


def test_more_values_compute_what_is_new_only(tmp_path, monkeypatch):
    study, out, _ = swept(tmp_path)
    study.write_text(SMALL.replace("[4, 6, 8]", "[4, 5, 6, 8]"))
    log = tmp_path / "log"
    monkeypatch.setenv("FAKE_LOG", str(log))
    done = fibermelt("sweep", study, "--out", out, "--workers", 0, "--json")
    assert (json.loads(done.stdout)["done"], json.loads(done.stdout)["failed"]) == (4, 4)
    assert [line.split()[1] for line in log.read_text().splitlines()] == ["motion"]


def test_clean_takes_what_no_case_needs(tmp_path):
    study, out, _ = swept(tmp_path)
    study.write_text(SMALL.replace('"3 mm"', '"4 mm"'))
    fibermelt("sweep", study, "--out", out, "--workers", 0)
    before = {path for path in out.rglob("*") if path.is_file()}
    told = json.loads(fibermelt("clean", out, "--json").stdout)
    kinds = {name.split("-")[0] for name in told["unneeded"]}
    assert kinds == {"cases/batch", "stages/flow"}
    assert (told["removed"], {path for path in out.rglob("*") if path.is_file()}) == (False, before)
    told = json.loads(fibermelt("clean", out, "--yes", "--json").stdout)
    assert told["removed"]
    assert not any((out / name).exists() for name in told["unneeded"])
    status = json.loads(fibermelt("status", out, "--json").stdout)
    assert (status["done"], status["failed"]) == (3, 3)
    assert "nothing to remove" in fibermelt("clean", out).stdout


def test_clean_keeps_the_run_on_show(tmp_path, monkeypatch):
    monkeypatch.setattr("fibermelt.report.page.draw", lambda results, folder: [])
    monkeypatch.setattr("fibermelt.report.page.render", lambda *of_the_run: b"<html/>")
    _, out, _ = swept(tmp_path)
    shown = fibermelt("run", "paper", "--out", out, "-s", "flow.gap=3.7 mm")
    assert shown.exit_code == 0, shown.stderr
    assert json.loads(fibermelt("clean", out, "--json").stdout)["unneeded"] == []


MISTAKES = [
    (("run", "STUDY"), r"swept.toml: has a table \[sweep\].*fibermelt sweep"),
    (("sweep", "paper", "--out", "OUT"), "paper: has no table .sweep.*fibermelt run"),
    (("sweep", "STUDY", "--out", ""), "--out .*no name of a folder"),
    (("sweep", "STUDY", "--out", "OUT", "--workers", "-1"), "--workers -1: must be at least 0"),
    (("sweep", "STUDY", "--out", "OUT", "--scheduler", "nowhere"), "nowhere: neither an address"),
    (
        ("sweep", "STUDY", "--out", "OUT", "--scheduler", "tcp://h:1", "--workers", "2"),
        "--workers 2 with --scheduler",
    ),
    (("status", "OUT"), "no such folder"),
    (("resume", "OUT"), "no such folder"),
    (("collect", "OUT"), "no such folder"),
    (("clean", "OUT"), "no such folder"),
]


@pytest.mark.parametrize(("arguments", "said"), MISTAKES)
def test_mistakes_are_one_line(tmp_path, arguments, said):
    places = {"STUDY": fake_sweeps.study_file(tmp_path, SMALL), "OUT": tmp_path / "out"}
    done = fibermelt(*(places.get(argument, argument) for argument in arguments))
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()[-1:]
    assert line.startswith("error: ")
    assert re.search(said, line), line


def test_a_scheduler_is_never_taken_from_the_results(tmp_path):
    study, out, _ = swept(tmp_path)
    (out / "scheduler.json").write_text('{"address": "tcp://127.0.0.1:1"}')
    study.write_text(SMALL.replace("8]", "9]"))
    done = fibermelt("sweep", study, "--out", out, "--scheduler", out / "scheduler.json")
    assert done.exit_code == 2
    assert "lies in the results folder" in done.stderr


def test_help_does_not_load_the_cluster():
    script = (
        "import sys, fibermelt.cli, fibermelt.sweeps.runner\n"
        "sys.exit(str([m for m in ('distributed', 'xarray') if m in sys.modules]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.stderr.strip() == "[]"


def test_a_case_has_the_numbers_of_a_run(tmp_path, monkeypatch):
    """The coarse flow of the tests, two fibers: the numbers of a case are those of its run."""
    monkeypatch.setattr("fibermelt.study.chain.CHAIN", CHAIN)
    coarse = COARSE.read_text()
    study, out = tmp_path / "swept.toml", tmp_path / "out"
    study.write_text(f'{coarse}[sweep]\n"fiber.aspect_ratio" = [4, 6]\n')
    model = ("-s", "fiber.model=spheroid")
    done = fibermelt("sweep", study, "--out", out, "--workers", 0, *model, "--json")
    assert json.loads(done.stdout)["done"] == 2, done.stderr
    fibermelt("collect", out)
    plain = COARSE
    ran = fibermelt("run", plain, "--out", out, *model, "-s", "fiber.aspect_ratio=6")
    assert "flow: reused" in ran.stderr
    with (
        xr.open_dataset(out / "sweep.nc", engine="h5netcdf") as collected,
        xr.open_dataset(out / "results.nc", engine="h5netcdf") as results,
    ):
        case = collected.sel({"fiber.aspect_ratio": 6.0})
        extreme = results["extreme"].min("initial_angle")
        np.testing.assert_array_equal(case["extreme_min"], extreme)
        for name in ("bead_height", "shape_factor", "zone_time", "extreme_quantiles"):
            np.testing.assert_array_equal(case[name], results[name])
