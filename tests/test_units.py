import math
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.units import parse, parse_difference, shown


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("24 mm/s", "m/s", 0.024),
        ("3.175 mm", "m", 0.003175),
        ("3.5mm", "m", 0.0035),
        ("42 um", "m", 42e-6),
        ("42 µm", "m", 42e-6),
        ("817 Pa s", "Pa s", 817.0),
        ("817 Pa·s", "Pa s", 817.0),
        ("817 Pa\N{DOT OPERATOR}s", "Pa s", 817.0),
        ("817 Pa\N{BULLET OPERATOR}s", "Pa s", 817.0),
        ("0.817 kPa*s", "Pa s", 817.0),
        ("1154 kg/m3", "kg/m^3", 1154.0),
        ("1.154 g/cm^3", "kg/m^3", 1154.0),
        ("1.154 g/cm**3", "kg/m^3", 1154.0),
        ("1154 kg/m³", "kg/m^3", 1154.0),
        ("1 1/(m³ s)", "1/(m^3 s)", 1.0),
        ("10 s⁻¹", "1/s", 10.0),
        ("\N{MINUS SIGN}1e\N{MINUS SIGN}3 m", "m", -0.001),
        ("8.4 %", "", 0.084),
        ("10 1/s", "1/s", 10.0),
        ("10 /s", "1/s", 10.0),
        ("10 s^-1", "1/s", 10.0),
        ("2 kJ/(kg K)", "J/(kg K)", 2000.0),
        ("1 in", "m", 0.0254),
        ("-1e-3 m", "m", -0.001),
        ("6", "", 6.0),
        (6, "", 6.0),
        (0.003, "m", 0.003),
    ],
)
def test_quantities(text, unit, value):
    """Equal to the last bit: a value addresses stored results however it was written."""
    assert parse(text, unit) == value


def test_degrees():
    assert parse("30 deg", "rad") == pytest.approx(math.pi / 6, rel=1e-15)
    assert parse("-90°", "rad") == -math.pi / 2


def test_temperatures_have_an_offset():
    assert parse("230 degC", "K") == 503.15
    assert parse("230 °C", "K") == 503.15
    assert parse("230 \N{DEGREE CELSIUS}", "K") == 503.15


@pytest.mark.parametrize(
    ("value", "unit", "message"),
    [
        ("3 s", "m", 'has the unit "s", which measures time, not length'),
        ("3 m", "rad", "not an angle"),
        ("3 m", "", "not a pure number"),
        ("3 furlongz", "m", 'has the unit "furlongz", which is not known'),
        ("3", "m", "has no unit: write one, or the bare number 3 for m"),
        ("three mm", "m", "is not a number in m"),
        ("3,5 mm", "m", "write a decimal point"),
        ("", "m", "is not a number in m"),
        (True, "m", "is not a number in m"),
        (None, "m", "is not a number in m"),
        ([3], "m", "is not a number in m"),
        (math.nan, "m", "is not finite"),
        ("1e999 m", "m", "is not finite"),
        ("1e999999999 mm", "m", "is not finite"),
        (10**400, "m", "is not finite"),
        ("1" * 400 + " mm", "m", "is not finite"),
        ("3 dB", "", 'the unit "dB", which is logarithmic'),
        ("3 Ym^9*Ym^9/m^9/m^8", "m", "cannot be converted to m"),
        ("3 ym^9*ym^9/m^9/m^8", "m", "cannot be converted to m"),
        ("3 " + "m*" * 3000 + "m", "m", r'the unit "m\*m.{54}\.\.\.", which is not known'),
        ("3 mm\n\x1b", "m", r"is not known"),
        ("1" * 400, "m", r"bare number 1{57}\.\.\. for m"),
    ],
)
def test_faults(value, unit, message):
    with pytest.raises(ConfigError, match=message):
        parse(value, unit)


@pytest.mark.parametrize(
    "unit", ["m(", "m)", "m^9^9^9", "__import__('os')", "m if 1 else s", "m(2)", "m*", "*m", "m;s"]
)
def test_a_unit_is_never_evaluated(unit):
    with pytest.raises(ConfigError, match="is not known"):
        parse(f"3 {unit}", "m")


@pytest.mark.parametrize("value", ["3 " + "a" * 50 + "!", "1" * 50_000 + " 2", " " * 50_000])
def test_nonsense_is_refused_at_once(value):
    """The time to read a text does not explode with its length: a second here is for ever there."""
    parse("3 mm", "m")  # reads the table of units, once
    start = time.process_time()
    with pytest.raises(ConfigError):
        parse(value, "m")
    assert time.process_time() - start < 1.0


@given(
    st.decimals(min_value="1e-6", max_value="1e6", places=6),
    st.sampled_from([("mm", 3), ("um", 6), ("m", 0), ("km", -3), ("cm", 2)]),
)
def test_decimal_units_are_exact(number, unit):
    name, digits = unit
    assert parse(f"{number} {name}", "m") == float(number.scaleb(-digits))


@given(st.floats(min_value=1e-6, max_value=1e6), st.sampled_from(["mm", "in", "um", ""]))
def test_what_is_shown_is_read_back(value, like):
    """Twelve digits are shown."""
    assert parse(shown(value, "m", like), "m") == pytest.approx(value, rel=1e-11)


def test_shown_temperature():
    assert shown(503.15, "K", "degC") == "230 degC"
    assert shown(0.5, "") == "0.5"


@pytest.mark.parametrize(
    ("fahrenheit", "kelvin"), [("446", 503.15), ("32", 273.15), ("0", 459.67 / 1.8)]
)
def test_a_zero_far_off_costs_no_digits(fahrenheit: str, kelvin: float) -> None:
    assert parse(f"{fahrenheit} degF", "K") == pytest.approx(kelvin, rel=2e-16)  # one rounding
    assert parse_difference("18 degF", "K") == pytest.approx(10.0, rel=2e-16)


@pytest.mark.parametrize(
    ("text", "mark"), [("1,5 mm", ","), ("3,5", ","), ("-1,000.5 mm", ","), ("12_000 mm", "_")]
)
def test_a_number_as_written_elsewhere(text: str, mark: str) -> None:
    with pytest.raises(ConfigError, match=f'^has "{mark}" in its number: write a decimal point'):
        parse(text, "m")
