"""The whole chain, coarse, through the command line: what it writes and what it says."""

import json
import shutil
import signal
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import fakes
import numpy as np
import pytest
import xarray as xr
from coarse_runs import COARSE, ONE_THREAD, computed, fibermelt
from patience import PATIENCE

pytestmark = pytest.mark.end_to_end


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished coarse study: its folder, and what the command printed."""
    folder = tmp_path_factory.mktemp("coarse")
    done = fibermelt("run", COARSE, "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    return folder / "results/coarse", done


@pytest.fixture
def folder(finished, tmp_path):
    """A copy of the finished study to work on."""
    return Path(shutil.copytree(finished[0], tmp_path / "out"))


def test_the_folder(finished):
    names = {entry.name for entry in finished[0].iterdir()}
    files = {"config.toml", "summary.json", "results.nc", "flow.vtu", "report.html"}
    assert names == {*files, "figures", "stages"}
    ET.parse(finished[0] / "flow.vtu")


def test_the_figures(finished):
    figures = [figure.suffix for figure in (finished[0] / "figures").iterdir()]
    assert ".svg" in figures
    assert ".png" in figures


def test_the_resolved_config(finished):
    resolved = tomllib.loads((finished[0] / "config.toml").read_text())
    assert resolved["flow"]["inlet_speed"] == 0.024
    assert resolved["numerics"]["flow_order"] == 3


def test_json_is_the_summary_and_nothing_else(finished):
    path, done = finished
    assert json.loads(done.stdout) == json.loads((path / "summary.json").read_text())


def test_progress_says_which_stage_how_far_what_residual(finished):
    lines = finished[1].stderr.splitlines()
    assert any(line.startswith("flow: ") and "Newton step" in line for line in lines)
    for stage in ("flow", "streamlines", "cell", "motion"):
        assert any(line.startswith(f"{stage}: done in ") for line in lines)


def test_the_summary(finished):
    summary = json.loads(finished[1].stdout)
    assert list(summary) == [
        "schema",
        "flow",
        "paths",
        "streamlines",
        "left_out",
        "cell",
        "extremes",
        "orientation",
        "cost",
    ]
    assert summary["schema"] == 1
    assert set(summary["flow"]) == {
        "bead_height",
        "inlet_pressure",
        "contact_point",
        "heel",
        "mass_imbalance",
        "kinematic_residual",
        "newton_steps",
        "unknowns",
        "elements",
        "lowest_viscosity",
        "highest_rate",
        "error_estimate",
        "outside_law",
    }
    assert [line["index"] for line in summary["streamlines"]] == [1, 2, 3, 4]
    assert set(summary["streamlines"][0]) == {
        "index",
        "transit_time",
        "stream_function_drift",
        "near_singularity",
    }
    assert set(summary["cell"]) == {
        "aspect_ratio",
        "domain_size",
        "shape_factor",
        "stall_angle",
        "tip_pressure",
        "error_estimate",
        "unknowns",
    }
    assert len(summary["orientation"]) == 4 * 3
    assert set(summary["orientation"][0]) == {"streamline", "zone", "mean", "lowest", "highest"}
    assert set(summary["cost"]) == {"flow", "cell", "motion", "figures", "total"}


def test_the_physics_is_that_of_the_paper(finished):
    """Coarse, but not wrong: mass balance, and the stall angle that M = 4 is known for."""
    summary = json.loads(finished[1].stdout)
    assert summary["flow"]["bead_height"] == pytest.approx(3e-3, rel=1e-3)
    assert summary["cell"]["stall_angle"] == pytest.approx(0.129, abs=5e-4)
    assert summary["cell"]["tip_pressure"] == pytest.approx(9.84, rel=2e-3)


def test_extremes_are_ordered(finished):
    extremes = json.loads(finished[1].stdout)["extremes"]
    assert len(extremes) == 4 * 3 * 2
    for extreme in extremes:
        low, high = extreme["bounds"]
        assert low <= extreme["lowest"] <= extreme["mean"] <= extreme["highest"] <= high
        assert extreme["lowest"] <= extreme["median"] <= extreme["highest"]
        assert low <= min(extreme["quantiles"])
        assert max(extreme["quantiles"]) <= high
        assert sorted(extreme["quantiles"]) == extreme["quantiles"]
        assert (extreme["kind"] == "min") == (extreme["highest"] < 0)
        if extreme["location"]:
            entrance, leave = 3e-3 + 6e-3, 3e-3
            low, high = {1: (entrance, np.inf), 2: (0.0, leave)}[extreme["location"]]
            assert low <= extreme["y"] <= high


def test_results_are_labelled(finished):
    with xr.open_dataset(finished[0] / "results.nc", engine="h5netcdf") as results:
        for name, variable in results.variables.items():
            assert variable.attrs["units"], name
            assert variable.attrs["long_name"], name
        assert results["angle"].dims == ("streamline", "initial_angle", "point")
        assert results["time"].attrs["units"] == "s"
        assert np.array_equal(results["angle"][:, :, 0], np.tile(results["initial_angle"], (4, 1)))
        trace = results["gradient"][..., 0, 0] + results["gradient"][..., 1, 1]
        assert float(np.abs(trace).max()) < 1e-8 * float(np.abs(results["gradient"]).max())
        felt, bound = (results[f"{name}_lowest"].to_numpy() for name in ("felt", "bound"))
        near = results["corner_distance"].to_numpy() < 84e-6
        assert np.all(felt[~near] <= bound[~near])  # within a fiber's length it has a limit
        assert results.attrs["schema"] == 1
        assert {"ngsolve", "h5py", "matplotlib"} <= set(json.loads(results.attrs["software"]))


def test_a_repeat_computes_nothing(folder, tmp_path):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    done = fibermelt("run", COARSE, "--out", folder, "--json", folder=tmp_path)
    assert done.returncode == 0
    assert done.stderr == "study: nothing has changed: all results are up to date\n"
    assert json.loads(done.stdout) == json.loads((folder / "summary.json").read_text())
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_the_resolved_config_is_the_same_study(folder, tmp_path):
    done = fibermelt("run", folder / "config.toml", "--out", folder, folder=tmp_path)
    assert done.stderr == "study: nothing has changed: all results are up to date\n"
    assert f"results         {folder}" in done.stdout


def test_another_fiber_takes_the_same_flow(folder):
    before = json.loads((folder / "summary.json").read_text())
    run = computed(COARSE, folder, "fiber.aspect_ratio=3")
    after = run.summary
    reused = [line.split(":")[0] for line in run.told if ": reused" in line]
    assert reused == ["flow", "streamlines"]
    assert after["flow"] == before["flow"]
    assert after["cell"]["aspect_ratio"] == 3
    assert after["cell"]["tip_pressure"] < before["cell"]["tip_pressure"]


def test_the_viscosity_scales_pressures_only(folder):
    before = json.loads((folder / "summary.json").read_text())
    after = computed(COARSE, folder, "melt.viscosity=1634").summary
    # Rounding of two solves of the same scaled problem.
    same = {"rel": 1e-6}
    assert after["flow"]["contact_point"] == pytest.approx(before["flow"]["contact_point"], **same)
    for one, two in zip(before["extremes"], after["extremes"], strict=True):
        assert two["mean"] == pytest.approx(2 * one["mean"], **same)
        assert two["x"] == pytest.approx(one["x"], **same)


def test_ctrl_c_leaves_what_the_next_run_goes_on_from(folder, tmp_path):
    command = [sys.executable, "-m", "fibermelt", "run", str(COARSE), "--out", str(folder)]
    process = subprocess.Popen(
        [*command, "-s", "flow.gap=3.2 mm"],
        env=ONE_THREAD,
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=fakes.hears_ctrl_c,  # noqa: PLW1509  no thread is about here
    )
    for line in process.stderr:
        if "Newton step" in line:
            process.send_signal(signal.SIGINT)
            break
    _, rest = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert rest.splitlines()[-1].startswith("interrupted: finished stages are kept")
    assert "Traceback" not in rest
    done = fibermelt("run", COARSE, "--out", folder, folder=tmp_path)
    assert done.stderr == "study: nothing has changed: all results are up to date\n"


def test_a_gap_without_an_answer_says_what_to_try(tmp_path):
    done = fibermelt("run", COARSE, "--out", "out", "-s", "flow.gap=2 mm", folder=tmp_path)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith("error: ")
    assert "gap" in last
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
