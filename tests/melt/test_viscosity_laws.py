"""Laws of viscosity, against their printed forms, differences, and limits; and the slit's flow."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.melt import (
    LAWS,
    CarreauYasuda,
    Cross,
    CrossWLF,
    Newtonian,
    PowerLaw,
    ViscosityLaw,
)
from fibermelt.melt.slit import PipeFlow, SlitFlow
from fibermelt.melt.temperature import WLF, ArrheniusShift

ROUNDING = 1e-12
RATES = np.geomspace(1e-2, 1e4, 25)

ABS_CARD = CrossWLF(
    index=0.2694,
    critical_stress=30820.0,
    reference_viscosity=4.89e10,
    reference_temperature=373.15,
    wlf_a1=23.76,
    wlf_a2=51.6,
    temperature=503.15,
)
EXAMPLES = {
    "newtonian": Newtonian(817.0),
    "power-law": PowerLaw(8213.0, 0.5, lowest_rate=1e-4),
    "carreau": CarreauYasuda(10390.0, 0.35, 0.5, infinite_viscosity=2.0, transition=1.3),
    "cross": Cross(2007.0, 0.2694, 30820.0),
    "cross-wlf": ABS_CARD,
}


def test_every_law_has_an_example() -> None:
    assert {name: type(law) for name, law in EXAMPLES.items()} == LAWS


def test_forms_are_those_printed() -> None:
    g = RATES
    printed = {
        "newtonian": np.full(g.shape, 817.0),
        "power-law": 8213.0 * g**-0.5,
        "carreau": 2.0 + 10388.0 * (1 + (0.5 * g) ** 1.3) ** (-0.65 / 1.3),
        "cross": 2007.0 / (1 + (2007.0 * g / 30820.0) ** 0.7306),
    }
    eta0 = 4.89e10 * math.exp(-23.76 * 130.0 / (51.6 + 130.0))
    printed["cross-wlf"] = eta0 / (1 + (eta0 * g / 30820.0) ** 0.7306)
    for name, expected in printed.items():  # the power law is level far below: 1e-9 of it is left
        np.testing.assert_allclose(EXAMPLES[name].viscosity_at(g), expected, rtol=1e-8)


def test_the_generic_abs_card_at_its_temperatures() -> None:
    # to the digits in which the card's viscosities at rest and at 100 1/s were derived
    for celsius, at_rest, at_hundred in ((210, 4628, 562), (230, 2007, 407), (250, 1027, 301)):
        law = replace(ABS_CARD, temperature=celsius + 273.15)
        assert float(law.viscosity_at(0.0)) == pytest.approx(at_rest, abs=1)
        assert float(law.viscosity_at(100.0)) == pytest.approx(at_hundred, abs=1)


@pytest.mark.parametrize("law", EXAMPLES.values(), ids=EXAMPLES)
def test_the_derivative_is_that_of_the_formula(law: ViscosityLaw) -> None:
    h = 1e-5
    low, high = law.viscosity_at(RATES * (1 - h)), law.viscosity_at(RATES * (1 + h))
    slope = (high - low) / (2 * h * RATES)
    scale = law.viscosity_at(RATES) / RATES
    # central differences of step 1e-5: rounding over the step
    np.testing.assert_allclose(law.slope_at(RATES) / scale, slope / scale, atol=1e-9)
    index = 1 + slope / scale
    np.testing.assert_allclose(law.index_at(RATES), index, atol=1e-9)


@pytest.mark.parametrize("law", EXAMPLES.values(), ids=EXAMPLES)
def test_scaling_is_what_it_says(law: ViscosityLaw) -> None:
    other = law.scaled(viscosity=0.3, time=7.0)
    np.testing.assert_allclose(
        other.viscosity_at(RATES), 0.3 * law.viscosity_at(7.0 * RATES), rtol=ROUNDING
    )


@pytest.mark.parametrize("law", EXAMPLES.values(), ids=EXAMPLES)
def test_a_melt_at_rest_has_a_finite_viscosity(law: ViscosityLaw) -> None:
    viscosity, slope = law.expression(np.zeros(1))
    assert np.all(np.isfinite([viscosity, slope]))
    at_rest = law.viscosity_at([0.0, 1e-3 * law.lowest_rate])
    assert at_rest[1] == pytest.approx(at_rest[0], rel=1e-6)


def test_a_power_law_is_level_below_its_lowest_rate() -> None:
    law = PowerLaw(1.0, 0.3, lowest_rate=0.1)
    level = 0.1**-0.7
    assert float(law.viscosity_at(0.0)) == pytest.approx(level, rel=ROUNDING)
    # a third of it and three times it are within 0.3 % of level and of the power law
    assert float(law.viscosity_at(0.1 / 3)) == pytest.approx(level, rel=3e-3)
    assert float(law.viscosity_at(0.3)) == pytest.approx(0.3**-0.7, rel=3e-3)


def test_shifts_with_temperature() -> None:
    # E/R 12138 K: a_T 105, 15.5 and 4.4 at 210, 250 and 280 degC about 593.15 K
    shift = ArrheniusShift(12138.0, 593.15)
    for celsius, factor in ((210, 105.5), (250, 15.5), (280, 4.38)):
        assert shift.factor(celsius + 273.15) == pytest.approx(factor, rel=5e-3)
    assert WLF(6.5, 158.2, 503.0).factor(503.0) == 1.0
    with pytest.raises(ConfigError, match=r"must lie above 321\.55 K"):
        WLF(23.76, 51.6, 373.15).factor(321.0)
    a = shift.factor(550.0)
    law = EXAMPLES["carreau"].scaled(a, a)
    np.testing.assert_allclose(
        law.viscosity_at(RATES), a * EXAMPLES["carreau"].viscosity_at(a * RATES), rtol=ROUNDING
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Newtonian(0.0), r"melt\.viscosity = 0 must be positive and finite"),
        (lambda: Newtonian(math.inf), r"melt\.viscosity = inf must be positive and finite"),
        (lambda: Newtonian("817 Pa s"), r"melt\.viscosity = '817 Pa s': must be one number"),
        (lambda: PowerLaw(1.0, 0.0), r"melt\.index = 0 must be positive"),
        (lambda: PowerLaw(1.0, 2.1), r"melt\.index = 2\.1 must lie above 0 and at most 2"),
        (lambda: PowerLaw(1.0, 0.5, 0.0), r"melt\.lowest_rate = 0 must be positive"),
        (lambda: PowerLaw(1e300, 0.01, 1e-300), r"melt\.lowest_rate = 1e-300 1/s gives"),
        (lambda: CarreauYasuda(817.0, 0.5, -1.0), r"melt\.time_constant = -1 must be positive"),
        (lambda: CarreauYasuda(8.0, 0.5, 1.0, 9.0), r"melt\.infinite_viscosity = 9 Pa s must be"),
        (lambda: CarreauYasuda(8.0, 0.5, 1.0, 0.0, 20.0), r"melt\.transition = 20 must lie in"),
        (lambda: Cross(817.0, 1.5, 1e4), r"melt\.index = 1\.5 must be at most 1"),
        (lambda: Cross(817.0, 0.5, 0.0), r"melt\.critical_stress = 0 must be positive"),
        (lambda: replace(ABS_CARD, temperature=320.0), r"melt\.temperature = 320 K must lie above"),
        (lambda: Newtonian(1.0).viscosity_at(-1.0), "rates of deformation are at least 0"),
    ],
)
def test_bad_constants_are_refused_by_name(make: object, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        make()  # type: ignore[operator]


@pytest.mark.parametrize("index", [1.0, 0.8, 0.5, 0.35, 0.25])
def test_a_power_law_in_a_slit_is_exact(index: float) -> None:
    K, H, U = 1000.0, 3e-3, 0.1
    slit = SlitFlow(PowerLaw(K, index, 1e-5), H, U)
    wall = (2 * U / H) * (2 * index + 1) / index
    # the level rate is 1e-7 of the wall's and less: nothing of it is left
    assert slit.wall_rate == pytest.approx(wall, rel=1e-8)
    assert slit.pressure_gradient == pytest.approx(2 * K / H * wall**index, rel=1e-8)
    x = np.linspace(-H / 2, H / 2, 41)
    exact = U * (2 * index + 1) / (index + 1) * (1 - np.abs(2 * x / H) ** (1 / index + 1))
    np.testing.assert_allclose(slit.velocity(x), exact, atol=1e-7 * U)


@pytest.mark.parametrize("index", [1.0, 0.5, 0.25])
def test_a_power_law_in_a_pipe_is_exact(index: float) -> None:
    K, D, U = 1000.0, 3e-3, 0.1
    pipe = PipeFlow(PowerLaw(K, index, 1e-5), D, U)
    wall = (2 * U / D) * (3 * index + 1) / index
    assert pipe.wall_rate == pytest.approx(wall, rel=1e-8)
    assert pipe.pressure_gradient == pytest.approx(4 * K / D * wall**index, rel=1e-8)
    r = np.linspace(0.0, D / 2, 41)
    exact = U * (3 * index + 1) / (index + 1) * (1 - (2 * r / D) ** (1 / index + 1))
    np.testing.assert_allclose(pipe.velocity(r), exact, atol=1e-7 * U)


@pytest.mark.parametrize("law", EXAMPLES.values(), ids=EXAMPLES)
def test_flux_in_a_slit_is_shared_by_position(law: ViscosityLaw) -> None:
    slit = SlitFlow(law, 2.0, 30.0)
    fraction = (np.arange(9) + 0.5) / 9
    x = slit.position_at_flux(fraction)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    for f, at in zip(fraction, x, strict=True):
        ends = 0.5 * (at + 1.0)  # from the left wall at -1
        flux = ends * np.sum(weights * slit.velocity(-1.0 + ends * (1 + nodes))) / 60.0
        # 200 Gauss points across a profile whose curvature jumps at most in its middle
        assert flux == pytest.approx(f, abs=2e-6)


@given(st.floats(0.2, 1.5), st.floats(1e-3, 1e3))
def test_a_thinning_melt_flows_more_like_a_plug(index: float, time_constant: float) -> None:
    slit = SlitFlow(CarreauYasuda(100.0, index, time_constant), 1.0, 1.0)
    peak = float(slit.velocity(np.zeros(1))[0])
    power = (2 * index + 1) / (index + 1)
    low, high = min(1.5, power), max(1.5, power)
    # between a Newtonian melt's profile and the power law's
    assert low - 1e-6 <= peak <= high + 1e-6
