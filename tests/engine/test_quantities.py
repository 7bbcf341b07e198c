"""A quantity is declared once: its attributes, its units and the words for its values follow."""

import math

import pytest
import xarray as xr

from fibermelt.engine.netcdf import from_bytes, to_bytes
from fibermelt.engine.quantities import Quantity, declared, labelled, with_error
from fibermelt.errors import StoreError
from fibermelt.study.quantities import QUANTITIES

LENGTH = Quantity("length", "", "m", "how long", "Length", "mm")
KNOWN = declared(LENGTH, Quantity("length_error", "", "1", "error", relative=True))


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
