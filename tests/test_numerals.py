"""Numbers in words: their digits follow the size of the thing, and none is rounded away."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.numerals import NOISE, places, rounded
from fibermelt.report.kit.tables import ranged, sized

sizes = st.floats(1e-5, 1e6)


@pytest.mark.parametrize(
    ("value", "size", "told"),
    [
        (0.0314, 3.175, "0.03"),
        (0.0314, 0.4, "0.031"),
        (-0.0004, 0.4, "-0.0004"),
        (12.345, 7.6, "12.35"),
        (0.9996, 0.9996, "1.00"),
        (1234.5, 1234.5, "1234"),
        (0.0, 0.4, "0.000"),
        (-1e-17, 3.0, "0.00"),
        (0.5, 0.0, "0.5"),
        (-1.234e-9, 1.234e-9, "-1.23e-09"),
    ],
)
def test_digits_follow_the_size(value: float, size: float, told: str) -> None:
    assert rounded(value, size) == told


@given(st.floats(-1e6, 1e6), sizes)
def test_no_number_is_rounded_to_nothing(value: float, size: float) -> None:
    text = rounded(value, size)
    assert (float(text) == 0) == (abs(value) <= NOISE * size)
    if float(text):
        # Half a unit of the last digit told, or of the first one of a number of its own.
        assert abs(float(text) - value) <= 0.5 * 10.0 ** -places(size, 3) * (1 + 1e-9)


@given(st.floats(0.1, 9.0), st.integers(-2, 1))
def test_the_same_thing_at_another_scale_has_the_same_digits(value: float, power: int) -> None:
    other = value * 10.0**power
    digits = [rounded(one, one).replace(".", "").lstrip("0") for one in (value, other)]
    # A half rounds either way, as the multiple of a power of ten is not exact.
    assert abs(int(digits[0]) - int(digits[1])) <= 1


def test_ends_are_told_apart() -> None:
    assert ranged(0.1062, 0.1384) == "0.106 to 0.138"
    assert ranged(100.01, 101.6) == "100.0 to 101.6"
    assert ranged(3.0001, 3.0004) == "3.0001 to 3.0004"
    assert ranged(-3.0, 0.19, between="and") == "−3.00 and 0.19"
    assert ranged(2.0, 2.0) == "2.00 to 2.00"


def test_print_has_its_own_signs() -> None:
    assert sized(-4e-7, 3.0) == "−4 × 10⁻⁷"
    assert sized(None, 1.0) == "–"
    assert sized(float("nan"), 1.0) == "–"
