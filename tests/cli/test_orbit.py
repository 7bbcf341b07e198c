"""`fibermelt orbit`: what it prints, the numbers that are known, and what it refuses."""

import json
import math

import pytest
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.questions.orbit import read_quantity

pytestmark = pytest.mark.end_to_end

KEYS = [
    "model",
    "domain_size",
    "period",
    "period_jeffery",
    "shape_factor",
    "stalls",
    "stall_angle",
    "max_pressure",
    "min_pressure",
    "tip_max",
    "tip_min",
    "angle_at_min",
    "where_at_min",
    "cost",
]
COMMON = {"--aspect-ratio": "6", "--shear-rate": "1", "--viscosity": "817"}
PRINTED = 0.005  # half a unit of the last digit that is printed


def invoke(options, *flags):
    arguments = [part for option in {**COMMON, **options}.items() for part in option]
    return CliRunner().invoke(app, ["orbit", *arguments, *flags])


def orbit(**options):
    named = {f"--{name.replace('_', '-')}": value for name, value in options.items()}
    done = invoke(named, "--json")
    assert (done.exit_code, done.stderr) == (0, "")
    return json.loads(done.stdout)


@pytest.mark.parametrize("model", ["confined-ellipse", "ellipse", "spheroid"])
def test_the_keys_and_their_order(model):
    answer = orbit(model=model)
    assert list(answer) == KEYS
    assert answer["cost"]["total"] == answer["cost"]["cell"] + answer["cost"]["orbit"]


def test_the_ellipse_of_table_1():
    answer = orbit(model="ellipse")
    assert answer["period"] == pytest.approx(38.75, abs=PRINTED)
    assert answer["period"] == pytest.approx(2 * math.pi * (6 + 1 / 6), rel=1e-8)
    assert answer["period"] == pytest.approx(answer["period_jeffery"], rel=1e-12)
    for key in ("max_pressure", "tip_max"):
        assert answer[key] == pytest.approx(817 * 7, rel=1e-12)
    for key in ("min_pressure", "tip_min"):
        assert answer[key] == pytest.approx(-817 * 7, rel=1e-12)
    assert answer["angle_at_min"] == pytest.approx(math.pi / 4, abs=1e-9)
    assert answer["where_at_min"] == pytest.approx(0, abs=1e-9)
    assert (answer["stalls"], answer["stall_angle"]) == (False, None)


def test_the_confined_ellipse_of_the_paper_stalls():
    answer = orbit()
    assert answer["period"] is None
    assert answer["stalls"]
    assert answer["stall_angle"] == pytest.approx(0.129, abs=PRINTED / 10)
    assert answer["tip_max"] == pytest.approx(9.836 * 817, rel=1e-4)


def test_a_wide_cell_lets_it_tumble():
    answer = orbit(domain_size="80")
    assert answer["period"] == pytest.approx(answer["period_jeffery"], rel=5e-3)  # 1/M^2
    assert answer["max_pressure"] == pytest.approx(817 * 7, rel=2e-3)


def test_a_spheroid_sees_more():
    answer = orbit(model="spheroid")
    assert answer["tip_max"] / 817 == pytest.approx(15.53, abs=PRINTED)
    assert answer["period"] == pytest.approx(38.75, abs=PRINTED)


def test_units_and_the_start():
    answer = orbit(model="ellipse", shear_rate="120 1/min", viscosity="0.817 kPa s", angle="30")
    assert answer["max_pressure"] == pytest.approx(2 * 817 * 7, rel=1e-12)
    assert answer["period"] == pytest.approx(38.75 / 2, abs=PRINTED)


@pytest.mark.parametrize("start", ["30", "30 deg", f"{math.pi / 6} rad"])
def test_a_bare_angle_is_in_degrees(start):
    assert read_quantity("--angle", start, "rad", bare="deg") == pytest.approx(math.pi / 6)


@pytest.mark.parametrize("model", ["confined-ellipse", "ellipse", "spheroid"])
def test_a_circle_has_no_angle_to_tell(model):
    answer = orbit(model=model, aspect_ratio="1")
    assert (answer["angle_at_min"], answer["where_at_min"]) == (None, None)
    # any direction of a round fiber turns with the melt: 4 pi over the shear rate
    assert answer["period"] == pytest.approx(4 * math.pi, rel=1e-9)
    words = invoke({"--model": model, "--aspect-ratio": "1"}).stdout
    assert "lowest          at every angle alike: a fiber of aspect ratio 1 has no" in words
    assert "shape factor    0.000000\n" in words


def test_the_papers_algorithm_agrees():
    """The extremes of this orbit are at 45 degrees and at the tip, where it has a sample."""
    exact, newton = orbit(), orbit(path="newton")
    assert (newton.pop("cost")["steps"], exact.pop("cost")["solves"]) == (400, 0)
    assert newton.pop("period") is exact.pop("period") is None
    assert newton.pop("model") == exact.pop("model") == "confined-ellipse"
    assert newton == pytest.approx(exact, rel=1e-8, abs=1e-8)


def test_in_words():
    done = invoke({})
    assert done.exit_code == 0
    assert "none: it stalls at 7.405 deg (38.7463 s" in done.stdout
    assert "tips            -8035.93 to 8035.93 Pa" in done.stdout
    done = invoke({"--model": "ellipse"})
    assert "period          38.7463 s" in done.stdout
    assert (
        "lowest          at 45.00 deg to the flow, at the eccentric angle 0.00 deg" in done.stdout
    )


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"--shear-rate": "-1"}, "shear_rate = -1 1/s: must be positive, e.g. 1"),
        (
            {"--shear-rate": "1 s"},
            '--shear-rate = "1 s": has the unit "s", which measures time, not 1 / time',
        ),
        ({"--viscosity": "nan"}, '--viscosity = "nan": is not finite'),
        ({"--angle": "steep"}, '--angle = "steep": is not a number in rad'),
        (
            {"--model": "disc"},
            'model = "disc": must be "confined-ellipse" or "ellipse" or "spheroid" or "ellipsoid"',
        ),
        (
            {"--model": "ellipsoid"},
            'model = "ellipsoid": turns about all its axes and has no one orbit: take model '
            '"spheroid"',
        ),
        ({"--path": "euler"}, 'path = "euler": must be "superposition" or "newton"'),
        (
            {"--path": "newton", "--model": "spheroid"},
            'path = "newton": the paper\'s algorithm works on a cell, which model = "spheroid" '
            'has not: take model "confined-ellipse", or path "superposition"',
        ),
        (
            {"--aspect-ratio": "0.5", "--model": "spheroid"},
            "fiber.aspect_ratio = 0.5: must be at least 1 (length over width); for a fiber lying "
            "across give its inverse and turn the angles by 90 deg",
        ),
        (
            {"--domain-size": "2"},
            "fiber.domain_size = 2: the cell's radius is domain_size/2 half-lengths and must "
            "exceed one, or the fiber is larger than its cell; the paper takes 4",
        ),
    ],
)
def test_a_mistake_is_one_line(options, line):
    done = invoke(options, "--json")
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr == f"error: {line}\n"


@pytest.mark.parametrize("model", ["confined-ellipse", "ellipse", "spheroid"])
@pytest.mark.parametrize(
    ("ratio", "line"),
    [
        ("0", "fiber.aspect_ratio = 0: must be at least 1"),
        ("-2", "fiber.aspect_ratio = -2: must be at least 1"),
        ("nan", '--aspect-ratio = "nan": is not finite'),
        ("inf", '--aspect-ratio = "inf": is not finite'),
        ("1e9", "fiber.aspect_ratio = 1e+09: must be at most 1"),  # it asked for a terabyte
    ],
)
def test_an_aspect_ratio_that_is_none(model, ratio, line):
    done = invoke({"--model": model, "--aspect-ratio": ratio}, "--json")
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr.startswith(f"error: {line}")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("option", ["--shear-rate", "--viscosity", "--domain-size", "--angle"])
@pytest.mark.parametrize("value", ["nan", "inf"])
def test_a_number_that_is_not_finite(option, value):
    done = invoke({option: value}, "--json")
    assert done.exit_code == 2
    assert done.stderr == f'error: {option} = "{value}": is not finite\n'


@pytest.mark.parametrize("model", ["ellipse", "spheroid"])
def test_a_domain_size_without_a_cell_is_refused(model):
    done = invoke({"--model": model, "--domain-size": "4"}, "--json")
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(f'error: domain_size = 4 with model = "{model}": that model has')
