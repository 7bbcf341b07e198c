"""`fibermelt orientation` and `domain-size`: keys, known numbers, and what they refuse."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.flows import FLOWS
from fibermelt.orientation.models import FolgarTucker, shape_factor
from fibermelt.orientation.steady import steady_state

pytestmark = pytest.mark.end_to_end

ORIENTATION = ["a", "angle", "eigenvalues", "iterations", "residual"]
DOMAIN = [
    "convention",
    "interaction",
    "preferred_angle",
    "domain_size",
    "regime",
    "largest_stalling_domain",
]
"""What scripts rely on, in this order; more may follow."""

PAPER = {
    "orientation": {"--closure": "ORE", "--interaction": "0.0128", "--aspect-ratio": "6"},
    "domain-size": {"--aspect-ratio": "6", "--volume-fraction": "0.084"},
}
ROUNDING = 1e-12
PRINTED = 5e-5  # half a unit of the last digit that is known of an angle

CLOSED = 0.05
"""What the closure costs at the paper's interaction: 0.038 in planar, 0.040 in mixed flow."""

RESIDUAL = 1e-12
"""What is promised of a steady state."""


def invoke(command, *more, **options):
    named = {f"--{name.replace('_', '-')}": value for name, value in options.items()}
    given = {**PAPER[command], **named}
    arguments = [part for name, value in given.items() if value for part in (name, value)]
    return CliRunner().invoke(app, [command, *arguments, *more])


def answer(command, *more, **options):
    done = invoke(command, "--json", *more, **options)
    assert (done.exit_code, done.stderr) == (0, "")
    return json.loads(done.stdout)


def refused(command, *more, code=2, **options):
    done = invoke(command, "--json", *more, **options)
    assert (done.exit_code, done.stdout) == (code, "")
    assert done.stderr.startswith("error: ")
    assert len(done.stderr.splitlines()) == 1
    return done.stderr.removeprefix("error: ").rstrip("\n")


def test_the_keys_of_an_orientation():
    found = answer("orientation")
    assert list(found)[: len(ORIENTATION)] == ORIENTATION
    assert np.shape(found["a"]) == (3, 3)
    assert isinstance(found["iterations"], int)


def test_simple_shear_is_along_1_and_changes_along_2():
    found = answer("orientation")
    a = np.array(found["a"])
    assert a[0, 0] > a[2, 2] > a[1, 1]  # the flow, the vorticity, the gradient
    assert a[0, 1] == a[1, 0] > 0.0
    assert np.trace(a) == pytest.approx(1.0, abs=ROUNDING)
    assert found["angle"] == pytest.approx(0.0965, abs=PRINTED)
    tangent = math.atan2(2 * a[0, 1], a[0, 0] - a[1, 1]) / 2
    assert found["angle"] == pytest.approx(tangent, rel=ROUNDING)
    assert found["eigenvalues"] == pytest.approx(np.linalg.eigvalsh(a)[::-1], abs=ROUNDING)
    assert found["iterations"] <= 10
    assert found["residual"] < RESIDUAL


@pytest.mark.parametrize(
    ("closure", "convention", "angle"),
    [
        ("ORE", "paper", 0.1259),
        ("ORF", "standard", 0.0873),
        ("IBOF", "paper", 0.1249),
        ("exact", "standard", 0.0969),
        ("exact-pdf", "standard", 0.1060),
        ("exact-pdf", "paper", 0.1307),
    ],
)
def test_preferred_angles_of_the_papers_suspension(closure, convention, angle):
    found = answer("orientation", closure=closure, convention=convention)
    assert found["angle"] == pytest.approx(angle, abs=PRINTED)
    assert list(found)[: len(ORIENTATION)] == ORIENTATION
    assert found["residual"] < RESIDUAL
    assert (found["physical"], found["stable"]) == (True, True)


@pytest.mark.parametrize("flow", FLOWS)
def test_every_flow(flow):
    found = answer("orientation", flow=flow)
    model = FolgarTucker(shape_factor(6.0), 0.0128)
    direct = steady_state(model, FLOWS[flow], CLOSURES["ORE"]).a
    assert np.array(found["a"]) == pytest.approx(direct, abs=ROUNDING)
    exact = np.array(answer("orientation", flow=flow, closure="exact-pdf")["a"])
    assert np.array(found["a"]) == pytest.approx(exact, abs=CLOSED)


@pytest.mark.parametrize(
    ("model", "parameters"),
    [
        ("rsc", ["kappa=1"]),
        ("mrd", ["first=1", "second=1", "third=1"]),
        ("iard", ["anisotropy=0"]),
        ("nematic", ["potential=0"]),
        ("ard-rsc", ["b1=0.0128"]),
    ],
)
def test_models_in_the_limit_of_folgar_and_tuckers(model, parameters):
    more = [part for one in parameters for part in ("--parameter", one)]
    coefficient = None if model == "ard-rsc" else "0.0128"
    found = answer("orientation", *more, model=model, interaction=coefficient)
    assert np.array(found["a"]) == pytest.approx(np.array(answer("orientation")["a"]), abs=1e-10)


def test_an_orientation_in_words():
    done = invoke("orientation")
    assert done.exit_code == 0
    assert "preferred       5.528 deg from direction 1 (0.09648 rad)" in done.stdout
    assert "note" not in done.stdout
    done = invoke("orientation", closure="linear", interaction="0.001", flow="biaxial")
    assert "preferred       none in the plane of 1 and 2" in done.stdout
    assert "\nnote            no fibers are oriented so: eigenvalues leave [0, 1]\n" in done.stdout
    assert "\nnote            not stable: not every small change dies away\n" in done.stdout


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"interaction": "0"}, "interaction = 0: C_I must be positive, e.g. 0.0128"),
        ({"interaction": "-1"}, "interaction = -1: C_I must be positive"),
        ({"interaction": "nan"}, '--interaction = "nan": is not finite'),
        ({"interaction": "few"}, '--interaction = "few": is not a number'),
        ({"closure": "OREE"}, "closure 'OREE' is unknown; did you mean 'ORE'? (known: linear"),
        ({"closure": "exact-pd"}, "closure 'exact-pd' is unknown; did you mean 'exact-pdf'?"),
        ({"aspect_ratio": "0.5"}, "fiber.aspect_ratio = 0.5: must be at least 1"),
        ({"model": "rcs"}, "orientation model 'rcs' is unknown; did you mean 'rsc'?"),
        (
            {"model": "ard-rsc"},
            "--interaction with --model ard-rsc: the model has b1, b2, b3, b4, b5, kappa in its "
            "place: drop --interaction, and give --parameter b1=...",
        ),
        ({"model": "jeffery"}, "--model jeffery: without interaction there is nothing to find"),
        ({"interaction": None}, "--model folgar-tucker: needs --interaction C_I, such as 0.0128"),
        (
            {"interaction": None, "model": "ard-rsc"},
            "--model ard-rsc: takes b1, b2, b3, b4, b5, kappa besides: add --parameter b1=...",
        ),
        ({"model": "rsc"}, "--model rsc: takes kappa besides: add --parameter kappa=..."),
        ({"flow": "shear"}, "flow 'shear' is unknown; did you mean 'simple-shear'?"),
        ({"convention": "papers"}, "folgar-tucker: convention 'papers' is unknown; did you mean"),
        (
            {"closure": "exact-pdf", "model": "mrd"},
            "--closure exact-pdf with --model mrd: the distribution is of isotropic diffusion",
        ),
    ],
)
def test_a_mistake_about_an_orientation_is_one_line(options, line):
    assert refused("orientation", **options).startswith(line)


def test_an_orientation_that_has_no_answer_is_no_mistake():
    options = {"closure": "linear", "flow": "uniaxial", "interaction": "0.001"}
    assert refused("orientation", code=1, **options).startswith(
        "steady state of folgar-tucker with closure linear: the branch from isotropy ends at "
        "C_I = 0.06"
    )


@pytest.mark.parametrize(
    ("given", "line"),
    [
        (["kapa=0.1"], "--parameter kapa: no parameter of the model rsc; it takes kappa"),
        (["kappa=2"], "rsc: kappa = 2 must be in [0, 1]"),
        (["kappa"], "--parameter kappa: write it as name=value, such as kappa=0.1"),
        (["kappa=much"], '--parameter kappa = "much": is not a number'),
        (["kappa=0.1", "kappa=1"], "--parameter kappa: is given twice"),
    ],
)
def test_a_mistake_about_a_parameter_is_one_line(given, line):
    more = [part for one in given for part in ("--parameter", one)]
    assert refused("orientation", *more, model="rsc").startswith(line)


@pytest.fixture(scope="module")
def domains():
    """The cell of the paper's content by convention; each solves a dozen cells."""
    return {name: answer("domain-size", convention=name) for name in ("standard", "paper")}


def test_the_keys_of_a_domain_size(domains):
    assert list(domains["standard"])[: len(DOMAIN)] == DOMAIN


def test_the_papers_content_and_its_cell(domains):
    for found in domains.values():
        assert found["interaction"] == pytest.approx(0.0128, abs=PRINTED)
        assert found["largest_stalling_domain"] == pytest.approx(5.2933, abs=PRINTED)
        assert found["regime"] == "semi-dilute"
        assert found["extrapolates"]  # Bay's law is of concentrated melts
    assert domains["paper"]["domain_size"] == pytest.approx(4.08, abs=0.1)
    assert domains["standard"]["domain_size"] == pytest.approx(4.470, abs=5e-4)
    assert domains["paper"]["preferred_angle"] == pytest.approx(0.1261, abs=PRINTED)


def test_a_domain_size_in_words():
    done = invoke("domain-size", interaction="0.0128", closure="exact-pdf")
    assert done.exit_code == 0
    assert "interaction     C_I = 0.01280 (semi-dilute suspension)" in done.stdout
    assert "preferred       6.072 deg from the flow in simple shear" in done.stdout
    # Two conventions, two answers: each says which it is.
    assert "convention      standard" in done.stdout
    assert "stalls          in cells up to M = 5.2933" in done.stdout
    assert "extrapolates" not in done.stdout  # no law was asked


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"volume_fraction": "0"}, "fiber.volume_fraction = 0: must lie between 0 and 1"),
        ({"volume_fraction": "1"}, "fiber.volume_fraction = 1: must lie between 0 and 1"),
        (
            {"volume_fraction": "8.4"},
            "fiber.volume_fraction = 8.4: must lie between 0 and 1, both excluded (8.4 percent is "
            "0.084)",
        ),
        ({"volume_fraction": "-0.1"}, "fiber.volume_fraction = -0.1: must lie"),
        ({"interaction": "0"}, "interaction = 0: C_I must be positive"),
        ({"closure": "ORE2"}, "closure 'ORE2' is unknown; did you mean 'ORE'?"),
        ({"law": "bai"}, 'interaction law "bai" is unknown: did you mean "bay"?'),
        ({"law": "bai", "interaction": "0.01"}, 'interaction law "bai" is unknown'),
        (
            {"law": "phan-thien", "interaction": "0.01"},
            "interaction = 0.01 with law = phan-thien: the law is for who has no coefficient: give "
            "one of the two",
        ),
        ({"aspect_ratio": "1"}, "fiber.aspect_ratio = 1: must be above 1; a circle"),
        ({"aspect_ratio": "0.5"}, "fiber.aspect_ratio = 0.5: must be at least 1"),
        ({"interaction": "0.2"}, "stall angle = 0.4787 rad: no cell stalls a fiber of r_e = 6"),
    ],
)
def test_a_mistake_about_a_domain_size_is_one_line(options, line):
    assert refused("domain-size", **options).startswith(line)
