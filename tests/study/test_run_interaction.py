"""`fibermelt run interaction`, end to end: from fiber content to the size of the cell."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import xarray as xr
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.parts.interaction.figures import figure_interaction, figure_sizes

pytestmark = pytest.mark.end_to_end

KEYS = [
    "interaction",
    "preferred_angle",
    "domain_size",
    "regime",
    "largest_stalling_domain",
    "shape_factor_error",
    "difference_from_eq_32",
    "difference_from_eq_33",
    "difference_from_eq_34",
]
SUMMED = 1e-9
"""JSON and netCDF hold the same doubles."""


def run(out, *more):
    return CliRunner().invoke(app, ["run", "interaction", "--out", str(out), "--json", *more])


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("interaction") / "out"
    done = run(folder)
    assert done.exit_code == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_the_summary(finished):
    folder, printed = finished
    assert json.loads((folder / "summary.json").read_text()) == printed
    found = printed["interaction"]
    assert list(found) == KEYS
    assert found["domain_size"] == pytest.approx(4.08, abs=0.1)  # the paper's convention is its own
    assert found["interaction"] == pytest.approx(0.0128, abs=5e-5)
    assert found["largest_stalling_domain"] == pytest.approx(5.2933, abs=5e-5)
    assert found["shape_factor_error"] < 1e-6
    # how far the paper's polynomials are from the curves: near in its own convention only
    assert found["difference_from_eq_32"] == pytest.approx(0.018, abs=5e-4)
    for equation, (near, far) in {33: (0.0065, 0.04), 34: (0.15, 0.6)}.items():
        by = found[f"difference_from_eq_{equation}"]
        assert by["paper"] < near
        assert by["standard"] > far


def test_the_figures(finished):
    folder, printed = finished
    plates = (figure_interaction, figure_sizes)
    names = {f"{plate.name}.{kind}" for plate in plates for kind in ("svg", "png")}
    assert {path.name for path in (folder / "figures").iterdir()} == names
    text = (folder / "figures/interaction.svg").read_text()
    assert ET.fromstring(text).findtext("{http://www.w3.org/2000/svg}title")
    with xr.open_dataset(folder / "results.nc") as results:
        words = figure_interaction.words(results)
    assert f"{printed['interaction']['difference_from_eq_33']['paper']:.4f} rad" in words.caption


def test_the_results_say_the_same(finished):
    folder, printed = finished
    found = printed["interaction"]
    with xr.open_dataset(folder / "results.nc") as results:
        assert float(results["content_domain_size"]) == pytest.approx(
            found["domain_size"], rel=SUMMED
        )
        assert results["interaction_angle"].attrs["units"] == "rad"
        assert results.sizes["closure"] == 8


def test_nothing_is_computed_twice(finished):
    done = run(finished[0])
    assert done.exit_code == 0
    assert done.stderr == "study: nothing has changed: all results are up to date\n"
    assert json.loads(done.stdout) == finished[1]


def test_another_convention_needs_no_other_curve(finished):
    done = run(finished[0], "-s", "interaction.convention=standard")
    assert done.exit_code == 0, done.stderr
    assert "stall: reused" in done.stderr
    found = json.loads(done.stdout)["interaction"]
    assert found["domain_size"] == pytest.approx(4.470, abs=5e-4)


def test_content_that_no_cell_stalls_is_one_line(finished, tmp_path):
    done = run(tmp_path / "out", "-s", "interaction.coefficient=0.5")
    assert done.exit_code == 2
    line = done.stderr.splitlines()[-1]
    assert line.startswith("error: stall angle = 0.6722 rad: no cell stalls a fiber of r_e = 6")
