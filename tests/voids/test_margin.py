"""Paths against a vapor pressure: gauge and absolute, crossings, shapes."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError, HistoryError
from fibermelt.voids import (
    ATMOSPHERE,
    ClassicalNucleation,
    MechanicalCriterion,
    ResidenceCondition,
    assess,
    assess_onset,
)

ROUNDING = 1e-12  # a few tens of operations


def test_air_saturated_with_water_at_its_boiling_point_has_no_margin() -> None:
    # a melt at rest in air is at zero gauge; vapor of one atmosphere is just in balance with it
    found = assess([0.0, 1.0], [0.0, 0.0], ATMOSPHERE)
    assert float(found.margin) == 0.0
    assert float(found.lowest_pressure) == ATMOSPHERE
    assert float(found.time_below) == 0.0
    assert np.isposinf(found.first_below)


def test_crossings_are_linear_in_time() -> None:
    # absolute 3, 1, 1, 3 Pa against 2: below from 0.5 to 4.5
    found = assess([0.0, 1.0, 4.0, 5.0], [3.0, 1.0, 1.0, 3.0], 2.0, ambient=0.0)
    assert float(found.time_below) == pytest.approx(4.0, rel=ROUNDING)
    assert float(found.first_below) == pytest.approx(0.5, rel=ROUNDING)
    assert float(found.lowest_time) == 1.0
    assert int(found.lowest_index) == 1
    assert float(found.deficit) == -float(found.margin) == 1.0


def test_several_stays_and_a_start_below() -> None:
    found = assess([1.0, 2.0, 3.0, 4.0, 5.0], [1.0, 3.0, 1.0, 3.0, 4.0], 2.0, ambient=0.0)
    assert float(found.time_below) == pytest.approx(0.5 + 0.5 + 0.5, rel=ROUNDING)
    assert float(found.first_below) == 1.0
    touching = assess([0.0, 1.0, 2.0], [3.0, 2.0, 3.0], 2.0, ambient=0.0)
    assert float(touching.time_below) == 0.0
    always = assess([0.0, 1.0, 2.0], [-3.0, -2.0, -3.0], 2.0, ambient=0.0)
    assert float(always.time_below) == 2.0
    through = assess([0.0, 1.0, 2.0], [1.0, 2.0, 3.0], 2.0, ambient=0.0)
    assert float(through.time_below) == 1.0


@given(st.lists(st.integers(-9, 9), min_size=3, max_size=12), st.integers(0, 9))
def test_against_a_fine_sampling(values, vapor) -> None:
    t = np.arange(float(len(values)))
    found = assess(t, np.array(values, dtype=float), float(vapor), ambient=0.0)
    steps = 2000
    middles = (np.arange(steps * (len(values) - 1)) + 0.5) / steps
    below = np.interp(middles, t, values) < vapor
    # each interval is resolved to one sample
    assert float(found.time_below) == pytest.approx(below.sum() / steps, abs=len(values) / steps)
    assert (found.time_below > 0.0) == np.isfinite(found.first_below)


@given(st.floats(0.0, 5e6), st.floats(1e3, 1e6))
def test_more_vapor_less_margin_and_more_time(vapor, more) -> None:
    t = np.linspace(0.0, 1.0, 50)
    p = 1e6 * np.cos(7.0 * t)
    less, wetter = (assess(t, p, v) for v in (vapor, vapor + more))
    assert float(wetter.margin) < float(less.margin)
    assert float(wetter.time_below) >= float(less.time_below)
    assert float(wetter.first_below) <= float(less.first_below)


def test_a_study_at_once_is_its_paths_one_by_one() -> None:
    rng = np.random.default_rng(6)
    t = np.cumsum(rng.uniform(0.1, 1.0, (4, 1, 60)), axis=-1)
    p = np.cumsum(rng.normal(size=(4, 3, 60)), axis=-1) * 1e5
    vapor = np.array([1e5, 3e5, 2e5])
    found = assess(t, p, vapor)
    assert found.margin.shape == found.time_below.shape == found.lowest_index.shape == (4, 3)
    for i in range(4):
        for j in range(3):
            alone = assess(t[i, 0], p[i, j], vapor[j])
            for name in ("margin", "time_below", "first_below", "lowest_time", "lowest_index"):
                assert getattr(found, name)[i, j] == pytest.approx(
                    float(getattr(alone, name)), rel=1e-12
                )
    criterion = [MechanicalCriterion(v).is_met(p + ATMOSPHERE).any(axis=-1) for v in vapor]
    met = np.array([[criterion[j][i, j] for j in range(3)] for i in range(4)])
    assert np.array_equal(found.margin < 0.0, met)


def test_one_path_at_several_moistures() -> None:
    found = assess([0.0, 1.0, 2.0], [0.0, -2e5, 0.0], np.linspace(0.0, 1e6, 11))
    assert found.margin.shape == (11,)
    assert all(later > earlier for later, earlier in pairwise(found.margin))


def test_onset() -> None:
    found = assess([[0.0, 1.0, 2.0]] * 2, [[5e5, -5e5, 5e5], [5e6, 4e6, 5e6]], 1.5e6)
    law = ClassicalNucleation(23.8e-3, 503.15, 6.6e25)
    onset = assess_onset(found, law, ResidenceCondition(2.3e-10))
    deficit = 1.5e6 + 5e5 - ATMOSPHERE
    assert onset.critical_radius[0] == pytest.approx(2 * 23.8e-3 / deficit, rel=ROUNDING)
    assert onset.critical_time is not None
    assert onset.residence_margin is not None
    assert onset.critical_time[0] == pytest.approx(onset.critical_radius[0] ** 2 / 2.3e-10)
    assert onset.residence_margin[0] == pytest.approx(
        math.log10(onset.critical_time[0] / found.time_below[0]), rel=1e-9
    )
    assert onset.rate_margin[0] == -onset.log10_rate[0] > 1e3
    assert 0.0 < onset.required_wetting_factor[0] < 0.02
    # the second path never comes near: nothing starts, at any wetting
    assert np.isposinf([onset.critical_radius[1], onset.rate_margin[1]]).all()
    assert np.isposinf([onset.critical_time[1], onset.residence_margin[1]]).all()
    assert onset.required_contact_angle[1] == pytest.approx(np.pi)
    bare = assess_onset(found, law)
    assert bare.critical_time is None
    assert bare.residence_margin is None


@pytest.mark.parametrize(
    ("time", "pressure", "key"),
    [
        ([0.0, 1.0], [0.0, 1.0, 2.0], "the same number of points"),
        ([0.0], [0.0], "at least 2"),
        ([0.0, 0.0], [0.0, 1.0], r"time must increase strictly: the step after time\[0\] is 0 s"),
        ([0.0, 1.0], [0.0, np.nan], r"lowest_pressure\[1\] = nan is not finite"),
        ([0.0, np.inf], [0.0, 1.0], r"time\[1\] = inf is not finite"),
    ],
)
def test_no_path(time, pressure, key) -> None:
    with pytest.raises(HistoryError, match=key):
        assess(time, pressure, 1e5)


def test_vapor_pressures_of_other_paths() -> None:
    with pytest.raises(HistoryError, match=r"paths of shapes \(\) \(time\) and \(3, 2\) .* \(5,\)"):
        assess([0.0, 1.0], np.zeros((3, 2, 2)), np.ones(5))


def test_pressures_that_are_not_absolute() -> None:
    with pytest.raises(ConfigError, match="vapor_pressure = -1 Pa"):
        assess([0.0, 1.0], [0.0, 1.0], -1.0)
    with pytest.raises(ConfigError, match="ambient = -5 Pa: must be at least 0 Pa; it is absolute"):
        assess([0.0, 1.0], [0.0, 1.0], 1.0, ambient=-5.0)
