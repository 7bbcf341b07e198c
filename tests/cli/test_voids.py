"""`fibermelt voids` on a finished coarse study, through the command line."""

import json
import shutil
from pathlib import Path

import pytest
from coarse_runs import COARSE, computed, here

pytestmark = pytest.mark.end_to_end

CONTRACT = {
    "vapor_pressure",
    "lowest_pressure",
    "margin",
    "critical_moisture",
    "streamlines",
    "profile",
}
ON_LINE = {
    "index",
    "height",
    "lowest_pressure",
    "time_below",
    "margin",
    "log10_rate",
    "critical_radius",
}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished coarse study of a bead, its voids included."""
    folder = tmp_path_factory.mktemp("voids")
    parts = 'study.parts=["bead", "orientation", "voids", "claims"]'
    return folder, computed(COARSE, folder / "out", parts)


AS_RUN = ("--moisture", "0.17 %")
"""The study's own moisture: asked for, no levers are moved (`tests/levers`)."""


def asked(folder, *options):
    done = here("voids", "out", *options, "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


def refused(folder, *arguments):
    done = here("voids", *arguments, folder=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_the_answer_is_that_of_the_run_and_leaves_it_alone(finished):
    folder, run = finished
    before = {path: path.stat().st_mtime_ns for path in (folder / "out").rglob("*")}
    answer = asked(folder, *AS_RUN)
    assert set(answer) >= CONTRACT
    assert len(answer["streamlines"]) == 4
    assert all(set(line) >= ON_LINE for line in answer["streamlines"])
    assert answer == run.summary["voids"]
    assert "oriented tips" in answer["by_basis"]
    assert {path: path.stat().st_mtime_ns for path in (folder / "out").rglob("*")} == before


def test_the_run_shows_voids(finished):
    _, run = finished
    assert "voids" in run.drawn()
    names = [claim["id"] for claim in run.summary["claims"]]
    assert sum(name.startswith("void-profile") for name in names) == 5
    assert run.results["void_margin_along"].dims == ("streamline", "void_basis", "point")
    bounds = run.results["void_lowest_pressure"].sel(void_basis="bounds")
    fibers = run.results["void_lowest_pressure"].sel(void_basis="fibers")
    # 1 kPa of some MPa: the curve's largest value against one found between samples.
    assert bool((bounds <= fibers + 1e3).all())


def test_moisture_temperature_and_card_are_those_asked_for(finished):
    folder, _ = finished
    base = asked(folder, *AS_RUN)
    drier = asked(folder, "--moisture", "0.085 %")
    assert drier["vapor_pressure"] == pytest.approx(base["vapor_pressure"] / 2, rel=1e-12)
    assert drier["lowest_pressure"] == base["lowest_pressure"]
    gained = base["vapor_pressure"] - drier["vapor_pressure"]
    assert drier["margin"] - base["margin"] == pytest.approx(gained, rel=1e-9)
    colder = asked(folder, "--temperature", "210 degC")
    assert colder["temperature"] == pytest.approx(483.15, abs=1e-9)
    assert colder["vapor_pressure"] < base["vapor_pressure"]
    other = asked(folder, "--material", "pla")
    assert (other["moisture"], other["material"]["key"]) == (0.00025, "pla")


@pytest.mark.parametrize("options", [["--temperature", "210 degC"], ["--material", "pla"]])
def test_pressures_that_stay_those_of_the_run_are_said_to(finished, options):
    folder, run = finished
    answer = asked(folder, *options)
    assert answer["lowest_pressure"] == run.summary["voids"]["lowest_pressure"]
    assert answer["held"].startswith(
        "the local pressures, those of the run's melt, 13 wt% CF/ABS at 503.15 K"
    )
    words = here("voids", "out", *options, folder=folder).stdout
    assert " ".join(answer["held"].split()) in " ".join(words.split())


def test_nothing_is_held_of_the_melt_that_was_run(finished):
    same = ("--material", "abs-cf13", "--temperature", "230 degC", "--moisture", "0.1 %")
    assert "held" not in asked(finished[0], *same)
    assert "held" not in asked(finished[0], "--temperature", "446 degF")


def test_a_card_of_ones_own(finished):
    folder, _ = finished
    (folder / "mine.toml").write_text(
        'name = "mine"\n[melt]\ndensity = { value = 1000.0, source = "a" }\n'
        'temperature = { value = 500.0, source = "a" }\n'
        'coldest = { value = 480.0, source = "a" }\nhottest = { value = 510.0, source = "a" }\n'
        'moisture = { value = "0.1 %", source = "a" }\n'
        '[isotherm]\ncontent = { value = "1 %", source = "a" }\n'
        'reference_temperature = { value = 300.0, source = "a" }\n'
        'mixing_heat = { value = 0.0, source = "a" }\n'
    )
    answer = asked(folder, "--material", "mine.toml")
    assert answer["vapor_pressure"] == pytest.approx(0.1 * answer["saturation_pressure"])
    assert answer["streamlines"][0]["critical_radius"] is None
    assert len(answer["material"]["missing"]) == 3


def test_words_for_a_person(finished):
    done = here("voids", "out", *AS_RUN, folder=finished[0])
    assert done.returncode == 0
    assert done.stdout.startswith("vapor pressure  0.951 MPa of 0.17 % moisture in 13 wt% CF/ABS")
    assert "\nwhat to do      " in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100


def test_no_finished_run_says_how_to_make_one(finished, tmp_path):
    (tmp_path / "empty").mkdir()
    assert "empty: is no results folder of fibermelt; name a folder" in refused(tmp_path, "empty")
    assert "nowhere: no such folder; name a folder" in refused(tmp_path, "nowhere")
    copy = Path(shutil.copytree(finished[0] / "out", tmp_path / "copy"))
    (copy / "stages/outputs.json").unlink()
    said = refused(tmp_path, "copy")
    assert "copy: holds no finished run; `fibermelt run STUDY --out copy` goes on" in said
    (copy / "sweep.json").write_text("{}")
    assert "copy: holds a sweep, and no finished run" in refused(tmp_path, "copy")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--moisture", "0.75 %"], "--moisture = 0.75 %: must be at most 0.5 %, saturation at"),
        (["--moisture", "much"], '--moisture = "much": is not a number'),
        (["--moisture", "1 m"], "which measures length, not a pure number"),
        (["--temperature", "230"], 'for degrees Celsius write "230 degC"'),
        (["--temperature", "190"], 'for degrees Celsius write "190 degC"'),
        (["--temperature", "300 degC"], "--temperature = 573.15 K: must be from 473.15 to 533.15"),
        (["--material", "papr"], '--material: no material is called "papr"; did you mean paper?'),
        (["--material", "pei"], "--moisture: the card of PEI has none: give one"),
    ],
)
def test_what_cannot_be_is_refused(finished, options, message):
    assert message in refused(finished[0], "out", *options)


def test_damaged_results_are_refused(finished, tmp_path):
    copy = Path(shutil.copytree(finished[0] / "out", tmp_path / "copy"))
    data = bytearray((copy / "results.nc").read_bytes())
    data[len(data) // 2] ^= 1
    (copy / "results.nc").write_bytes(data)
    assert "results.nc: is damaged, or was changed" in refused(tmp_path, "copy")
    (copy / "stages/outputs.json").write_text("{}")
    assert "outputs.json: is damaged" in refused(tmp_path, "copy")


def test_a_run_without_a_bead_has_no_voids(tmp_path):
    computed(COARSE, tmp_path / "out", 'study.parts=["orbits"]')
    assert 'has no fibers in a bead: name "bead" or "voids" in study.parts' in refused(
        tmp_path, "out"
    )


def test_a_moisture_that_cannot_be_is_refused_before_the_flow_is_computed(tmp_path):
    settings = ("-s", 'study.parts=["voids"]', "-s", "voids.moisture=3 %")
    done = here("validate", COARSE, *settings, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: voids.moisture = 3 %: must be at most 0.5 %")
