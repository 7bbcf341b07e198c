from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr
from drawn_bead import made_up
from drawn_cases import case
from patience import PATIENCE

from fibermelt.engine.toml import resolved_toml
from fibermelt.paper.claims.conditions import conditions_of
from fibermelt.report.kit.plates import Plate, draw_plates
from fibermelt.report.page import hand
from fibermelt.report.page.figures import FIGURES
from fibermelt.report.page.hand import draw_with_help
from fibermelt.study.loading import load_study


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return made_up()


@pytest.mark.parametrize("name", ["history", "profiles", "extremes", "positions"])
def test_the_papers_numbers_stand_beside_those_of_its_study_only(
    name: str, results: xr.Dataset
) -> None:
    (plate,) = (plate for plate in FIGURES if plate.name == name)

    def of_study(*overrides: str) -> xr.Dataset:
        config = load_study("paper", overrides).config
        return results.assign_attrs(
            title="fibermelt study paper",
            config=resolved_toml(config, "made up"),
            **conditions_of(config),
        )

    assert "The paper's text" in plate.words(of_study()).caption
    assert "The paper's text" in plate.words(of_study("voids.moisture=0.3 %")).caption
    assert "The paper's text" not in plate.words(results).caption
    # The name alone, as of the shipped study with something overridden, does not count.
    assert "The paper's text" not in plate.words(of_study("flow.gap=3.5 mm")).caption


def test_words_follow_the_numbers() -> None:
    overview = next(plate for plate in FIGURES if plate.name == "overview")
    calm = made_up()
    deep = calm.assign(bound_lowest=2 * calm["bound_lowest"])
    deep["extreme"] = 2 * calm["extreme"]
    assert overview.words(calm).alt != overview.words(deep).alt


def test_command_line_starts_without_matplotlib() -> None:
    code = "import sys, fibermelt.cli; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.fixture(scope="module")
def turns() -> tuple[Plate, ...]:
    """Return figures that are drawn fast, enough of them for two processes."""
    return tuple(plate for plate in FIGURES if plate.needs == "orbit_period")


@pytest.fixture(scope="module")
def alone(turns: tuple[Plate, ...], tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("alone")
    return {path.name: path.read_bytes() for path in draw_plates(turns, case("turns"), folder)}


def read(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_two_processes_draw_the_same_files(
    turns: tuple[Plate, ...],
    alone: dict[str, bytes],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The one here is told to wait until the other has drawn: it does its share."""
    here: list[str] = []

    def slow(plates: list[Plate], results: xr.Dataset, directory: Path) -> list[Path]:
        other = directory / f"{turns[-1].name}.png"
        while not other.exists() and time.monotonic() < end:
            time.sleep(0.01)
        here.extend(plate.name for plate in plates)
        return draw_plates(plates, results, directory)

    end = time.monotonic() + PATIENCE
    monkeypatch.setattr(hand, "draw_plates", slow)
    draw_with_help(turns, case("turns"), tmp_path, hands=2)
    assert read(tmp_path) == alone
    assert turns[-1].name not in here


def test_what_a_second_process_does_not_draw_is_drawn_here(
    turns: tuple[Plate, ...],
    alone: dict[str, bytes],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/false")
    draw_with_help(turns, case("turns"), tmp_path, hands=2)
    assert read(tmp_path) == alone


def test_a_second_process_that_dies_at_its_work_leaves_it_to_the_first(
    turns: tuple[Plate, ...], alone: dict[str, bytes], tmp_path: Path
) -> None:
    """A figure of no page is unknown to it: it ends with an error."""
    unknown = replace(turns[-1], name="unknown")
    draw_with_help((*turns[:-1], unknown), case("turns"), tmp_path, hands=2)
    assert {name.partition(".")[0] for name in read(tmp_path)} == {
        *(plate.name for plate in turns[:-1]),
        "unknown",
    }
