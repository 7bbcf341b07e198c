"""The answers on voids: no more is said than all that was judged says."""

from __future__ import annotations

from typing import Any

import pytest

from fibermelt.parts.voids.answer import (
    ADDED,
    ADVICE,
    BOILS,
    HELPS,
    PAPER,
    SURE,
    answered,
    by_layer,
)
from fibermelt.voids import ATMOSPHERE

VAPOR = 2e4
"""That of a dry melt [Pa]."""


def told(**changes: Any) -> dict[str, str]:
    """Return the answers by their questions, of a dry bead whose pressures are high."""
    safe = {"lowest_pressure": 3 * VAPOR, "growth_exponent": 0.0}
    layers = [{"height": 1e-3 * k, "severity": {"fibers": 0.0, "melt": 0.0}} for k in (1, 2)]
    voids: dict[str, Any] = {
        "moisture": 4e-5,
        "temperature": 503.15,
        "vapor_pressure": VAPOR,
        "rest": {"boils": False, "boiling_moisture": 2e-4},
        "severity": {"fibers": 0.0, "melt": 0.0},
        "by_basis": {"melt": safe, "bounds": safe, "spheroid": safe},
        "including_singular": safe,
        "void_fraction": {"bead": None, "tips": None, "rest": None},
        "profile": layers,
        "streamlines": [{"near_singularity": False}] * 10,
        **changes,
    }
    return {one["question"]: one["answer"] for one in answered(voids)}


def low(pressure: float) -> dict[str, float]:
    return {"lowest_pressure": pressure, "growth_exponent": 0.0}


def test_a_melt_boils_at_rest_whatever_the_nozzle_does() -> None:
    assert told()[BOILS].startswith("No: 0.004 % moisture has a vapor pressure of 0.0200 MPa")
    assert "it would from 0.02 % on" in told()[BOILS]
    held = told(rest={"boils": False, "boiling_moisture": None})
    assert "no moisture that the polymer can hold makes it boil" in held[BOILS]
    near = told(moisture=1.1e-4, vapor_pressure=0.55 * ATMOSPHERE)
    assert near[BOILS].startswith("Barely not: 0.011 % moisture")
    assert "it is sure not to from 0.01 % down" in near[BOILS]
    assert near[ADVICE].startswith("Dry below 0.01 % first")
    boils = {"boils": True, "boiling_moisture": 2e-4}
    wet = told(moisture=4e-4, vapor_pressure=2 * ATMOSPHERE, rest=boils)
    assert wet[BOILS].startswith("Yes, whatever the nozzle does")
    assert "2 times the air’s. From 0.02 % down it does not." in wet[BOILS]
    assert wet[ADVICE].startswith("Dry below 0.01 % first")


@pytest.mark.parametrize(
    "changes",
    [
        {"including_singular": low(1.9 * VAPOR)},
        {"by_basis": {"bounds": low(3 * VAPOR), "spheroid": low(1.9 * VAPOR)}},
        {"by_basis": {"bounds": low(-1e5), "spheroid": low(3 * VAPOR)}},
    ],
)
def test_free_of_voids_is_said_only_where_all_that_was_judged_says_so(
    changes: dict[str, Any],
) -> None:
    assert told()[ADDED].startswith("Nothing: on no fiber, however it lies")
    assert "on no fiber" not in told(**changes)[ADDED]
    assert told(**changes)[ADDED].startswith("Nothing on the fibers that were followed; one in its")


def test_what_fibers_add_is_told_by_layer_and_against_another_run() -> None:
    layers = [
        {"height": 1e-3, "severity": {"fibers": 4.0, "melt": 0.0}},
        {"height": 2e-3, "severity": {"fibers": 0.0, "melt": 0.0}},
        {"height": 3e-3, "severity": {"fibers": None, "melt": None}},
    ]
    other: dict[str, Any] = {"name": "before", "fibers": 4.0, "melt": 0.0, "profile": []}
    changes: dict[str, Any] = {
        "severity": {"fibers": 2.0, "melt": 0.5},
        "by_basis": {"melt": low(0.5 * VAPOR), "bounds": low(-1e5)},
        "profile": layers,
        "against": other,
    }
    said = told(**changes)[ADDED]
    assert said.startswith("A growth exponent of 2, on average, beside the melt’s own 0.5")
    assert "7.4 times as wide" in said  # e^2
    assert "Most, 4, 1 mm above the bed, least, 0, at 2 mm" in said
    assert "0.50 times what they add on before, layer by layer" not in said  # of one layer alone
    other["profile"] = [{"fibers": 2.0, "melt": 0.0}] * 3
    both = [{**layers[0]}, {"height": 2e-3, "severity": {"fibers": 1.0, "melt": 0.0}}, layers[2]]
    beside = told(**{**changes, "profile": both})[ADDED]
    assert (
        "0.50 times what they add on before, layer by layer from 0.50 (2 mm above the bed) to 2 "
        "(1 mm)" in beside
    )
    assert "sharp corner" not in said
    assert "void content" not in said
    content = {"bead": 0.012, "tips": 0.01, "rest": 0.002}
    assert (
        "void content of 1.2 % at the end of the swell, 1 % by the fibers"
        in (told(**changes, void_fraction=content)[ADDED])
    )
    lines = [{"near_singularity": k < 3} for k in range(10)]
    left = told(**changes, streamlines=lines)[SURE]
    assert "Without the 3 of 10 streamlines, 30 % of the melt, that pass a sharp corner" in left
    endless = told(**{**changes, "severity": {"fibers": 20.0, "melt": 5.0}})[ADDED]
    assert "until the moisture around it is used up" in endless


def test_layers_of_another_number_are_taken_by_what_lies_below_them() -> None:
    layers = [{"height": k * 1e-3, "severity": {"fibers": 6.0}} for k in range(4)]
    two = [{"fibers": 3.0}, {"fibers": 1.0}]
    found = by_layer({"profile": layers, "against": {"profile": two}})
    assert [one["ratio"] for one in found] == [2.0, 2.0, 6.0, 6.0]
    # Beside nothing there is no ratio; the paper's bead has ten layers.
    nothing = by_layer({"profile": layers, "against": {"profile": [{"fibers": 0.0}]}})
    assert [one["ratio"] for one in nothing] == [None] * 4
    own = [{"height": 0.0, "severity": layer} for layer in PAPER["profile"]]
    assert [one["ratio"] for one in by_layer({"profile": own})] == [1.0] * 10
    mean = sum(one["fibers"] for one in PAPER["profile"]) / 10
    assert mean == pytest.approx(PAPER["fibers"], rel=0.1)  # but for layers half left out


def test_no_streamline_to_judge_is_no_answer() -> None:
    assert told(severity={"fibers": None, "melt": None})[ADDED].startswith("Not told")


LEVERS = [
    {"lever": "gap", "key": "flow.gap", "moved": "gap 3 mm to 2.85 mm", "fibers_ratio": 0.9,
     "dry_ratio": 0.95},
    {"lever": "nozzle", "key": "flow.capillary_width", "moved": "nozzle 3 mm to 2.85 mm",
     "fibers_ratio": 1.3, "dry_ratio": 0.8},
    {"lever": "land", "key": "flow.capillary_length", "moved": "land 6 mm to 5.7 mm",
     "fibers_ratio": 1.001, "dry_ratio": 1.0},
    {"lever": "moisture", "key": "voids.moisture", "moved": "moisture 0.1 % to 0.05 %",
     "fibers_ratio": 0.4, "dry_ratio": None},
]  # fmt: skip


def test_levers_come_strongest_first_and_idle_ones_are_named() -> None:
    said = told(levers=LEVERS)[HELPS]
    assert said == (
        "Of what fibers add there is left: moisture 0.1 % to 0.05 %, 40 %; nozzle 3 mm to 2.85 "
        "mm, 130 %; gap 3 mm to 2.85 mm, 90 %. No effect: land."
    )
    boiling = told(
        levers=LEVERS, vapor_pressure=2e5, rest={"boils": True, "boiling_moisture": 2e-4}
    )[HELPS]
    assert boiling.startswith("Drying: moisture 0.1 % to 0.05 % leaves 40 % of what fibers add. ")
    assert "Once dry, of what fibers add there is left: nozzle 3 mm to 2.85 mm, 80 %" in boiling
    assert HELPS not in told()


def test_a_recommendation_tells_what_it_came_to() -> None:
    found = {
        "settings": {"flow.gap": 2.85e-3},
        "written": {"flow.gap": "2.85 mm"},
        "fibers_ratio": 0.5,
        "melt_ratio": None,
        "void_fraction": 0.001,
        "void_fraction_before": 0.01,
    }
    assert told(recommendation=found)[ADVICE] == (
        "Set flow.gap = 2.85 mm. That was run: the fibers add 50 % of what they add now, the void "
        "content at the end of the swell goes 1 % to 0.10 %."
    )
    assert told(recommendation={"settings": {}})[ADVICE].startswith("Leave it")


def test_doubts_come_with_their_factors() -> None:
    doubts = [{"source": "card", "factor": 2.4}, {"source": "nucleus", "factor": None}]
    assert told(uncertainty=doubts)[SURE] == ("The severity may be off by these factors: card 2.4.")
    assert SURE not in told()
