"""What the parts declare of their quantities fits together."""

import re

import numpy as np
import pytest
import xarray as xr
from stored_bead import stored_results

from fibermelt.engine.quantities import Quantity, labelled
from fibermelt.parts.bead.summary import summarize_bead
from fibermelt.parts.flow.quantities import QUANTITIES as FLOW
from fibermelt.report.page.sections import SECTIONS
from fibermelt.study.quantities import QUANTITIES
from fibermelt.sweeps.responses import responses_of
from fibermelt.units import SHOWN, parse

ALL = tuple(QUANTITIES.values())
ESTIMATED = {one.name for one in ALL if one.meaning.startswith("estimated ")}
LABELS = {one.name for one in ALL if one.dimensions == one.name}


@pytest.mark.parametrize("one", ALL, ids=lambda one: one.name)
def test_a_quantity_has_a_unit_that_exists_and_is_shown_in_one_of_its_kind(one):
    assert one.meaning
    assert one.name not in one.dimensions.split() or one.dimensions == one.name
    assert one.unit == "1" or parse(f"1 {one.unit}", one.unit) == 1
    if one.shown_in:
        unit = "" if one.unit == "1" else one.unit
        assert parse(f"1 {one.shown_in}", unit) * one.factor == pytest.approx(1, rel=1e-15)


@pytest.mark.parametrize(
    "one", [one for one in ALL if one.error in ESTIMATED], ids=lambda one: one.name
)
def test_an_error_has_the_shape_and_the_unit_of_its_quantity(one):
    error = QUANTITIES[one.error]
    assert set(error.dimensions.split()) <= set(one.dimensions.split())
    assert error.unit == ("1" if error.relative else one.unit)


def test_every_estimated_error_is_that_of_a_quantity():
    assert {one.error for one in ALL} >= ESTIMATED


@pytest.mark.parametrize("one", [one for one in ALL if one.response], ids=lambda one: one.name)
def test_a_response_says_what_it_is(one):
    assert one.title
    assert one.dimensions == ""
    assert one.stored or one.derive


def test_what_a_sweep_keeps_is_said_of_labels_only():
    assert {one.name for one in ALL if one.swept or one.kept_as} <= LABELS


def test_a_new_quantity_is_an_answer_of_a_sweep_by_its_declaration_alone(monkeypatch):
    length = Quantity("length", "", "m", "how long", "Length", "mm", response=True)
    monkeypatch.setitem(QUANTITIES, "length", length)
    collected = xr.Dataset({"length": ("case", [1e-3, 3e-3])})
    (found,) = responses_of(collected, ("case",))
    assert (found.heading, found.meaning) == ("Length [mm]", "how long")
    np.testing.assert_allclose(found.values, [1.0, 3.0], rtol=1e-15)


def test_a_new_number_of_the_flow_is_in_the_summary_and_on_the_page(monkeypatch):
    bead = stored_results()
    swell = Quantity("swell", "", "m", "how far it swells", "Swell", "mm")
    monkeypatch.setitem(FLOW, "swell", swell)
    monkeypatch.setitem(FLOW, "swell_error", Quantity("swell_error", "", "m", "its error"))
    results = bead.assign(labelled({"swell": 2.5e-4, "swell_error": 1e-6}, FLOW))
    summary = summarize_bead(results)
    assert summary["flow"]["swell"] == 2.5e-4
    (numbers,) = (section for section in SECTIONS if section.name == "numbers")
    told = re.sub(r"<[^>]+>", " ", numbers.words(results, summary))
    assert re.search(r"Swell\s+0\.2500 ± 0\.0010\s+mm", told)
    assert re.search(r"Swell\s+how far it swells", told)


def test_units_that_are_shown_have_their_factors():
    si = {"m²": "m^2", "m": "m", "s": "s", "Pa": "Pa", "%": "", "°": "rad"}
    for unit, factor in SHOWN.items():
        of = next(of for ending, of in si.items() if unit.endswith(ending))
        assert parse(f"1 {unit}".replace("²", "^2"), of) * factor == pytest.approx(1, rel=1e-15)
