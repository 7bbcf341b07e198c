from __future__ import annotations

import subprocess
import sys

import pytest
import xarray as xr
from drawn_bead import made_up

from fibermelt.engine.toml import resolved_toml
from fibermelt.paper.claims.conditions import conditions_of
from fibermelt.report.page.figures import FIGURES
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
