"""The report of a sweep from end to end: a chain that costs nothing, and real fibers."""

import json
import re

import fake_sweeps
import pytest
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep

pytestmark = pytest.mark.end_to_end

FAKE = """preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.gap" = ["2 mm", "3 mm"]
"fiber.aspect_ratio" = [4, 6, 8]
"""

FIBERS = """preset = "paper"
[study]
parts = ["interaction", "claims"]
[sweep]
"fiber.aspect_ratio" = [4, 6]
"interaction.volume_fraction" = [0.05, 0.084]
"""

SHIPPED = {
    "window": 9,
    "viscosity-speed": 9,
    "aspect-content": 9,
    "nozzle": 11,
    "population": 64,
    "uncertain": 128,
}


def fibermelt(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def cheap(monkeypatch):
    monkeypatch.setattr("fibermelt.study.chain.CHAIN", fake_sweeps.CHAIN)
    # What is said is looked for, not where it is broken.
    monkeypatch.setenv("COLUMNS", "1000")


@pytest.mark.usefixtures("cheap")
def test_a_sweep_ends_with_its_report(tmp_path):
    study, out = fake_sweeps.study_file(tmp_path, FAKE), tmp_path / "out"
    done = fibermelt("sweep", study, "--out", out, "--workers", 0)
    names = [line.split()[0] for line in done.stdout.splitlines()]
    assert done.exit_code == 1
    assert [names.count(name) for name in ("cases", "results", "report")] == [1, 1, 1]
    assert "aspect ratio from" in done.stdout
    page = (out / "report.html").read_bytes()
    assert b"3 of 6 cases have an answer, 3 failed" in page
    assert b"flow.gap = 0.002 m: no steady surface" in page
    (out / "report.html").unlink()
    answer = json.loads(fibermelt("report", out, "--json").stdout)
    assert answer == {"report": str(out / "report.html"), "bytes": len(page)}
    assert (out / "report.html").read_bytes() == page


@pytest.mark.usefixtures("cheap")
def test_a_damaged_folder_gives_no_report(tmp_path):
    study, out = fake_sweeps.study_file(tmp_path, FAKE), tmp_path / "out"
    fibermelt("sweep", study, "--out", out, "--workers", 0)
    batch = next((out / "cases").glob("batch-*.npz"))
    batch.write_bytes(batch.read_bytes()[:-20])
    before = (out / "report.html").read_bytes()
    refused = fibermelt("report", out)
    assert refused.exit_code == 2
    assert "is damaged" in refused.stderr
    assert (out / "report.html").read_bytes() == before


def test_a_run_into_the_folder_of_a_sweep_keeps_its_own_report(tmp_path):
    study, out = fake_sweeps.study_file(tmp_path, FIBERS), tmp_path / "out"
    assert fibermelt("sweep", study, "--out", out, "--workers", 0).exit_code == 0
    swept = (out / "report.html").read_bytes()
    study.write_text(FIBERS.partition("[sweep]")[0])
    assert fibermelt("run", study, "--out", out).exit_code == 0
    run = (out / "report.html").read_bytes()
    assert run != swept
    answer = json.loads(fibermelt("report", out, "--json").stdout)
    assert answer["sweep_report"] == str(out / "sweep.html")
    assert (out / "report.html").read_bytes() == run
    assert (out / "sweep.html").read_bytes() == swept


def test_fibers_are_swept_into_a_report_with_claims(tmp_path):
    study, out = fake_sweeps.study_file(tmp_path, FIBERS), tmp_path / "out"
    done = fibermelt("sweep", study, "--out", out, "--workers", 0)
    assert (done.exit_code, "4 of 4 done" in done.stdout) == (0, True)
    page = (out / "report.html").read_text("utf-8")
    words = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))
    assert "2 × 2 cases: every combination." in words
    # Bay's coefficient is that of the paper's content and aspect ratio, and of no other.
    row = re.search(r"<code class=\"key\">interaction-coefficient</code>.*?</tr>", page, re.S)
    assert "depends on aspect ratio, volume fraction" in row[0]
    assert row[0].count('<span class="heard">holds</span>') == 1
    assert row[0].count('<span class="heard">differs</span>') == 3


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_sweeps_are_valid_in_every_case(name):
    assert len(read_sweep(load_study(name)).cases()) == SHIPPED[name]
