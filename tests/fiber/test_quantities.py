"""Quantities are declared once: attributes, units, words, and what sweeps keep and answer with."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from fibermelt.engine.netcdf import from_bytes, to_bytes
from fibermelt.engine.quantities import Quantity, declared, labelled, with_error
from fibermelt.errors import StoreError
from fibermelt.study.quantities import QUANTITIES
from fibermelt.sweeps.responses import responses_of
from fibermelt.units import SHOWN, parse

ALL = tuple(QUANTITIES.values())
LABELS = {one.name for one in ALL if one.dimensions == one.name}
LENGTH = Quantity("length", "", "m", "how long", "Length", "mm", "length_error")
KNOWN = declared(LENGTH, Quantity("length_error", "", "1", "error", relative=True))


@pytest.mark.parametrize("one", ALL, ids=lambda one: one.name)
def test_a_quantity_has_a_unit_that_exists_and_is_shown_in_one_of_its_kind(one):
    assert one.meaning
    assert one.name not in one.dimensions.split() or one.dimensions == one.name
    assert one.unit == "1" or parse(f"1 {one.unit}", one.unit) == 1
    if one.shown_in:
        unit = "" if one.unit == "1" else one.unit
        assert parse(f"1 {one.shown_in}", unit) * one.factor == pytest.approx(1, rel=1e-15)


@pytest.mark.parametrize("one", [one for one in ALL if one.error], ids=lambda one: one.name)
def test_an_error_has_the_shape_and_the_unit_of_its_quantity(one):
    error = QUANTITIES[one.error]
    assert set(error.dimensions.split()) <= set(one.dimensions.split())
    assert error.unit == ("1" if error.relative else one.unit)


def test_every_estimated_error_is_that_of_a_quantity():
    told = {one.name for one in ALL if one.meaning.startswith("estimated ")}
    assert told == {one.error for one in ALL} - {""}


@pytest.mark.parametrize("one", [one for one in ALL if one.response], ids=lambda one: one.name)
def test_a_response_says_what_it_is(one):
    assert one.title
    assert one.dimensions == ""
    assert one.stored or one.derive


def test_what_a_sweep_keeps_is_said_of_labels_only():
    assert {one.name for one in ALL if one.swept or one.kept_as} <= LABELS


def test_a_new_quantity_is_an_answer_of_a_sweep_by_its_declaration_alone(monkeypatch):
    monkeypatch.setitem(QUANTITIES, "length", replace(LENGTH, response=True))
    collected = xr.Dataset({"length": ("case", [1e-3, 3e-3])})
    (found,) = responses_of(collected, ("case",))
    assert (found.heading, found.meaning) == ("Length [mm]", "how long")
    np.testing.assert_allclose(found.values, [1.0, 3.0], rtol=1e-15)


def test_two_of_one_name_are_refused():
    with pytest.raises(ValueError, match="length is declared twice"):
        declared(LENGTH, LENGTH)


def test_labelled_arrays_survive_the_file():
    arrays = {"streamline": [1, 2], "zone_time": [[0.1, 0.2, 0.3]] * 2, "bead_height": 3e-3}
    before = labelled(arrays, QUANTITIES)
    assert from_bytes(to_bytes(before)).identical(before)
    assert before["bead_height"].attrs == {
        "units": "m",
        "long_name": QUANTITIES["bead_height"].meaning,
    }


@pytest.mark.parametrize("name", ["gapp", "lowest_mean_1"])
def test_what_is_not_declared_to_be_stored_is_refused(name):
    with pytest.raises(StoreError, match=f"variable {name} is not declared"):
        labelled({name: 1.0}, QUANTITIES)


def test_a_wrong_shape_is_refused():
    with pytest.raises(StoreError, match=r"zone_time has shape \(3,\), declared are"):
        labelled({"zone_time": [1.0, 2.0, 3.0]}, QUANTITIES)


def test_a_variable_without_a_unit_is_refused():
    dataset = labelled({"bead_height": 3e-3}, QUANTITIES)
    del dataset["bead_height"].attrs["units"]
    with pytest.raises(StoreError, match="variable bead_height has no units: give it both"):
        to_bytes(dataset)


@pytest.mark.parametrize(
    ("how", "text"),
    [
        ({}, "-2.009 mm"),
        ({"error": 0.86e-6}, "-2.00907 ± 0.00086 mm"),
        ({"error": math.nan, "size": 3e-3, "digits": 3}, "-2.01 mm"),
        ({"error": 0.0, "size": 30e-3, "digits": 3}, "-2.0 mm"),
    ],
)
def test_a_value_has_the_digits_of_its_error_or_of_its_size(how, text):
    assert LENGTH.with_unit(-2.00907e-3, **how) == text


def test_what_there_is_none_of_has_its_word():
    for write in (QUANTITIES["stall_angle"].written, QUANTITIES["stall_angle"].with_unit):
        assert write(math.nan) == "it tumbles"
    assert QUANTITIES["stall_angle"].with_unit(0.1) == "5.730 °"
    assert LENGTH.written(math.nan) == "–"


def test_a_relative_error_is_a_share_of_its_quantity():
    results = xr.Dataset({"length": -2e-3, "length_error": 0.1})
    assert with_error(results, "length", KNOWN) == pytest.approx((-2e-3, 2e-4), rel=1e-15)
    value, error = with_error(results.drop_vars("length_error"), "length", KNOWN)
    assert value == -2e-3
    assert math.isnan(error)


def test_units_that_are_shown_have_their_factors():
    si = {"m": "m", "s": "s", "Pa": "Pa", "%": "", "°": "rad"}
    for unit, factor in SHOWN.items():
        of = next(of for ending, of in si.items() if unit.endswith(ending))
        assert parse(f"1 {unit}", of) * factor == pytest.approx(1, rel=1e-15)
