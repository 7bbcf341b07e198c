"""What is set on the command line: nothing is set twice, and nothing without effect."""

from pathlib import Path

import numpy as np
import pytest

from fibermelt.engine.overrides import read_tables
from fibermelt.errors import ConfigError
from fibermelt.study.loading import load_study

SWEPT = """preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.gap" = ["2.5 mm", "4 mm"]
"flow.inlet_width, flow.inlet_speed" = [["10 mm", "30 mm/s"], ["15 mm", "20 mm/s"]]
"""


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["flow.gap=3 mm", "flow.gap=4 mm"], r"^-s flow\.gap: is given twice, as 3 mm and as 4 mm"),
        (["flow.gap = 3 mm", "flow . gap=0.003"], r"^-s flow\.gap: .*as 3 mm and as 0\.003: name"),
        (['flow={gap="3 mm"}', "flow.gap=4 mm"], r"^-s flow\.gap: is given twice, as 3 mm and as"),
        (["flow=3", "flow.gap=4 mm"], r"^-s flow: is given twice, as 3 and as 4 mm"),
        (["flow.gap=4 mm", "flow=3"], r"^-s flow: is given twice, as 4 mm and as 3"),
        (["sweep.seed=1", "sweep.seed=2"], r"^-s sweep\.seed: is given twice, as 1 and as 2"),
    ],
)
def test_a_parameter_is_set_once(overrides, message):
    with pytest.raises(ConfigError, match=message):
        load_study("paper", overrides)


def test_what_differs_in_its_last_part_is_not_the_same():
    flow = load_study("paper", ['flow={gap="3.1 mm"}', "flow.bed_speed=80 mm/s"]).config.flow
    assert (flow.gap, flow.bed_speed) == (0.0031, 0.08)


def test_what_varies_is_named_once():
    message = r"^--over flow\.gap: is given twice, as 3 mm and as 4 mm: write all its values in one"
    with pytest.raises(ConfigError, match=message):
        load_study("paper", over=["flow.gap=3 mm", "flow.gap = 4 mm"])


@pytest.mark.parametrize(
    ("key", "over", "where"),
    [
        ("flow.gap", (), r"the table \[sweep\]"),
        ("flow.inlet_speed", (), r"the table \[sweep\]"),
        ("flow.gap", ("flow.gap=3 mm, 4 mm",), r"--over flow\.gap"),
    ],
)
def test_what_every_case_sets_anew_is_not_set(tmp_path, key, over, where):
    path = tmp_path / "swept.toml"
    path.write_text(SWEPT)
    with pytest.raises(ConfigError, match=rf"^-s {key}=0\.02: has no effect, as {where} sets it"):
        load_study(str(path), [f"{key}=0.02"], over)


def test_the_study_itself_is_a_case_of_one_at_a_time():
    overrides = ["flow.gap=3.2 mm", "sweep.design=one-at-a-time"]
    assert load_study("paper", overrides, ["flow.gap=3 mm, 4 mm"]).config.flow.gap == 0.0032


def test_keys_and_tables_of_python_are_tables():
    given = {
        "preset": "paper",
        "flow.gap": np.float64(3e-3),
        "flow": {"bed_speed": "0.1 m/s"},
        "fiber": {"initial_angles": (0, "45 deg")},
        "streamlines.count": np.int64(3),
        "melt.material": Path("mine.toml"),
        "sweep": {"flow.gap": ["3 mm"], "design": "grid"},
    }
    found = read_tables(given)
    assert found == {
        "preset": "paper",
        "flow": {"gap": 3e-3, "bed_speed": "0.1 m/s"},
        "fiber": {"initial_angles": [0, "45 deg"]},
        "streamlines": {"count": 3},
        "melt": {"material": "mine.toml"},
        "sweep": {"flow.gap": ["3 mm"], "design": "grid"},
    }
    assert type(found["flow"]["gap"]) is float
    assert type(found["streamlines"]["count"]) is int


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"flow.gap": 1, "flow": {"gap": 2}},
            r"^flow\.gap: is given twice, as 1 and as 2: name it",
        ),
        (
            {"flow": {"gap": 2}, "flow.gap": 1},
            r"^flow\.gap: is given twice, as 2 and as 1: name it",
        ),
        ({"flow": 3, "flow.gap": 1}, r"^flow: is given twice, as 3 and as 1"),
        ({7: 1}, r'^7: is no key of a study: write it as "flow.gap"'),
        ({"flow..gap": 1}, r"^flow\.\.gap: is no key of a study"),
        ({"flow": {7: 1}}, r"^7: is no key of a study"),
    ],
)
def test_what_stands_for_no_table_in_python(given, words):
    with pytest.raises(ConfigError, match=words):
        read_tables(given)
