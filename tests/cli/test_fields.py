"""`fibermelt fields`: what is in a file, as JSON and in words."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest
from dialects import cfdpost, fluent, sample, sectionwise, vtu
from exact_flows import PIPE, SLIT
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.parts.flow.field_table import ImportedField

pytestmark = pytest.mark.end_to_end


def fields(*arguments: str):
    return CliRunner().invoke(app, ["fields", *arguments])


def test_json_has_what_is_promised(tmp_path: Path) -> None:
    done = fields(str(cfdpost(tmp_path, sample(SLIT, 4))), "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    keys = {"format", "dimension", "points", "cells", "arrays", "bounds", "units"}
    assert keys <= set(found)
    assert found["format"] == "CFD-Post CSV"
    assert (found["points"], found["cells"]) == (45, 64)
    assert set(found["arrays"][0]) == {"name", "components", "range", "taken_for"}
    taken = {array["name"]: array["taken_for"] for array in found["arrays"]}
    assert taken["Pressure"] == "pressure"
    assert taken["Velocity u"] == "velocity"
    assert taken["Velocity"] is None  # its length
    assert found["units"]["velocity"] == "m s^-1"


@pytest.mark.parametrize("write", [fluent, cfdpost, sectionwise, vtu])
def test_words_end_with_a_table_that_a_study_reads(tmp_path: Path, write) -> None:
    path = write(tmp_path, sample(SLIT, 4))
    done = fields(str(path))
    assert done.exit_code == 0
    text = done.stdout.split("In a study:")[1]
    table = tomllib.loads(text)
    assert table["flow"]["source"] == "field"
    section = ImportedField(**table["field"])
    assert Path(section.file) == path
    assert section.as_map().velocity == section.velocity != ""
    assert ("# length_unit" in text) == (write in {fluent, vtu})


def test_a_flow_in_space_is_told_its_fibers(tmp_path: Path) -> None:
    told, planar = (fields(str(vtu(tmp_path, sample(flow, 2)))).stdout for flow in (PIPE, SLIT))
    assert "[fiber]" not in planar
    text = re.sub(r"(?m)^# (\[fiber|model|directions)", r"\1", told.split("In a study:")[1])
    assert tomllib.loads(text)["fiber"] == {"model": "spheroid", "directions": "equal-area"}


def test_a_mistake_is_one_line(tmp_path: Path) -> None:
    done = fields(str(tmp_path / "none"))
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert "cannot be read: no such file or directory" in done.stderr


def test_a_table_of_paths_is_told_its_place(tmp_path: Path) -> None:
    file = tmp_path / "paths.csv"
    file.write_text("path, time [s], x [mm], y, u, v, L_xx, L_xy, L_yx, L_yy\n1, 0, 0, 0, 1, 0\n")
    done = fields(str(file))
    assert done.exit_code == 2
    assert 'say flow.source = "histories"' in " ".join(done.output.split())


def test_the_table_takes_units_and_lists() -> None:
    section = ImportedField(
        file="a",
        content="known",
        pressure_zero="1 bar",
        mirror=["y", "z = 1 mm"],
        axis="none",
        time_step=0.5,
    )
    wanted = section.as_map()
    assert wanted.pressure_zero == 1e5
    assert wanted.mirror == ("y", "z = 1 mm")
    assert wanted.time_step == 0.5
    assert ImportedField().as_map().mirror == ()
