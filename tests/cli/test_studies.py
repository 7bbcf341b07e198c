"""The command line: what it prints, where, and with which exit code."""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import fakes
import pytest
from patience import PATIENCE
from typer.testing import CliRunner

from fibermelt.cli import app

pytestmark = pytest.mark.end_to_end


def fibermelt(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_validate(tmp_path):
    study = tmp_path / "mine.toml"
    study.write_text('preset = "paper"\nstudy.parts = ["bead"]\n[flow]\ngap = "3.5 mm"\n')
    done = fibermelt("validate", study)
    assert (done.exit_code, done.stderr) == (0, "")
    # Where the line is broken depends on how long the path is.
    assert "valid study (mine.toml, preset paper)" in " ".join(done.stdout.split())
    done = fibermelt("validate", study, "-s", "fiber.aspect_ratio=8", "--json")
    resolved = json.loads(done.stdout)
    assert (resolved["flow.gap"], resolved["fiber.aspect_ratio"]) == (0.0035, 8.0)


@pytest.mark.parametrize("command", ["validate", "plan"])
def test_a_table_without_effect_is_told(tmp_path, command):
    study = tmp_path / "study.toml"
    study.write_text(
        'preset = "paper"\nstudy.parts = ["bead"]\nvoids.moisture = 0.001\n'
        '[sweep]\n"flow.gap" = ["3 mm", "4 mm"]\n'
    )
    done = fibermelt(command, study, "--json")
    assert (done.exit_code, json.loads(done.stdout)["cases"]) == (0, 2)
    (line,) = done.stderr.splitlines()
    assert line.startswith("warning: [voids] is read by no part of this study")


def test_defaults():
    done = fibermelt("defaults")
    assert done.exit_code == 0
    assert tomllib.loads(done.stdout)["flow"]["gap"] == "3 mm"
    listed = json.loads(fibermelt("defaults", "--json").stdout)
    assert listed["flow.gap"] == {
        "default": 0.003,
        "unit": "m",
        "range": "above 0 m and at most 1 m",
        "meaning": "Distance from the nozzle's lips to the bed.",
        "source": listed["flow.gap"]["source"],
    }
    assert "inferred" in listed["flow.gap"]["source"]


def test_version():
    assert fibermelt("version").stdout.startswith("fibermelt ")
    assert set(json.loads(fibermelt("version", "--json").stdout)) == {"fibermelt"}
    assert fibermelt("--version").stdout == fibermelt("version").stdout
    assert fibermelt("--version").exit_code == 0


@pytest.mark.parametrize("command", ["run", "validate"])
@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("[flow]\ngapp = 3", "error: flow.gapp: unknown key; did you mean flow.gap?"),
        (
            '[flow]\ngap = "3 s"',
            'error: flow.gap = "3 s": has the unit "s", which measures time, not length; '
            'expected m, such as "3 mm"',
        ),
        (
            "[fiber]\ndomain_size = 2.0",
            "error: fiber.domain_size = 2.0: must be above 2 (the fiber would be larger than its "
            "cell)",
        ),
        ("[fiber]\naspect_ratio = 0.9", "error: fiber.aspect_ratio = 0.9: must be at least 1"),
        (
            '[flow]\ninlet_width = "3 mm"',
            "error: flow.inlet_width = 0.003 m is narrower than flow.capillary_width = "
            "0.003175 m: a nozzle narrows downwards; widen flow.inlet_width or narrow "
            "flow.capillary_width",
        ),
    ],
)
def test_a_mistake_is_one_line_and_nothing_is_written(tmp_path, command, text, line):
    study = tmp_path / "study.toml"
    study.write_text(text)
    where = ("--out", tmp_path / "out") if command == "run" else ()
    done = fibermelt(command, study, *where)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr == f"{line}\n"
    assert [entry.name for entry in tmp_path.iterdir()] == ["study.toml"]


def test_several_mistakes_are_several_lines():
    done = fibermelt("validate", "paper", "-s", "flow.gap=-1", "-s", "flow.gapp=1")
    assert done.stderr.splitlines() == [
        "error: flow.gap = -1: must be above 0 m",
        "error: flow.gapp: unknown key; did you mean flow.gap?",
    ]


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    done = fibermelt("run", "paper", "--out", tmp_path / "file/out")
    assert done.exit_code == 2
    assert "not a directory" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""


@pytest.mark.parametrize("out", ["", " "])
def test_a_results_folder_has_a_name(tmp_path, monkeypatch, out):
    monkeypatch.chdir(tmp_path)
    done = fibermelt("run", "paper", "--out", out)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith('error: --out "": is no name of a folder')
    assert list(tmp_path.iterdir()) == []


def test_a_message_is_one_line_whatever_the_path_holds(tmp_path):
    (tmp_path / "fi\nle").write_text("")
    done = fibermelt("run", "paper", "--out", tmp_path / "fi\nle/out")
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
    assert r"fi\nle/out" in done.stderr


def test_results_of_other_parameters_are_not_replaced_in_silence(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fibermelt.study.chain.CHAIN", fakes.CHAIN)
    monkeypatch.setattr("fibermelt.report.page.draw", fakes.draw)
    monkeypatch.setattr("fibermelt.report.page.render", lambda *of_the_run: b"<html/>")
    other = ("-s", "flow.gap=3.5 mm")
    note = "note: results/paper shows a run of other parameters, which this one replaces; "
    assert "note" not in fibermelt("run", "paper").stderr
    assert "note" not in fibermelt("run", "paper", *other, "--out", "results/mine").stderr
    done = fibermelt("run", "paper", *other)
    assert done.stderr.startswith(note)
    assert "--out" in done.stderr.splitlines()[0]
    assert done.exit_code == 0
    assert "note" not in fibermelt("run", "paper", *other).stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a disk always full")
@pytest.mark.parametrize("command", [["version", "--json"], ["--version"], ["defaults"]])
def test_standard_output_that_cannot_be_written(command):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "fibermelt", *command],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == ("error: standard output: cannot be written: no space left on device\n")


HEAVY = ("ngsolve", "numpy", "xarray", "matplotlib", "pint", "pydantic", "scipy")


@pytest.mark.parametrize(
    ("code", "allowed"),
    [
        ("import fibermelt", ()),
        ("from fibermelt.cli import app", ()),
        # The unit library reads the study, and looks for numpy and scipy by itself.
        (
            "import fibermelt.engine.runner, fibermelt.study.chain",
            ("pydantic", "pint", "numpy", "scipy"),
        ),
    ],
)
def test_what_is_imported_stays_light(code, allowed):
    listing = f"{code}; import sys; print([m for m in {HEAVY!r} if m in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", listing], capture_output=True, text=True, check=True
    )
    loaded = set(done.stdout.strip("[]\n").replace("'", "").split(", ")) - {""}
    assert loaded <= set(allowed)


@pytest.fixture
def quick(tmp_path) -> Path:
    """A study that takes a second but for its figures."""
    study = tmp_path / "quick.toml"
    study.write_text(
        'preset = "paper"\n[study]\nparts = ["orbits"]\n[numerics]\ncell_order = 3\n'
        "[sensitivity]\naspect_ratios = [3]\nshear_rates = [1]\nviscosities = [100]\n"
    )
    return study


@pytest.mark.parametrize(
    "numbers",
    [
        pytest.param((2,), id="standard error", marks=pytest.mark.slow),
        pytest.param((1,), id="standard output", marks=pytest.mark.slow),
        pytest.param((0, 1, 2), id="all three"),
    ],
)
def test_a_daemon_starts_it_with_closed_streams(tmp_path, quick, numbers):
    """What it computes is there, and no file of its own had the number of a standard stream."""
    done = subprocess.run(
        [sys.executable, "-m", "fibermelt", "run", quick, "--out", "out"],
        cwd=tmp_path,
        capture_output=True,
        preexec_fn=lambda: [os.close(number) for number in numbers],
        check=False,
        timeout=PATIENCE,
    )
    assert done.returncode == 0
    assert "orbits" in (tmp_path / "out/summary.json").read_text()
    page = (tmp_path / "out/report.html").read_text()
    assert page.rstrip().endswith("</html>")


def test_a_mistake_with_standard_error_closed_has_its_exit_code():
    command = [sys.executable, "-m", "fibermelt", "validate", "nothing.toml"]
    done = subprocess.run(
        command, preexec_fn=lambda: os.close(2), stdout=subprocess.PIPE, check=False
    )
    assert (done.returncode, done.stdout) == (2, b"")


def test_progress_that_cannot_be_written_costs_no_result(tmp_path, quick):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "fibermelt", "run", quick, "--out", "out"],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=full,
            check=False,
            timeout=PATIENCE,
        )
    assert done.returncode == 0
    assert (tmp_path / "out/summary.json").exists()


def test_a_mistake_that_cannot_be_told_has_its_exit_code():
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "fibermelt", "validate", "nothing.toml"]
        assert subprocess.run(command, stderr=full, check=False).returncode == 2
