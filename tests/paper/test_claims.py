"""Claims are judged by the numbers: a changed number turns the verdict."""

import math
import re
from collections import Counter

import numpy as np
import pytest
import xarray as xr
from drawn_bead import made_up

from fibermelt.engine.parameters import flatten
from fibermelt.engine.stages import Parameters
from fibermelt.engine.toml import resolved_toml
from fibermelt.paper.claims.conditions import conditions_of
from fibermelt.paper.claims.judge import MEASURES, Claim, Judgement, claims, measured
from fibermelt.paper.claims.judge import judge as judged
from fibermelt.paper.claims.part import PART, STAGES_OF
from fibermelt.paper.claims.stages import claims_stage
from fibermelt.paper.claims.summary import claims_in_words, summarize_claims
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study

EVERY = {claim.id: claim for claim in claims()}


def judge(claim: Claim, results: xr.Dataset) -> Judgement:
    return judged(claim, *measured(claim, results))


PARAMETERS = Parameters(flatten(load_study("paper").config))


@pytest.fixture
def results():
    """Made-up results of a bead, with the study that they are of."""
    bead = made_up()
    bead.attrs["config"] = resolved_toml(load_study("paper").config, "made up")
    return bead


def test_every_claim_has_its_quantity_and_every_quantity_its_claim():
    assert len(EVERY) == len(claims())
    assert {claim.quantity for claim in claims()} == set(MEASURES)


@pytest.mark.parametrize("claim", claims(), ids=lambda claim: claim.id)
def test_a_statement_of_the_paper_stands_without_its_neighbours(claim):
    """The page can leave out the rows before it."""
    first = claim.statement.split()[0]
    assert first not in {"It", "That", "There", "Those", "This", "With"}
    assert not re.search(
        r"\b(the same|that (time|entrance|component)|does it)\b", claim.statement, re.I
    )


@pytest.mark.parametrize("claim", claims(), ids=lambda claim: claim.id)
def test_what_only_we_test_is_not_said_to_be_the_papers(claim):
    """The paper follows ellipses in a plane, as they turn, and leaves no streamline out."""
    ours = (
        r"whatever direction|worst direction|in space|spheroid|singular|all streamlines|sqrt\(2\)"
    )
    assert not re.search(ours, claim.statement)


def test_tests_of_one_statement_differ_in_what_they_test():
    shared = Counter(claim.statement for claim in claims())
    assert shared["Voids are likelier near the bed than near the free surface."] == 6
    assert len({(claim.statement, claim.measure) for claim in claims()}) == len(claims())


@pytest.mark.parametrize("claim", claims(), ids=lambda claim: claim.id)
def test_a_claim_says_where_it_stands_and_why_its_bound_is_what_it_is(claim):
    assert claim.section[0] in "234A"
    assert claim.statement.endswith(".")
    assert claim.why
    assert claim.measure
    assert 0 < len(claim.passes_if) < 60
    # Only a number that the paper prints may stand as the paper's.
    assert (claim.said != "") == (claim.paper is not None)
    if claim.paper is not None:
        assert claim.said.startswith(f"{claim.paper:g}")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"paper": 1.0}, "give a value and its tolerance, or bounds"),
        ({"tolerance": 1.0}, "give a value and its tolerance, or bounds"),
        ({}, "give a value and its tolerance, or bounds"),
        ({"at_least": 1.0, "unit": "furlong"}, "unit 'furlong' is none of"),
    ],
)
def test_a_claim_that_cannot_be_judged_is_refused(wrong, message):
    given = {"unit": "", **wrong}
    with pytest.raises(ValueError, match=message):
        Claim("x", "3", "It is.", "entrance_minimum", "it", why="so", **given)


@pytest.mark.parametrize(
    ("level", "verdict"), [(-0.5, "holds"), (-0.5499, "holds"), (-0.56, "differs")]
)
def test_a_stored_number_turns_the_verdict(results, level, verdict):
    results["extreme"].loc[{"location": 1, "kind": "min"}] = level * 1e6
    found = judge(EVERY["loc1-level"], results)
    assert found.verdict == verdict
    assert found.value == pytest.approx(level, abs=1e-12)
    if verdict == "differs":
        assert found.reason.startswith("0.06 MPa below what the paper says: ")


def test_a_reversed_trend_turns_the_verdict(results):
    """The lowest pressure made to rise, then to fall, from each streamline to the one above."""
    height = results["y"].to_numpy()[:, -1]
    rise = np.argsort(np.argsort(height)).astype(float)
    for sign, verdict in ((1.0, "holds"), (-1.0, "differs")):
        results["lowest"][:] = (sign * rise * 1e5)[:, None, None]
        results["pressure"][:] = 0.0
        found = judge(EVERY["voids-near-bed"], results)
        assert (found.verdict, round(found.value, 12)) == (verdict, sign)


def test_a_part_that_was_not_run_cannot_be_judged(results):
    found = judge(EVERY["loc1-level"], results.drop_vars("extreme"))
    assert (found.verdict, found.ours) == ("cannot be judged", "")
    assert found.reason == 'the study has no part "bead"'


def test_another_number_of_streamlines_is_not_the_papers(results):
    found = judge(EVERY["center-loc1-above-air"], results.isel(streamline=slice(0, 5)))
    assert found.verdict == "cannot be judged"
    assert "is one of 22; this study has 5" in found.reason


def test_every_number_is_finite_and_the_table_complete(results):
    found = claims_stage(PARAMETERS, {"motion": results.drop_attrs(deep=False)}, print)
    summary = summarize_claims(found)
    assert [one["id"] for one in summary["claims"]] == list(EVERY)
    for claim in claims():
        value = judge(claim, results).value
        assert value is None or math.isfinite(value)
    lines = claims_in_words(summary)
    assert all(any(line.startswith(name) for line in lines) for name in EVERY)
    tally = lines[-1].removeprefix("claims").split(",")
    assert sum(int(part.split()[0]) for part in tally) == len(EVERY)


def test_a_stored_value_turns_the_verdict_of_a_study(results):
    found = claims_stage(PARAMETERS, {"motion": results.drop_attrs(deep=False)}, print)
    place = found["claim"].to_numpy().tolist().index("loc1-level")
    for value, verdict in ((-0.5, "holds"), (-0.4, "differs"), (math.nan, "cannot be judged")):
        found["claim_value"][place] = value
        summary = summarize_claims(found)
        assert summary["claims"][place]["verdict"] == verdict


def test_claims_are_fed_by_the_parts_that_a_study_has():
    assert PART.brings[0].inputs_if({"study.parts": ("claims",)}) == ()
    assert PART.brings[0].inputs_if({"study.parts": ("bead", "voids")}) == (
        "streamlines",
        "motion",
        "voids",
    )
    names = {stage.name for stage in CHAIN.stages}
    assert {name for fed in STAGES_OF.values() for name in fed} < names


def test_known_reasons_are_told_under_the_papers_conditions_only(results):
    results["extreme"].loc[{"location": 1, "kind": "min"}] = -0.3e6
    found = claims_stage(PARAMETERS, {"motion": results.drop_attrs(deep=False)}, print)
    place = found["claim"].to_numpy().tolist().index("loc1-level")
    for override, told in (((), "the paper's mesh overstates"), (("flow.gap=3.1 mm",), "not the")):
        asked = load_study("paper", override).config
        of = summarize_claims(found.assign_attrs(conditions_of(asked)))["claims"][place]
        assert of["verdict"] == "differs"
        assert told in of["reason"]


def test_shares_differ_by_percentage_points():
    claim = Claim("a", "1", "s", "q", "m", "%", "why", at_most=10.0)
    assert judged(claim, 40.0).reason.startswith("30 percentage points above the bound")
    exact = Claim("a", "1", "s", "q", "m", "%", "why", paper=10.0, tolerance=2.0)
    assert exact.passes_if == "within 2 percentage points of 10 %"
    assert (exact.said, claim.said) == ("10 %", "")
