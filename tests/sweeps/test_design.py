"""What a table [sweep] stands for: its cases, and what is wrong with it."""

import math

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep


def sweep(tmp_path, text):
    path = tmp_path / "swept.toml"
    path.write_text(f'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n{text}')
    return read_sweep(load_study(str(path)))


def test_a_grid_has_every_combination(tmp_path):
    found = sweep(
        tmp_path,
        '"fiber.aspect_ratio" = [2, 4]\n"flow.gap" = { from = "2.5 mm", to = "4 mm", count = 4 }',
    )
    assert (found.shape, found.count) == ((2, 4), 8)
    points = [(case.point["fiber.aspect_ratio"], case.point["flow.gap"]) for case in found.cases()]
    assert points[0] == (2.0, 0.0025)
    assert points[-1] == (4.0, 0.004)
    assert sorted({gap for _, gap in points}) == pytest.approx([2.5e-3, 3e-3, 3.5e-3, 4e-3])


def test_keys_joined_by_a_comma_vary_together(tmp_path):
    found = sweep(
        tmp_path,
        '"flow.inlet_width, flow.inlet_speed" = [["10 mm", "30.48 mm/s"], ["15 mm", "20.32 mm/s"]]',
    )
    heights = [case.config.flow.bead_height for case in found.cases()]
    assert heights == pytest.approx([3e-3, 3e-3], rel=1e-14)


def test_one_at_a_time_begins_with_the_study_itself(tmp_path):
    text = '"flow.gap" = ["2.5 mm"]\n"melt.viscosity" = [400, 1600]\ndesign = "one-at-a-time"'
    cases = sweep(tmp_path, text).cases()
    seen = [(case.config.flow.gap, case.config.melt.viscosity) for case in cases]
    assert seen == [(0.003, 817.0), (0.0025, 817.0), (0.003, 400.0), (0.003, 1600.0)]


@pytest.mark.parametrize("design", ["latin-hypercube", "sobol"])
def test_samples_follow_their_distributions_and_their_seed(tmp_path, design):
    text = (
        '"melt.viscosity" = { mean = "800 Pa s", std = "80 Pa s" }\n'
        '"fiber.aspect_ratio" = { low = 2, high = 10 }\n'
        '"fiber.half_length" = { median = "42 um", factor = 1.5 }\n'
        f'design = "{design}"\nsamples = 256\nseed = 7'
    )
    found = sweep(tmp_path, text)
    first, again = (found.settings() for _ in range(2))
    assert first == again
    viscosity, ratio, length = (np.array([row[axis.name] for row in first]) for axis in found.axes)
    # One sample in each of 256 strata: the mean is off by less than a stratum.
    assert abs(viscosity.mean() - 800) < 80 / 16
    assert abs(viscosity.std() - 80) < 80 / 16
    assert (ratio.min() >= 2, ratio.max() <= 10, abs(ratio.mean() - 6) < 8 / 256) == (True,) * 3
    assert abs(math.exp(np.log(length).mean()) / 42e-6 - 1) < 0.05


def test_a_case_is_known_by_its_resolved_study(tmp_path):
    metres, millimetres = (
        sweep(tmp_path, f'"flow.gap" = [{gap}]').cases()[0] for gap in ("0.0025", '"2.5 mm"')
    )
    assert metres.id == millimetres.id
    assert metres.id != sweep(tmp_path, '"flow.gap" = ["2.6 mm"]').cases()[0].id


WRONG = [
    ("", "sweep: nothing varies"),
    (
        "flow.gap = [1]",
        r'sweep\.flow\.gap: a key of \[sweep\] stands in quotes: write "flow\.gap" =',
    ),
    ('"flow.gapp" = [1]', r"sweep\.flow\.gapp: unknown key; did you mean flow\.gap\?"),
    ('"flow.gap" = []', r'sweep\."flow\.gap" = \[\]: must be a list of values, or a range'),
    ('"flow.gap" = 3', r'sweep\."flow\.gap" = 3: must be a list of values'),
    ('"flow.gap" = { from = 1, to = 2 }', r"has from, to: a range is \{ from, to, count \}"),
    ('"flow.gap" = { from = "1 s", to = 2, count = 3 }', 'from = "1 s" is a time, not|"1 s"'),
    ('"flow.gap" = { from = 1, to = 2, count = 1 }', "count = 1: must be a whole number, 2 to"),
    ('"flow.gap" = { low = 1, high = 2 }', 'a distribution is sampled: take design = "latin-hyp'),
    ('"flow.gap" = [1]\ndesign = "grit"', r'sweep\.design = "grit": must be "grid" or "one-at'),
    ('"flow.gap" = [1]\ndesign = "sobol"\nsamples = 4', "a list cannot be sampled"),
    (
        '"flow.gap" = { low = 1, high = 2 }\ndesign = "sobol"',
        r"sweep\.samples = 0: .* at least one",
    ),
    ('"flow.gap" = [1]\nsamples = -1', r"sweep\.samples = -1: must be a whole number"),
    ('"flow.gap" = [1]\n"flow.gap, flow.outlet" = [[1, 2]]', r"sweep: flow\.gap varies twice"),
    ('"flow.gap, flow.outlet" = [1]', "1: must be a list of 2 values"),
    ('"study.parts" = [["bead"]]', "study.parts cannot vary"),
    ('"flow.gap" = { from = 1, to = 2, count = 2000000 }', "count = 2000000: must be a whole"),
    (
        '"flow.gap" = { low = 1, high = 2 }\ndesign = "sobol"\nsamples = 1048576',
        "1048576 cases, at most",
    ),
    ('"flow.gap" = ["3 mm", "4 mm", "3 mm"]', r'"flow\.gap": 3 mm is there twice: name it once'),
    ('"flow.gap" = ["3 mm", 0.003]', "3 mm and 0.003 are the same value: name it once"),
    ('"flow.gap" = ["0.1 in", "2.54 mm"]', "are the same value: name it once"),
    ('"fiber.model" = ["ellipse", "ellipse"]', "ellipse is there twice: name it once"),
    ('"streamlines.features" = [[4, 10], [4.0, 10]]', "are the same value"),
    (
        '"flow.gap, flow.outlet" = [["3 mm", "30 mm"], ["4 mm", "30 mm"], [0.004, "3 cm"]]',
        r'sweep\."flow\.gap, flow\.outlet": 4 mm, 30 mm and 0\.004, 3 cm are the same value',
    ),
    (
        '"flow.gap" = { from = 2, to = 2, count = 3 }',
        "from = 2, to = 2: are the same value: let them differ, or give a list of one",
    ),
    ('"flow.gap" = { from = "2 mm", to = 0.002, count = 2 }', "are the same value: let them"),
    (
        '"flow.gap" = { low = 1, high = 2 }\nsamples = 8',
        r'sweep\.samples = 8: design = "grid", which is meant where none is named, draws no '
        r'samples: take design = "latin-hypercube", "sobol" or "saltelli", or leave samples away',
    ),
    (
        '"flow.gap" = [1, 2]\ndesign = "one-at-a-time"\nseed = 3',
        r'sweep\.seed = 3: design = "one-at-a-time" draws nothing .* or leave seed away',
    ),
    (
        '"streamlines.count" = { low = 10, high = 20 }\ndesign = "sobol"\nsamples = 4',
        r'"streamlines\.count" = \{ low = 10, high = 20 \}: a whole number has no range and is not '
        r"sampled: give a list of its values, such as \[22, 44\], with design = \"grid\"",
    ),
    ('"streamlines.count" = { from = 10, to = 20, count = 3 }', "a whole number has no range"),
    (
        '"fiber.model" = { low = 1, high = 2 }',
        r'a word has no .* such as \["confined-ellipse", "el',
    ),
    ('"streamlines.features" = { low = 1, high = 2 }', "a list has no range"),
    ('"sead" = 3', r"sweep\.sead: unknown key; did you mean seed\? .* -s sweep\.seed=\.\.\."),
    ('"sweep.flow.gapp" = [3]', r"sweep\.flow\.gapp: unknown key; did you mean flow\.gap\?"),
]


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_what_is_wrong_is_said_in_one_line(tmp_path, text, message):
    with pytest.raises(ConfigError, match=message) as raised:
        sweep(tmp_path, text)
    assert len(str(raised.value).splitlines()) == 1


def test_a_case_that_cannot_be_is_named(tmp_path):
    found = sweep(tmp_path, '"fiber.aspect_ratio" = [2, 0.5]')
    message = r"case 2 of the sweep \(fiber\.aspect_ratio = 0\.5\): .* must be at least 1"
    with pytest.raises(ConfigError, match=message):
        found.cases()


@pytest.mark.parametrize(
    ("entry", "way"),
    [
        ("{ low = 0.5, high = 1.5 }", "is sampled from end to end: narrow it"),
        ("{ mean = 1, std = 1 }", r"cut it off with \{ \.\.\., between = \[low, high\] \}"),
    ],
)
def test_a_sample_beyond_the_bounds_has_a_way_out(tmp_path, entry, way):
    text = f'"fiber.aspect_ratio" = {entry}\ndesign = "sobol"\nsamples = 8'
    with pytest.raises(
        ConfigError, match=f'must be at least 1.*; sweep."fiber.aspect_ratio" .*{way}'
    ):
        sweep(tmp_path, text).cases()


def test_a_study_without_a_sweep_says_how_to_run_it():
    with pytest.raises(ConfigError, match=r"paper: has no table \[sweep\].*or use fibermelt run"):
        read_sweep(load_study("paper"))


@pytest.mark.parametrize(
    ("over", "values"),
    [
        ("flow.gap=2.5 mm, 3 mm", [2.5e-3, 3e-3]),
        ('flow.gap = ["2.5 mm", 0.003]', [2.5e-3, 3e-3]),
        ('flow.gap={from="2 mm", to="3 mm", count=3}', [2e-3, 2.5e-3, 3e-3]),
        ("fiber.aspect_ratio=4,6", [4.0, 6.0]),
        ("flow.gap=3 mm", [3e-3]),
    ],
)
def test_what_varies_can_be_named_on_the_command_line(over, values):
    study = load_study("paper", over=[over])
    key = over.partition("=")[0].strip()
    points = [case.point for case in read_sweep(study).cases()]
    assert [point[key] for point in points] == pytest.approx(values, rel=1e-15)
    assert f"over {over}" in study.origin


def test_the_command_line_adds_to_the_table_and_replaces_in_it(tmp_path):
    path = tmp_path / "swept.toml"
    path.write_text('preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n"flow.gap" = ["2.5 mm"]\n')
    study = load_study(str(path), over=["flow.gap=3 mm, 4 mm", "fiber.aspect_ratio=4, 6, 8"])
    assert read_sweep(study).shape == (2, 3)


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ("flow.gap", "write it as key=values"),
        ("flow.gap=", "write it as key=values"),
        ("=3 mm", "write it as key=values"),
        ("flow.gapp=3 mm", r"sweep\.flow\.gapp: unknown key; did you mean"),
        ("flow.gap=3 mm,,4 mm", r"case 2 of the sweep .*flow\.gap"),
        ("flow.gap=3 kg", r"flow\.gap"),
        ("seed=3", r"--over seed: is a setting and does not vary: write -s sweep\.seed=3"),
        ("sweep.seed=3", r"--over sweep\.seed: .* write -s sweep\.seed=3"),
        ("flow.gap=3 mm, 0.003", "are the same value: name it once"),
    ],
)
def test_a_wrong_name_or_value_of_what_varies_is_refused(over, said):
    with pytest.raises(ConfigError, match=said):
        read_sweep(load_study("paper", over=[over])).cases()
