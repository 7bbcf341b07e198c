"""A study from Python: the same numbers, folders and errors as the command line's."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from coarse_runs import COARSE, fibermelt
from matplotlib.axes import Axes

import fibermelt as fm

pytestmark = pytest.mark.end_to_end

TABLES = tomllib.loads(COARSE.read_text(encoding="utf-8"))
LESS = {"streamlines.count": 3, "streamlines.points": 100}
SET = [part for key, value in LESS.items() for part in ("-s", f"{key}={value}")]


@pytest.fixture(autouse=True)
def _no_window() -> Iterator[None]:
    """Draw without a screen, and close what was drawn."""
    plt.switch_backend("agg")
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the results folder of a run by the command line, without figures in it."""
    root = tmp_path_factory.mktemp("runs")
    done = fibermelt("run", COARSE, "--out", root / "out", *SET, "--json", folder=root)
    assert done.returncode == 0, done.stderr
    return root / "out"


@pytest.fixture(scope="module")
def results(folder: Path) -> xr.Dataset:
    return fm.open_results(folder)


def _written(folder: Path) -> dict[Path, int]:
    """Return when each file was written, but for the mark that every run renews."""
    files = (path for path in folder.rglob("*.*") if path.name != "store.json")
    return {path: path.stat().st_mtime_ns for path in files}


def test_results_are_those_of_the_command_line(
    folder: Path, results: xr.Dataset, capfd: pytest.CaptureFixture[str]
) -> None:
    """From tables or from a file: nothing has changed, and the page stays."""
    before = _written(folder)
    again = fm.run_study(TABLES, LESS, folder)
    assert _written(folder) == before
    assert (folder / "report.html").is_file()
    xr.testing.assert_identical(again.drop_attrs(deep=False), results.drop_attrs(deep=False))
    summary = json.loads((folder / "summary.json").read_bytes())
    assert again.fibermelt.summary == summary
    stored = xr.load_dataset(folder / "results.nc", engine="h5netcdf").fibermelt.summary
    assert {**stored, "cost": summary["cost"]} == summary
    assert again.fibermelt.study["streamlines"]["count"] == 3
    assert capfd.readouterr() == ("", "")


def test_a_run_into_no_folder_leaves_none(
    results: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    # Only the size of the fiber differs: pressures do not know it.
    found = fm.run_study(COARSE, {"fiber": {"half_length": "20 um"}, **LESS})
    assert list(tmp_path.iterdir()) == []
    assert found.fibermelt.study["fiber"]["half_length"] == pytest.approx(20e-6, rel=1e-12)
    np.testing.assert_allclose(found["extreme"], results["extreme"], rtol=1e-9)
    text = tmp_path / "kept.nc"
    found.to_netcdf(text, engine="h5netcdf")  # attributes and all


def test_results_say_what_they_are(results: xr.Dataset) -> None:
    told = repr(results.fibermelt)
    assert told.startswith("fibermelt study coarse\nbead height     3.000 mm\n")
    assert "Can it void?" in results.fibermelt._repr_html_()
    assert repr(xr.Dataset().fibermelt) == "no results of fibermelt"
    with pytest.raises(fm.ConfigError, match="is of whole results, and these lack some"):
        _ = results.drop_vars("extreme").fibermelt.summary
    with pytest.raises(fm.ConfigError, match=r"results\.fibermelt\.summary: is of a run"):
        _ = xr.Dataset().fibermelt.summary


def test_a_sweep_is_a_dataset_over_what_varies(tmp_path: Path, results: xr.Dataset) -> None:
    over = {"fiber.half_length": np.array([20e-6, 42e-6])}
    found = fm.sweep(TABLES, over, LESS, tmp_path / "out")
    assert found.sizes["fiber.half_length"] == 2
    assert set(found["status"].to_numpy().tolist()) == {"done"}
    assert repr(found.fibermelt) == "fibermelt sweep unnamed: over fiber.half_length (2)"
    xr.testing.assert_identical(fm.open_results(tmp_path / "out"), found)
    xr.testing.assert_identical(fm.sweep(TABLES, over, LESS, tmp_path / "out"), found)
    shared = sorted(set(map(str, results.data_vars)) & set(map(str, found.data_vars)))
    name = next(one for one in shared if results[one].dims == () and one == "inlet_pressure")
    np.testing.assert_allclose(found[name], float(results[name]), rtol=1e-12)


def test_cases_without_an_answer_are_told(tmp_path: Path) -> None:
    """No cell stalls a fiber at the angle of a suspension that interacts so much."""
    study = {"preset": "paper", "study.parts": ["interaction"]}
    with pytest.warns(UserWarning, match="1 of 1 cases have no answer: see status and reason"):
        found = fm.sweep(study, {"interaction.coefficient": [0.5]}, out=tmp_path / "out")
    assert found["status"].item() == "failed"
    assert "no cell stalls a fiber" in found["reason"].item()


@pytest.mark.parametrize(
    ("study", "overrides", "words"),
    [
        ("papr", {}, 'no study is called "papr"; did you mean paper?'),
        ("paper", {"flow.gap": "3 Pa"}, 'flow.gap = "3 Pa": has the unit "Pa"'),
        ("paper", {"flow.gp": 3e-3}, "flow.gp: unknown key; did you mean flow.gap?"),
        ("paper", {"flow": {"gap": 3e-3}, "flow.gap": 2e-3}, "flow.gap: is given twice, as 0.003"),
        ("paper", {3: 1}, '3: is no key of a study: write it as "flow.gap"'),
        ("paper", {"flow": 3}, r"flow = 3: is a table of parameters: write \[flow\]"),
        ({"preset": "papr"}, {}, 'no study is called "papr"'),
        ("nozzle", {}, r"nozzle: has a table \[sweep\].* use fibermelt.sweep"),
    ],
)
def test_mistakes_are_those_of_the_command_line(study, overrides, words) -> None:
    with pytest.raises(fm.ConfigError, match=words):
        fm.run_study(study, overrides)


def test_other_mistakes(tmp_path: Path) -> None:
    with pytest.raises(fm.StoreError, match="no such folder; name a folder that"):
        fm.open_results(tmp_path / "none")
    with pytest.raises(fm.ConfigError, match="page = True: needs out"):
        fm.run_study("paper", page=True)
    with pytest.raises(fm.ConfigError, match='out = "": is no name of a folder'):
        fm.run_study("paper", out="")
    with pytest.raises(fm.ConfigError, match=r'overrides = "folder": must be a mapping.* out='):
        fm.run_study("paper", "folder")  # type: ignore[arg-type]
    with pytest.raises(fm.ConfigError, match=r"paper: has no table \[sweep\]"):
        fm.sweep("paper")
    with (
        pytest.warns(UserWarning, match=r"\[voids\] is read by no part of this study"),
        pytest.raises(fm.ConfigError, match="page = True"),
    ):
        fm.run_study(TABLES, {"voids.moisture": 0.001}, page=True)


@pytest.mark.parametrize("name", ["overview", "history", "extremes", "streamlines", "maps"])
def test_plots_return_axes_that_pyplot_knows(results: xr.Dataset, name: str) -> None:
    axes = getattr(fm.plot, name)(results)
    assert all(isinstance(one, Axes) for one in axes)
    assert plt.gcf() is axes[0].figure
    plt.gcf().canvas.draw()


def test_plots_into_given_axes(results: xr.Dataset) -> None:
    _, (left, right) = plt.subplots(ncols=2)
    assert fm.plot.spread(results, 2, "max", left) is left
    assert fm.plot.along(results, "shear_rate", [1, 3], right) is right
    drawn = [line.get_ydata() for line in right.lines]
    assert np.array_equal(drawn[1], results["shear_rate"].sel(streamline=3))
    assert right.get_ylabel().endswith("[1/s]")
    assert fm.plot.along(results).figure is not right.figure


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda r: fm.plot.figure(r, "overvew"), 'there is no figure "overvew"; there are: over'),
        (fm.plot.voids, 'the figure "voids" needs the variable void_margin'),
        (lambda r: fm.plot.spread(r, 3), "location = 3, kind"),
        (lambda r: fm.plot.along(r, "speed"), 'variable = "speed": must be one of x, y'),
        (lambda r: fm.plot.along(r, "u", [9]), "streamline 9: must be from 1 to 3"),
    ],
)
def test_what_cannot_be_drawn_is_told(results: xr.Dataset, call, words) -> None:
    with pytest.raises(fm.ConfigError, match=words):
        call(results)
    assert "overview" in fm.plot.names(results)
    assert "voids" not in fm.plot.names(results)
