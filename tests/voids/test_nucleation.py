"""Nucleation: the classical rate, the criteria, and their inverses."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.voids import (
    ClassicalNucleation,
    MechanicalCriterion,
    ResidenceCondition,
    critical_radius,
    molecules_per_volume,
    wetting_factor,
)
from fibermelt.voids.constants import BOLTZMANN, WATER_MOLECULE

ROUNDING = 1e-12  # a few tens of operations
TENSION, HOT = 23.8e-3, 503.15
WATER = float(molecules_per_volume(1.7e-3, 1154.0))
ABS = ClassicalNucleation(TENSION, HOT, WATER)
deficits = st.floats(1e4, 1e8)


def heterogeneous(factor: float, tension: float = TENSION) -> ClassicalNucleation:
    return ClassicalNucleation(tension, HOT, WATER, wetting_factor=factor)


def test_barrier_of_abs() -> None:
    # independent values for 23.8 mN/m: nm and k_B T
    deficit = np.array([0.5e6, 1e6, 2e6, 3.6e6])
    assert critical_radius(TENSION, deficit) * 1e9 == pytest.approx([95, 48, 24, 13], rel=0.02)
    ratio = 10.0 ** ABS.log10_barrier_ratio(deficit)
    assert ratio == pytest.approx([1.3e5, 3.3e4, 8.1e3, 2.5e3], rel=0.02)
    needed = ABS.required_wetting_factor(deficit)
    assert needed == pytest.approx([6.6e-4, 2.7e-3, 1.07e-2, 3.46e-2], rel=0.02)


def test_rate_as_printed() -> None:
    # Eq. 36 with a barrier low enough that nothing underflows
    low = heterogeneous(1e-3)
    deficit = 2e6
    barrier = 16 * math.pi * TENSION**3 / (3 * BOLTZMANN * HOT * deficit**2) * 1e-3
    printed = WATER * math.sqrt(2 * TENSION / (math.pi * WATER_MOLECULE)) * math.exp(-barrier)
    assert float(low.log10_rate(deficit)) == pytest.approx(math.log10(printed), rel=ROUNDING)


def test_the_barrier_is_a_third_of_the_surface_of_the_critical_bubble() -> None:
    # W* = (4/3) pi r_c^2 eta, Gibbs
    radius = float(critical_radius(TENSION, 1e6))
    gibbs = 4.0 / 3.0 * math.pi * radius**2 * TENSION / (BOLTZMANN * HOT)
    assert 10.0 ** float(ABS.log10_barrier_ratio(1e6)) == pytest.approx(gibbs, rel=ROUNDING)


def test_without_a_deficit_there_is_no_nucleus_and_nothing_overflows() -> None:
    rate = ABS.log10_rate([-1e6, 0.0, 1e-300, 1e-150, 1.0])
    assert np.all(np.isneginf(rate[:3]))
    assert np.all(rate[3:] < -1e9)
    assert np.all(np.isposinf(ABS.margin([-1e6, 0.0])))
    assert np.all(np.isposinf(critical_radius(TENSION, [-1.0, 0.0, 5e-324])))


def test_no_surface_helps_without_a_deficit() -> None:
    assert np.all(ABS.required_wetting_factor([-1e6, 0.0]) == 0.0)
    assert ABS.required_contact_angle([-1e6, 0.0]) == pytest.approx(np.pi, rel=ROUNDING)


@given(deficits, st.floats(1.001, 3.0))
def test_a_deeper_deficit_nucleates_more(deficit, factor) -> None:
    shallow, deep = ABS.log10_rate([deficit, factor * deficit])
    assert shallow < deep < ABS.log10_prefactor


@given(deficits, st.floats(0.01, 0.99), st.floats(300.0, 600.0))
def test_wetting_heat_and_moisture(deficit, factor, temperature) -> None:
    plain = float(ABS.log10_rate(deficit))
    assert float(heterogeneous(factor).log10_rate(deficit)) > plain
    cold = ClassicalNucleation(TENSION, temperature, WATER)
    hot = ClassicalNucleation(TENSION, temperature + 1.0, WATER)
    assert float(cold.log10_rate(deficit)) < float(hot.log10_rate(deficit))
    dry = ClassicalNucleation(TENSION, HOT, 0.5 * WATER)
    assert dry.log10_prefactor == pytest.approx(ABS.log10_prefactor - math.log10(2), rel=ROUNDING)


def test_spreading_is_homogeneous() -> None:
    spread = heterogeneous(float(wetting_factor(np.pi)))
    assert float(spread.log10_rate(1e6)) == float(ABS.log10_rate(1e6))


@given(st.floats(1e-6, 1.0), st.floats(-20.0, 30.0))
def test_required_deficit_is_where_the_threshold_is(factor, threshold) -> None:
    law = heterogeneous(factor)
    deficit = law.required_deficit(threshold)
    # the rate of change of the logarithm is twice the barrier: 2 * 90 k_B T of rounding
    assert float(law.log10_rate(deficit)) == pytest.approx(threshold, abs=1e-10)
    assert float(law.margin(deficit, threshold)) == pytest.approx(0.0, abs=1e-10)


@given(st.floats(1e5, 1e7), st.floats(-20.0, 30.0))
def test_required_wetting_is_where_the_threshold_is(deficit, threshold) -> None:
    factor = float(ABS.required_wetting_factor(deficit, threshold))
    law = heterogeneous(factor)
    assert float(law.log10_rate(deficit)) == pytest.approx(threshold, abs=1e-10)
    angle = float(ABS.required_contact_angle(deficit, threshold))
    assert float(wetting_factor(np.pi - angle)) == pytest.approx(factor, rel=1e-9)


def test_a_melt_that_nucleates_by_itself_needs_no_surface() -> None:
    beyond = 1.01 * ABS.required_deficit()
    assert float(ABS.required_wetting_factor(beyond)) > 1.0
    assert float(ABS.required_contact_angle(beyond)) == 0.0


def test_what_is_counted_in_hardly_matters() -> None:
    # per cubic centimeter instead of cubic meter, as ONE_EVENT claims
    assert ABS.required_deficit(6.0) / ABS.required_deficit(0.0) < 1.1


def test_no_pressure_beats_the_prefactor() -> None:
    with pytest.raises(ConfigError, match="cannot nucleate faster"):
        ABS.required_deficit(60.0)


def test_mechanical_criterion() -> None:
    law = MechanicalCriterion(0.95e6)
    assert law.margin([1e6, 0.95e6, -0.5e6]) == pytest.approx([0.05e6, 0.0, -1.45e6])
    assert law.is_met([1e6, 0.95e6, -0.5e6]).tolist() == [False, False, True]
    with pytest.raises(ConfigError, match="vapor pressure = -1 Pa"):
        MechanicalCriterion(-1.0)


def test_residence_condition() -> None:
    law = ResidenceCondition(2.3e-10)
    assert float(law.time(48e-9)) == pytest.approx(48e-9**2 / 2.3e-10, rel=ROUNDING)
    margin = law.margin([48e-9, 48e-9, 48e-9, np.inf], [1e-4, 1e-6, 0.0, 1.0])
    assert margin[0] == pytest.approx(math.log10(48e-9**2 / 2.3e-10 / 1e-4), rel=1e-9)
    assert margin[0] < 0.0 < margin[1]
    assert np.all(np.isposinf(margin[2:]))


def test_molecules() -> None:
    # 0.17 % of 1154 kg/m3 is 108.9 mol/m3
    assert molecules_per_volume(1.7e-3, 1154.0) == pytest.approx(108.9 * 6.022e23, rel=1e-3)
    with pytest.raises(ConfigError, match=r"moisture = 1\.7"):
        molecules_per_volume(1.7, 1154.0)


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: ClassicalNucleation(0.0, HOT, WATER), "surface tension = 0 N/m"),
        (lambda: ClassicalNucleation(TENSION, HOT, 0.0), "a dry melt does not nucleate"),
        (lambda: heterogeneous(0.0), "wetting factor = 0: must be above 0 and at most 1"),
        (lambda: heterogeneous(1.5), r"wetting factor = 1\.5"),
        (lambda: ResidenceCondition(0.0), "diffusivity = 0 m2/s"),
        (lambda: ABS.log10_rate(np.nan), "pressure deficit = nan"),
        (lambda: critical_radius(-1.0, 1e6), "surface tension = -1 N/m"),
        (lambda: ABS.log10_rate(np.inf), "pressure deficit = inf Pa: must be finite$"),
        # not a number was once counted as no time, and a negative radius as its square
        (lambda: ResidenceCondition(1e-9).margin(1e-8, np.nan), "available time = nan s"),
        (lambda: ResidenceCondition(1e-9).margin(1e-8, -1.0), "available time = -1 s"),
        (lambda: ResidenceCondition(1e-9).time(np.nan), "critical radius = nan m: must be above 0"),
        (lambda: ResidenceCondition(1e-9).time([1e-8, -1e-8]), "critical radius = -1e-08 m"),
    ],
)
def test_refusals(make, key: str) -> None:
    with pytest.raises(ConfigError, match=key):
        make()
