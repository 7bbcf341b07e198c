"""Voids over a bead: hand-made pressures, the profile's weights, what is told, infinities."""

import json
import math
from functools import cache

import numpy as np
import pytest
from drawn_bead import made_up
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import Spheroid, embed_planar, unbounded_spheroid
from fibermelt.paper.claims.judge import claims, judge, measured
from fibermelt.paper.claims.measures import NotStoredError
from fibermelt.paper.claims.voids import VOIDS
from fibermelt.parts.melt.cards import load_card
from fibermelt.parts.voids import section as risk
from fibermelt.parts.voids.melt import moist_melt
from fibermelt.parts.voids.profile import layer_weights
from fibermelt.parts.voids.stages import assess_bead
from fibermelt.parts.voids.summary import BESIDE, summarize_voids, voids_in_words
from fibermelt.study.chain import CHAIN
from fibermelt.voids import ATMOSPHERE, saturation_pressure

ABS_AT = {"card": "paper", "temperature": 503.15}
STAGES = ("streamlines", "cell", "motion")
SATURATED = 0.005
"""Saturation of the card [-]."""


@cache
def small():
    """A made-up bead of two streamlines of five points, without its voids."""
    made = made_up(count=2, angles=3, points=5)
    made = made.drop_vars([name for name in made if name.startswith("void_")])
    return made.drop_dims(["void_basis", "void_selection", "void_layer"], errors="ignore")


def asked_melt(card, **given_):
    """Return the moist melt of a shipped card."""
    return moist_melt(load_card(card), **given_)


def bead(pressure=0.0, lowest=0.0, **overrides):
    """Results of two streamlines of five points in which only the given pressures act."""
    made = small().copy(deep=True)
    made["time"][:] = np.arange(5.0)
    made["pressure"][:] = pressure
    made["gradient"][:] = 0.0
    for name in ("lowest", "bound_lowest", "felt_lowest", "quantile_lowest"):
        made[name][:] = 0.0
    made["lowest"][:, 1] = lowest
    made["bound_lowest"][:] = made["felt_lowest"][:] = lowest
    made["near_singularity"][:] = 0
    for name, values in overrides.items():
        made[name][:] = values
    return made


def assessed(results, moisture=0.001, layers=2, **melt):
    found = assess_bead(
        dict.fromkeys(STAGES, results),
        817.0,
        asked_melt(**{**ABS_AT, **melt}, moisture=moisture),
        layers,
    )
    return found.assign({n: results[n] for n in BESIDE if n in results})


def of(found, name, basis="bounds"):
    return found[name].isel(void_basis=list(found["void_basis"].to_numpy()).index(basis)).to_numpy()


def test_time_below_of_a_hand_made_history():
    """V-shaped: 0 at both ends, -1 MPa in the middle, on top of the melt's own 0.9 MPa.

    P_L = 0.9 MPa + atmosphere - 0.5 MPa/s t up to t = 2 s, and back. It is below P_V from
    t = (0.9 MPa + atmosphere - P_V) / (0.5 MPa/s) on.
    """
    own = 0.9e6
    found = assessed(bead(pressure=own, lowest=-1e6 * np.array([0.0, 0.5, 1.0, 0.5, 0.0])))
    vapor = 0.2 * float(saturation_pressure(503.15))
    assert float(found["void_vapor_pressure"]) == pytest.approx(vapor, rel=1e-12)
    entry = (own + ATMOSPHERE - vapor) / 0.5e6
    assert of(found, "void_first_below") == pytest.approx([entry] * 2, rel=1e-12)
    assert of(found, "void_time_below") == pytest.approx([4.0 - 2.0 * entry] * 2, rel=1e-12)
    assert of(found, "void_lowest_pressure") == pytest.approx([own + ATMOSPHERE - 1e6] * 2)
    assert of(found, "void_margin") == pytest.approx([own + ATMOSPHERE - 1e6 - vapor] * 2)
    assert np.isnan(of(found, "void_first_below", "melt")).all()
    assert of(found, "void_time_below", "melt").tolist() == [0.0, 0.0]


def test_each_fiber_has_its_own_pressure_and_the_worst_is_that_of_the_fibers():
    found = assessed(bead(pressure=2e6, lowest=-1.5e6))
    assert found["void_fiber_lowest"][0].to_numpy() == pytest.approx(
        ATMOSPHERE + np.array([2e6, 0.5e6, 2e6])
    )
    assert of(found, "void_lowest_pressure", "fibers") == pytest.approx([ATMOSPHERE + 0.5e6] * 2)
    vapor = float(found["void_vapor_pressure"])
    along = of(found, "void_margin_along", "fibers")
    assert along == pytest.approx(np.full((2, 5), ATMOSPHERE + 0.5e6 - vapor))


@examples(20)
@given(pressure=st.floats(-2e6, 2e6), share=st.floats(0.0, 1.0))
def test_margins_are_linear_in_moisture_and_pressure(pressure, share):
    found = assessed(bead(pressure=pressure), moisture=share * SATURATED)
    vapor = share * float(saturation_pressure(503.15))
    margin = pressure + ATMOSPHERE - vapor
    # 1e-6 Pa of 1e6: the rounding of sums of pressures.
    assert of(found, "void_margin", "melt") == pytest.approx([margin] * 2, rel=1e-9, abs=1e-6)


def test_growth_exponents_are_of_fibers_and_of_the_melt_up_to_zone_3():
    """At rest and dry but for 1 MPa of tension on one fiber of three; zone 3 is at 2.5 s of 4."""
    tension = -1e6 - ATMOSPHERE
    results = bead(lowest=tension, zone_time=[0.5, 1.0, 2.5], viscosity=800.0)
    voids = summarize_voids(assessed(results, moisture=0.0))["voids"]
    on_it = 1e6 * 2.5 / (4 * 800.0)
    for line in voids["streamlines"]:
        told = line["growth_exponent"]
        assert told == pytest.approx({"mean": on_it / 3, "median": 0.0, "highest": on_it})
        assert line["exponent_by_basis"]["bounds"] == pytest.approx(on_it)
    assert voids["severity"] == pytest.approx({"fibers": on_it / 3, "melt": 0.0})
    assert voids["by_basis"]["fibers"]["growth_exponent"] == pytest.approx(on_it)
    without = assessed(results.drop_vars("zone_time"), moisture=0.0)
    assert float(without["severity_fibers"]) == pytest.approx(on_it / 3 * 4.0 / 2.5)


def test_severity_is_what_fibers_add_to_the_melt_without_singular_streamlines():
    pressure = np.array([[-2e5] * 5, [-4e5] * 5])
    results = bead(pressure=pressure, lowest=-3e5, near_singularity=[1, 0], viscosity=800.0)
    results["zone_time"][:, 2] = 4.0
    found = assessed(results, moisture=0.0)
    melt, added = (4e5 - ATMOSPHERE) / 800.0, 3e5 / 800.0 / 3
    voids = summarize_voids(found)["voids"]
    assert voids["severity"] == pytest.approx({"fibers": added, "melt": melt})
    bottom, top = voids["profile"]
    assert bottom["severity"] == {"fibers": None, "melt": None}
    assert top["severity"] == pytest.approx({"fibers": added, "melt": melt})
    both = {"fibers": added, "melt": (2e5 - ATMOSPHERE) / 800.0}
    assert bottom["including_singular"]["severity"] == pytest.approx(both)
    assert float(found["severity_fibers_error"]) == 0.0


def test_the_melt_boils_at_rest_above_the_moisture_whose_vapor_has_the_airs_pressure():
    boiling = SATURATED * ATMOSPHERE / float(saturation_pressure(503.15))
    for moisture, boils in ((0.999 * boiling, False), (1.001 * boiling, True)):
        rest = summarize_voids(assessed(bead(), moisture=moisture))["voids"]["rest"]
        assert rest["boils"] == boils
        assert rest["boiling_moisture"] == pytest.approx(boiling, rel=1e-9)


def test_critical_moisture_is_where_the_vapor_pressure_meets_the_local_one():
    found = assessed(bead(pressure=0.0, lowest=-0.5 * ATMOSPHERE))
    critical = float(found["void_critical_moisture"])
    again = assessed(bead(pressure=0.0, lowest=-0.5 * ATMOSPHERE), moisture=critical)
    assert of(again, "void_margin") == pytest.approx([0.0, 0.0], abs=1e-6)


def test_tension_leaves_no_moisture_and_pressure_every_one():
    under = assessed(bead(lowest=-2 * ATMOSPHERE))
    assert float(under["void_critical_moisture"]) == 0.0
    over = assessed(bead(pressure=5e6))
    assert math.isnan(float(over["void_critical_moisture"]))
    assert float(over["void_critical_moisture_mean"]) == pytest.approx(SATURATED)
    voids = summarize_voids(over)["voids"]
    assert voids["critical_moisture"] is None
    assert voids["streamlines"][0]["critical_radius"] is None
    assert voids["streamlines"][0]["log10_rate"] is None
    assert voids["streamlines"][0]["time_below"] == 0.0
    json.dumps(voids, allow_nan=False)
    words = "\n".join(voids_in_words({"voids": voids}))
    assert "Nothing: on no fiber, however it lies, does the pressure fall below" in words
    told = "\n".join(voids_in_words(summarize_voids(under)))
    assert "Nothing: on no fiber" not in told


def test_a_dry_melt_has_margins_and_no_rate():
    found = assessed(bead(lowest=-1e6), moisture=0.0)
    assert float(found["void_vapor_pressure"]) == 0.0
    assert np.isnan(of(found, "void_log10_rate")).all()
    assert np.isfinite(of(found, "void_critical_radius")).all()


def test_a_melt_too_dry_for_the_threshold_has_a_rate_and_no_wetting():
    found = assessed(bead(lowest=-1e6), moisture=1e-60)
    assert np.isfinite(of(found, "void_log10_rate")).all()
    assert np.isnan(of(found, "void_required_wetting")).all()


def test_a_card_with_holes_says_what_it_cannot_give():
    voids = summarize_voids(assessed(bead(lowest=-1e6), card="pla", temperature=483.15))["voids"]
    assert any("no critical time" in line for line in voids["material"]["missing"])
    assert voids["streamlines"][0]["critical_time"] is None
    assert voids["streamlines"][0]["critical_radius"] > 0.0


def test_the_spheroid_stands_beside_the_ellipse():
    """A sphere in planar extension of rate e: lowest pressure -5 mu e (tips and equator alike)."""
    rate = np.zeros((2, 5, 2, 2))
    rate[..., 0, 0], rate[..., 1, 1] = 2.0, -2.0
    results = bead(gradient=rate)
    results["aspect_ratio"] = results["aspect_ratio"] * 0.0 + 1.0
    found = assessed(results)
    expected = ATMOSPHERE - 5.0 * 817.0 * 2.0
    assert of(found, "void_lowest_pressure", "spheroid") == pytest.approx([expected] * 2, rel=1e-9)


def test_the_mean_over_an_orientation_tensor_is_that_of_its_fibers():
    """Against spheroids one by one, in directions whose second moment is the tensor."""
    rng = np.random.default_rng(7)
    rate = np.array([[3.0, 8.0], [-2.0, -3.0]])
    directions = rng.normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    tensor = np.einsum("ni,nj->ij", directions, directions) / 50
    results = bead(gradient=rate)
    results["orientation"] = (
        ("streamline", "point", "axis", "other_axis"),
        np.broadcast_to(tensor, (2, 5, 3, 3)),
    )
    melt = asked_melt(**ABS_AT, moisture=0.001)
    found = assess_bead(dict.fromkeys((*STAGES, "orientation"), results), 817.0, melt, 2)
    spheroid = unbounded_spheroid(Spheroid(1.0, float(results["aspect_ratio"])))
    tips = spheroid.tip(embed_planar(np.broadcast_to(rate, (50, 2, 2))), directions)
    mean = ATMOSPHERE + 817.0 * tips.mean()
    assert of(found, "void_lowest_pressure", "oriented tips") == pytest.approx([mean] * 2)


def test_voids_are_fed_orientation_where_the_study_has_it():
    stage = next(stage for stage in CHAIN.stages if stage.name == "voids")
    for parts, fed in ((("voids",), False), (("voids", "orientation"), True)):
        assert ("orientation" in stage.fed({"study.parts": parts})) == fed


@given(count=st.integers(1, 30), layers=st.integers(2, 30))
def test_every_layer_and_every_streamline_counts_fully(count, layers):
    weights = layer_weights(np.arange(count) + 0.5, np.ones(count, bool), layers)
    assert weights.sum(axis=1) == pytest.approx(np.ones(layers))
    # What a streamline gives to all layers is its share of the flux: 1/count of it.
    assert weights.sum(axis=0) / layers == pytest.approx(np.full(count, 1 / count))


def test_weights_follow_heights_and_leave_out_who_does_not_count():
    height = np.array([3.0, 1.0, 2.0])
    assert layer_weights(height, np.ones(3, bool), 3).tolist() == [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    left = layer_weights(height, np.array([True, False, True]), 3)
    assert left.tolist() == [[0, 0, 0], [0, 0, 1], [1, 0, 0]]


def test_a_singular_streamline_is_told_apart():
    pressure = np.array([[-2e6] * 5, [1e6] * 5])
    results = bead(pressure=pressure, near_singularity=[1, 0])
    voids = summarize_voids(assessed(results))["voids"]
    assert voids["lowest_pressure"] == pytest.approx(1e6 + ATMOSPHERE)
    assert voids["including_singular"]["lowest_pressure"] == pytest.approx(-2e6 + ATMOSPHERE)
    assert [line["near_singularity"] for line in voids["streamlines"]] == [True, False]
    bottom, top = voids["profile"]
    assert bottom["lowest_pressure"] is None
    assert bottom["including_singular"]["lowest_pressure"] == pytest.approx(-2e6 + ATMOSPHERE)
    assert top["lowest_pressure"] == pytest.approx(1e6 + ATMOSPHERE)


def test_nothing_but_singular_streamlines_is_said_so():
    found = assessed(bead(near_singularity=[1, 1]))
    summary = summarize_voids(found)
    assert summary["voids"]["lowest_pressure"] is None
    assert summary["voids"]["severity"] == {"fibers": None, "melt": None}
    assert "every streamline passes a" in "\n".join(voids_in_words(summary))
    with pytest.raises(NotStoredError, match="no trend to judge"):
        VOIDS["void_profile_of_fibers"](found)


def test_a_flow_that_was_not_solved_here_has_no_bed():
    results = bead(lowest=-2 * ATMOSPHERE).assign(path_divergence=("streamline", [0.0, 0.0]))
    summary = summarize_voids(assessed(results))
    assert not [name for name in assessed(results) if "layer" in name or "height" in name]
    assert summary["voids"]["profile"] == []
    assert "height" not in summary["voids"]["streamlines"][0]
    page = risk.voids.words(assessed(results), summary)
    for told in ("\n".join(voids_in_words(summary)), page):
        others = ("bead", "the bed", "both speeds", "treamline")
        assert not [word for word in others if word in told]
    assert "the bed" in "\n".join(voids_in_words(summarize_voids(assessed(bead()))))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_reversed_profile_turns_the_verdict(sign):
    results = made_up()
    rise = sign * np.arange(results.sizes["void_layer"], dtype=float)
    for name in ("void_layer_fiber_pressure", "void_layer_mean_pressure"):
        values = results[name].transpose("void_layer", ...)
        values[:] = rise.reshape(-1, *[1] * (values.ndim - 1))
        results[name] = values
    for name, quantity in VOIDS.items():
        assert quantity(results) == pytest.approx(sign), name
    mine = [claim for claim in claims() if claim.quantity in VOIDS]
    verdicts = {judge(claim, *measured(claim, results)).verdict for claim in mine}
    assert verdicts == {"holds" if sign > 0 else "differs"}


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({"moisture": 0.0075}, r"^voids\.moisture = 0\.75 %: must be at most 0\.5 %, saturation"),
        ({"temperature": 600.0}, r"^melt\.temperature = 600 K: must be from 473\.15 to 533\.15 K"),
        ({"card": "pei"}, r"^voids\.moisture: the card of PEI has none: give one"),
        ({"card": "ps"}, r"^melt\.material: PS: isotherm\.content, .*: no value in the card"),
    ],
)
def test_what_a_card_does_not_allow_is_refused_by_its_key(given_, message):
    with pytest.raises(ConfigError, match=message):
        asked_melt(**{"card": "paper", **given_})


def test_from_card_is_as_received_at_the_temperature_of_printing():
    melt = asked_melt("paper")
    assert (melt.moisture, melt.temperature, melt.log10_threshold) == (0.0017, 503.15, 0.0)


@pytest.mark.parametrize(
    ("material", "temperature", "hint"),
    [
        ("paper", 230.0, True),
        ("paper", 150.0, True),  # too cold even so, but no melt is below the freezing point
        ("pei", 360.0, True),  # above it, and yet the card's own range in degrees Celsius
        ("paper", 360.0, False),
        ("paper", 573.15, False),
    ],
)
def test_a_temperature_that_was_meant_in_celsius_is_told_how_to_be_written(
    material, temperature, hint
):
    with pytest.raises(ConfigError, match=r"^melt\.temperature = .*: must be from ") as raised:
        asked_melt(material, moisture=1e-4, temperature=temperature)
    assert (f'write "{temperature:g} degC"' in str(raised.value)) == hint


def test_what_is_left_out_is_judged_by_what_is_felt():
    """Streamlines at singular corners count by the bound where corners are known, else as found."""
    results = bead(near_singularity=[1, 0], lowest=-1e6)
    results["felt_lowest"][0] = -3e6
    voids = summarize_voids(assessed(results))["voids"]
    assert voids["lowest_pressure"] == pytest.approx(ATMOSPHERE - 1e6)
    assert voids["by_basis"]["felt"]["lowest_pressure"] == pytest.approx(ATMOSPHERE - 1e6)
    assert voids["including_singular"]["lowest_pressure"] == pytest.approx(ATMOSPHERE - 3e6)
    without = summarize_voids(assessed(results.drop_vars("felt_lowest")))["voids"]
    assert "felt" not in without["by_basis"]
    assert without["including_singular"]["lowest_pressure"] == pytest.approx(ATMOSPHERE - 1e6)
