"""What the runner and the store do with any chain: reuse, replace, publish."""

import json
from dataclasses import replace

import fakes
import pytest
import xarray as xr

from fibermelt.engine.parameters import flatten
from fibermelt.engine.runner import run_study
from fibermelt.engine.stages import keys
from fibermelt.study.loading import load_study, resolve

pytestmark = pytest.mark.end_to_end


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_what_lies_on_show_is_complete(tmp_path):
    fakes.run(tmp_path / "out", "flow.gap=3.5 mm")
    shown = {entry.name for entry in (tmp_path / "out").iterdir()}
    assert shown == {"config.toml", "summary.json", "results.nc", "flow.vtu", "figures", "stages"}
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["schema"] == 1
    assert summary["extreme"] == 2 * 0.0035 * 6
    assert set(summary["cost"]) == {"flow", "cell", "motion", "figures", "total"}
    with xr.open_dataset(tmp_path / "out/results.nc", engine="h5netcdf") as results:
        assert float(results["bead"]) == 0.007
        assert results["bead"].attrs == fakes.UNITS
        assert "with flow.gap=3.5 mm" in results.attrs["config"]


def test_resolved_config_runs_to_the_same_results(tmp_path):
    fakes.run(tmp_path / "out", "flow.gap=3.5 mm")
    resolved = load_study(str(tmp_path / "out/config.toml")).config
    assert resolved == load_study("paper", ["flow.gap=3.5 mm"]).config


def test_a_repeat_changes_nothing(tmp_path):
    fakes.run(tmp_path / "out")
    before = contents(tmp_path / "out")
    notes = fakes.run(tmp_path / "out")
    assert notes.lines == ["study: nothing has changed: all results are up to date"]
    assert contents(tmp_path / "out") == before


def test_an_edited_config_that_is_run_is_brought_back_to_its_results(tmp_path):
    """Edited to 3.5 mm and run with 3 mm, config.toml would show another study than the results."""
    fakes.run(tmp_path / "out")
    config = tmp_path / "out/config.toml"
    edited = config.read_text().replace("gap = 0.003 ", "gap = 0.0035 ")
    assert edited != config.read_text()
    config.write_text(edited)
    study = load_study(str(config), ["flow.gap=3 mm"])
    notes = fakes.Notes()
    run_study(study, tmp_path / "out", fakes.CHAIN, draw=fakes.draw, observer=notes)
    assert notes.reused() == ["flow", "cell", "motion"]
    assert load_study(str(config)).config.flow.gap == 0.003
    assert "gives these results again, to rounding" in " ".join(config.read_text().split("\n# "))


def test_only_what_depends_on_a_change_is_computed_again(tmp_path):
    fakes.run(tmp_path / "out")
    assert fakes.run(tmp_path / "out", "fiber.aspect_ratio=8").reused() == ["flow"]
    assert fakes.run(tmp_path / "out", "melt.density=1000").reused() == ["cell"]
    going_back = fakes.run(tmp_path / "out")
    assert going_back.reused() == ["flow", "cell", "motion"]
    assert json.loads((tmp_path / "out/summary.json").read_text())["extreme"] == 2 * 0.003 * 6


def test_what_is_on_show_follows_a_parameter_that_no_stage_reads(tmp_path):
    """The folder said that nothing had changed, and went on showing another moisture."""
    fakes.run(tmp_path / "out")
    notes = fakes.run(tmp_path / "out", "voids.moisture=0.3 %")
    assert notes.reused() == ["flow", "cell", "motion"]
    shown = load_study(str(tmp_path / "out/config.toml")).config
    assert shown.voids.moisture == 0.003
    assert shown == load_study("paper", ["voids.moisture=0.3 %"]).config


def test_fresh_computes_everything_again(tmp_path):
    fakes.run(tmp_path / "out")
    assert fakes.run(tmp_path / "out", fresh=True).reused() == []


def test_a_new_version_of_a_stage_is_computed_again(tmp_path):
    fakes.run(tmp_path / "out")
    newer = (fakes.STAGES[0], replace(fakes.STAGES[1], version=2), fakes.STAGES[2])
    notes = fakes.run(tmp_path / "out", chain=replace(fakes.CHAIN, stages=newer))
    assert notes.reused() == ["flow"]


def test_the_cost_of_a_reused_stage_is_what_it_took(tmp_path):
    fakes.run(tmp_path / "out")
    first = json.loads((tmp_path / "out/summary.json").read_text())["cost"]
    fakes.run(tmp_path / "out", "fiber.aspect_ratio=8")
    second = json.loads((tmp_path / "out/summary.json").read_text())["cost"]
    assert second["flow"] == first["flow"]
    assert second["cell"] != first["cell"]


def test_a_missing_figure_is_drawn_again(tmp_path):
    fakes.run(tmp_path / "out")
    (tmp_path / "out/figures/bead.svg").unlink()
    assert fakes.run(tmp_path / "out").reused() == ["flow", "cell", "motion"]
    assert (tmp_path / "out/figures/bead.svg").exists()


def test_a_stage_cannot_read_what_it_did_not_declare(tmp_path):
    blind = (replace(fakes.STAGES[0], parameters=("melt",)), *fakes.STAGES[1:])
    with pytest.raises(KeyError, match=r"did not declare flow\.gap"):
        fakes.run(tmp_path / "out", chain=replace(fakes.CHAIN, stages=blind))


def test_keys_follow_what_a_stage_reads():
    base = flatten(resolve({}))
    thicker = {**base, "fiber.aspect_ratio": 8.0}
    before, after = keys(fakes.STAGES, base), keys(fakes.STAGES, thicker)
    assert before["flow"] == after["flow"]
    assert before["cell"] != after["cell"]
    assert before["motion"] != after["motion"]


def test_files_that_a_person_added_stay(tmp_path):
    fakes.run(tmp_path / "out")
    for mine in ("out/figures/mine.svg", "out/notes.txt"):
        (tmp_path / mine).write_text("mine")
    fakes.run(tmp_path / "out", "fiber.aspect_ratio=8")
    assert (tmp_path / "out/figures/mine.svg").read_text() == "mine"
    assert (tmp_path / "out/notes.txt").read_text() == "mine"


def test_a_figure_that_is_no_longer_drawn_goes(tmp_path):
    fakes.run(tmp_path / "out")

    def draw_another(results, folder):
        (folder / "another.svg").write_text("<svg/>")
        return [folder / "another.svg"]

    run_study(
        load_study("paper", ["fiber.aspect_ratio=8"]),
        tmp_path / "out",
        fakes.CHAIN,
        draw=draw_another,
    )
    assert [figure.name for figure in (tmp_path / "out/figures").iterdir()] == ["another.svg"]
