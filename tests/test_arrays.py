"""What looks like an array of numbers and is none, and values whose arrays stay as they are."""

import copy
import pickle
from datetime import timedelta
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import fibermelt as fm
from fibermelt.arrays import real_array
from fibermelt.fiber import StallCurve
from fibermelt.flow.field import FlowField


class WithUnit:
    """What packages for units have in common."""

    magnitude = 3.0
    units = "mm"


MASKED = np.ma.masked_array([1.0, -9999.0], mask=[False, True])


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (MASKED, r"x\[1\] is masked"),
        ([MASKED, MASKED], r"x\[1\] is masked"),
        (np.ma.masked, "x is masked"),
        (np.array(["2024-05-01"], "M8[D]"), "holds dates"),
        (np.array(["2024-05-01"], "M8[D]").astype(object), "holds dates"),
        (np.array([1, 2], "m8[ms]"), "holds durations: give numbers in SI$"),
        ([timedelta(seconds=1)], "holds durations"),
        (np.array([1.0 + 0.0j]), "is complex"),
        (np.array([1.0 + 0.0j], dtype=object), "is complex"),
        ([True, False], "holds true and false"),
        (np.array([True, 1.0], dtype=object), "holds true and false"),
        (["1", "2"], "is no array of numbers"),
        (np.array(["1", 2.0], dtype=object), "is no array of numbers"),
        ([[1.0, 2.0], [3.0]], "is no array of numbers"),
        (None, "is no array of numbers"),
        (WithUnit(), "carries a unit"),
        ([WithUnit()], "carries a unit"),
    ],
)
def test_what_is_no_number(value, said):
    with pytest.raises(fm.ConfigError, match=said):
        real_array("x", value)
    with pytest.raises(fm.HistoryError, match=r"^x"):
        real_array("x", value, error=fm.HistoryError)


@pytest.mark.parametrize(
    "value",
    [
        [1, 2],
        (1.0, np.float32(2.0)),
        np.array([1, 2], np.uint8),
        np.array([1.0, 2.0], np.longdouble),
        np.ma.masked_array([1.0, 2.0], mask=False),
        [Fraction(1), Decimal(2)],
    ],
)
def test_what_is_a_number(value):
    found = real_array("x", value)
    assert type(found) is np.ndarray
    assert found.dtype == np.float64
    assert found.tolist() == [1.0, 2.0]


@pytest.mark.parametrize("unit", ["W", "D", "h", "m", "s", "ms", "us", "ns", "ps"])
def test_durations_are_seconds(unit):
    given = np.array([0, 1, 7], f"m8[{unit}]")
    exact = [int(k) * {"W": 604800, "D": 86400, "h": 3600, "m": 60}.get(unit, 1) for k in (0, 1, 7)]
    parts = {"ms": 10**3, "us": 10**6, "ns": 10**9, "ps": 10**12}.get(unit, 1)
    for value in (given, list(given)):
        found = real_array("time", value, duration=True)
        assert found.tolist() == [float(Fraction(k, parts)) for k in exact]


def test_durations_of_other_packages():
    pandas = pytest.importorskip("pandas")
    times = pandas.to_timedelta([0.0, 0.25, 1.5], unit="s")
    for value in (times, pandas.Series(times), list(times), times.to_pytimedelta()):
        assert real_array("time", value, duration=True).tolist() == [0.0, 0.25, 1.5]
    dates = pandas.Timestamp("2024-05-01") + times
    for value in (dates, pandas.Series(dates), dates.tz_localize("UTC")):
        with pytest.raises(fm.ConfigError, match="holds dates"):
            real_array("time", value, duration=True)


@pytest.mark.parametrize("unit", ["Y", "M", ""])
def test_durations_that_are_no_seconds(unit):
    given = np.array([1, 2], f"m8[{unit}]" if unit else "m8")
    with pytest.raises(fm.ConfigError, match=r"time holds durations: .*seconds"):
        real_array("time", given, duration=True)


def test_a_history_of_durations_is_that_of_their_seconds():
    plain = fm.simple_shear(1.0, 10.0, 51)
    time = (1e3 * plain.time).round().astype("m8[ms]")
    parts = (plain.position, plain.velocity, plain.gradient, plain.pressure)
    timed = fm.FlowHistory(time, *parts)
    assert np.allclose(timed.time, plain.time, rtol=0.0, atol=1e-12)  # whole milliseconds


FIELD = FlowField(
    1,
    np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    np.array([[0, 1, 2]]),
    np.zeros((3, 2)),
    np.zeros(3),
    np.zeros((3, 2, 2)),
    np.zeros(3),
    np.ones(3),
    np.zeros(3),
)
HISTORY = fm.simple_shear(1.0, 10.0, 51)
RESPONSE = fm.unbounded_ellipse(fm.Ellipse(1.0, 6.0))
MOTION = fm.follow(HISTORY, 0.9, [0.0])
KEEPING = {
    "history": HISTORY,
    "bundle": fm.FlowHistory.stack([HISTORY, HISTORY]),
    "response": RESPONSE,
    "pressure": fm.surface_pressure(HISTORY, RESPONSE, 817.0, MOTION),
    "stall curve": StallCurve(6.0, np.array([3.0, 4.0]), np.array([1.1, 0.9]), 0.0),
    "field": FIELD,
}


def copies(value):
    """Return a value and what may be made of it."""
    return value, copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("name", KEEPING)
def test_what_is_kept_for_a_value_stays_right(name):
    """Its arrays cannot be written to, nor those of a copy."""
    for value in copies(KEEPING[name]):
        arrays = {k: v for k, v in vars(value).items() if isinstance(v, np.ndarray)}
        assert arrays
        for key, array in arrays.items():
            assert not array.flags.writeable, key
            assert np.array_equal(array, getattr(KEEPING[name], key))


def test_the_maps_that_motions_share_are_read_only():
    maps = MOTION.deformation
    assert not any(a.flags.writeable for a in (maps.matrix, maps.scale, maps.turn))


def test_a_copied_history_answers_as_the_original():
    for one in copies(HISTORY):
        assert np.array_equal(fm.follow(one, 0.9, [0.0]).angle, MOTION.angle)
        found = fm.surface_pressure(one, RESPONSE, 817.0, MOTION)  # the same path, by its numbers
        assert np.array_equal(found.lowest, KEEPING["pressure"].lowest)


def test_a_response_keeps_nothing_in_a_copy():
    RESPONSE.support  # noqa: B018  # kept from now on
    assert "support" not in vars(copy.deepcopy(RESPONSE))
