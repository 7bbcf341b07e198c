"""Moisture and vapor pressure, both ways."""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.voids import (
    ActivityLaw,
    Henry,
    critical_moisture,
    saturation_pressure,
)
from fibermelt.voids.constants import WATER_CRITICAL, WATER_TRIPLE

FEW = examples(40)  # each bisects several times
ROUNDING = 1e-12  # a few tens of operations
HOT = 503.15
CONTENT = 0.005
ABS = ActivityLaw(CONTENT, 296.15)
LAWS = {
    "henry": Henry(CONTENT / float(saturation_pressure(296.15)), 296.15, -43e3),
    "activity": ABS,
    "activity, shifting": ActivityLaw(0.0139, 293.15, 870.0),
}

temperatures = st.floats(300.0, 640.0)
parts = st.floats(1e-6, 1.0)


def test_saturation_at_the_printing_temperature() -> None:
    # Wagner and Pruss 2002: 2.797 MPa to the digits given
    assert float(saturation_pressure(HOT)) == pytest.approx(2.797e6, rel=2e-4)
    assert float(saturation_pressure(373.124)) == pytest.approx(101325.0, rel=2e-4)  # boiling


def test_saturation_keeps_the_shape_and_takes_both_ends() -> None:
    T = np.array([[WATER_TRIPLE, 300.0, 400.0], [500.0, 600.0, WATER_CRITICAL]])
    P = saturation_pressure(T)
    assert P.shape == T.shape
    assert np.all(np.diff(P.ravel()) > 0.0)
    assert P[0, 0] == pytest.approx(611.66, rel=3e-4)  # IAPWS: triple-point pressure
    assert P[1, 2] == pytest.approx(22.064e6, rel=3e-4)  # IAPWS: critical pressure


@pytest.mark.parametrize("temperature", [250.0, 700.0, np.nan])
def test_no_saturation_beyond_the_liquid(temperature: float) -> None:
    with pytest.raises(ConfigError, match=r"temperature = .*from 273.16 to 647.096 K; water"):
        saturation_pressure(temperature)


@pytest.mark.parametrize(
    ("moisture", "pressure"), [(5e-4, 0.28e6), (1e-3, 0.56e6), (1.7e-3, 0.95e6), (3e-3, 1.68e6)]
)
def test_abs_by_activity(moisture: float, pressure: float) -> None:
    found = float(ABS.vapor_pressure(moisture, HOT))
    assert found == pytest.approx(pressure, abs=0.005e6)  # the reference gives 10 kPa


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@FEW
@given(part=parts, temperature=temperatures)
def test_there_and_back(law, part: float, temperature: float) -> None:
    moisture = part * float(law.saturation_content(temperature))
    if moisture > 1.0:  # Henry's law with this heat: more water than melt near the critical point
        return
    pressure = law.vapor_pressure(moisture, temperature)
    # bisection of a logarithm ends at its rounding, some 1e-14; the activity is as steep as one
    assert float(law.moisture(pressure, temperature)) == pytest.approx(moisture, rel=1e-9)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@FEW
@given(part=st.floats(0.01, 0.9), temperature=st.floats(300.0, 600.0))
def test_more_moisture_or_heat_more_vapor(law, part: float, temperature: float) -> None:
    moisture = part * float(law.saturation_content(temperature))
    here = float(law.vapor_pressure(moisture, temperature))
    assert float(law.vapor_pressure(1.1 * moisture, temperature)) > here
    assert float(law.vapor_pressure(moisture, temperature + 1.0)) > here
    assert here < float(saturation_pressure(temperature))


def test_saturation_is_where_the_vapor_is_saturated() -> None:
    for law in LAWS.values():
        content = float(law.saturation_content(400.0))
        assert float(law.vapor_pressure(content, 400.0)) == pytest.approx(
            float(saturation_pressure(400.0)), rel=1e-9
        )
        assert float(law.vapor_pressure(0.0, 400.0)) == 0.0
        assert float(law.moisture(0.0, 400.0)) == 0.0


def test_henry_with_the_heat_of_condensation_is_the_activity_law() -> None:
    # d ln P_sat/d(1/T) between two near temperatures is the heat that makes both agree there
    cold, hot = 400.0, 401.0
    slope = np.log(saturation_pressure(hot) / saturation_pressure(cold)) / (1 / hot - 1 / cold)
    heat = float(slope) * 8.314462618
    henry = Henry(CONTENT / float(saturation_pressure(cold)), cold, heat)
    assert float(henry.saturation_content(hot)) == pytest.approx(CONTENT, rel=1e-9)


def test_pei_holds_a_little_more_when_hot() -> None:
    # J. Appl. Polym. Sci. 77 (2000) 1439: 1.39 % at 20 degC, 1.50 % at 100 degC
    assert float(LAWS["activity, shifting"].saturation_content(373.15)) == pytest.approx(
        0.0150, abs=5e-5
    )


def test_critical_moisture() -> None:
    saturated = float(saturation_pressure(HOT))
    found = critical_moisture(ABS, [-1e5, 0.0, 0.95e6, saturated, 1.01 * saturated], HOT)
    assert found[0] == found[1] == 0.0
    assert found[2] == pytest.approx(1.7e-3, rel=0.01)
    assert found[3] == pytest.approx(CONTENT, rel=ROUNDING)
    assert np.isposinf(found[4])
    assert critical_moisture(ABS, 1e5, HOT).shape == ()


@given(low=st.floats(-1e6, 4e6), more=st.floats(1e3, 1e6), temperature=temperatures)
def test_critical_moisture_grows_with_pressure(low, more, temperature) -> None:
    at_low, at_high = critical_moisture(ABS, [low, low + more], temperature)
    assert at_low <= at_high


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_refusals(law) -> None:
    above = 1.01 * float(law.saturation_content(350.0))
    with pytest.raises(
        ConfigError, match=r"moisture = .*saturation at 350 K; dry|mass|from 0 to 1"
    ):
        law.vapor_pressure(above, 350.0)
    with pytest.raises(ConfigError, match=r"moisture = -0\.1"):
        law.vapor_pressure(-0.1, 350.0)
    with pytest.raises(ConfigError, match=r"vapor_pressure = .*the saturation pressure of water"):
        law.moisture(1e8, 350.0)
    with pytest.raises(ConfigError, match="temperature = 700 K"):
        law.vapor_pressure(1e-4, 700.0)


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: Henry(0.0, 300.0, 0.0), "henry.constant = 0 1/Pa: must be above 0"),
        (
            lambda: Henry(1e-9, 300.0, 0.0, (500.0, 400.0)),
            r"henry\.temperatures\[0\] = 500 K.*first",
        ),
        (lambda: ActivityLaw(0.1, 300.0, 0.0, (np.nan, 400.0)), r"temperatures\[0\] = nan K"),
        (
            lambda: critical_moisture(ActivityLaw(0.1, 300.0, 0.0, (470.0, 540.0)), -1e5, 400.0),
            "temperature = 400 K: must be from 470 to 540 K",
        ),
        (lambda: ActivityLaw(1.5, 300.0), r"moisture.content = 1.5: must be above 0 and at most 1"),
        (lambda: ActivityLaw(0.1, np.inf), "moisture.reference_temperature = inf K"),
    ],
)
def test_no_law(make, key: str) -> None:
    with pytest.raises(ConfigError, match=key):
        make()
