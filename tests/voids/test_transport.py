"""Diffusion of the volatile, surface tension of the melt, and wetting."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.verify.voids import TOLUENE_DIFFUSIVITIES, TOLUENE_PS
from fibermelt.voids import (
    Arrhenius,
    FreeVolume,
    LinearTension,
    Parachor,
    Wetting,
    girifalco_good,
    tension_at_density,
    vapor_angle,
    wetting_factor,
)

ROUNDING = 1e-12  # a few tens of operations


def test_toluene_in_polystyrene() -> None:
    # Vrentas and Duda's parameters and values, at 308 K and w_1 = 0.2, given to four digits
    alone, mutual = TOLUENE_DIFFUSIVITIES
    assert float(TOLUENE_PS.self_diffusivity(0.2, 308.0)) == pytest.approx(alone, rel=4e-4)
    assert float(TOLUENE_PS.diffusivity(0.2, 308.0)) == pytest.approx(mutual, rel=4e-4)


def test_toluene_in_polyvinyl_acetate() -> None:
    law = FreeVolume(
        4.82e-8, 0.0, (0.917e-3, 0.728e-3), 0.82, (1.45e-6, 4.33e-7), (-86.32, -258.2), 0.5
    )
    assert float(law.self_diffusivity(0.2, 298.15)) == pytest.approx(7.40e-12, rel=3e-3)
    assert float(law.diffusivity(0.2, 298.15)) == pytest.approx(3.79e-12, rel=3e-3)


def test_without_interaction_and_solvent_both_diffusivities_are_one() -> None:
    dilute = float(TOLUENE_PS.diffusivity(0.0, 400.0))
    assert dilute == float(TOLUENE_PS.self_diffusivity(0.0, 400.0))


def test_volume_fraction_follows_the_specific_volumes() -> None:
    law = FreeVolume(1e-8, 0.0, (1e-3, 1e-3), 1.0, (1e-6, 1e-6), (0.0, 0.0), 0.0, (2e-3, 1e-3))
    assert float(law.volume_fraction(0.5)) == pytest.approx(2.0 / 3.0, rel=ROUNDING)


@given(st.floats(0.0, 0.6), st.floats(340.0, 480.0))
def test_free_volume_grows_with_heat_and_with_solvent(w, T) -> None:
    here = float(TOLUENE_PS.self_diffusivity(w, T))
    assert float(TOLUENE_PS.self_diffusivity(w, T + 1.0)) > here
    assert float(TOLUENE_PS.self_diffusivity(w + 0.01, T)) > here


def test_a_glass_and_a_demixing_solution_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"temperature = 300 K: .* glass"):
        TOLUENE_PS.self_diffusivity(0.0, 300.0)
    poor = FreeVolume(4.82e-8, 0.0, (1e-3, 1e-3), 0.6, (1.4e-6, 6e-7), (-86.0, -327.0), 2.0)
    with pytest.raises(ConfigError, match=r"= 0.4: must be at most 0.25, .* demixes"):
        poor.diffusivity(0.4, 400.0)
    with pytest.raises(ConfigError, match=r"free_volume\.jump_volumes = 0"):
        FreeVolume(1e-8, 0.0, (0.0, 1e-3), 1.0, (1e-6, 1e-6), (0.0, 0.0), 0.0)


def test_water_in_mabs() -> None:
    # Krongauz et al. 2016: ln D0 = -23.9 + 0.49 E; values of D in cm2/s to two digits
    law = Arrhenius.of_energy(1e-4 * math.exp(-23.9 + 0.49 * 43.5), 43.5e3)
    found = law.diffusivity([303.15, 348.15, 503.15]) * 1e4
    assert law.activation_temperature == pytest.approx(5232.0, abs=0.5)
    assert found == pytest.approx([2.4e-9, 2.2e-8, 2.3e-6], rel=0.03)


@given(st.floats(0.0, 1e4), st.floats(280.0, 700.0))
def test_arrhenius_never_falls_with_heat(activation, T) -> None:
    law = Arrhenius(1e-6, activation)
    cold, hot = law.diffusivity([T, T + 1.0])
    assert cold <= hot <= 1e-6


def test_arrhenius_outside_its_range() -> None:
    law = Arrhenius(1e-6, 5000.0, (400.0, 500.0))
    with pytest.raises(ConfigError, match=r"temperature = 300 K: must be from 400 to 500 K"):
        law.diffusivity(300.0)
    with pytest.raises(ConfigError, match=r"diffusion.prefactor = 0 m2/s"):
        Arrhenius(0.0, 5000.0)


def test_abs_melt_tension() -> None:
    law = LinearTension(38.5e-3, 293.15, -0.07e-3, (473.15, 533.15))
    assert float(law.at(503.15)) == pytest.approx(23.8e-3, rel=ROUNDING)
    with pytest.raises(ConfigError, match="temperature = 300 K"):
        law.at(300.0)
    with pytest.raises(ConfigError, match="surface tension at the hot end"):
        LinearTension(38.5e-3, 293.15, -0.2e-3, (473.15, 533.15))
    with pytest.raises(ConfigError, match=r"surface.slope = 1e-05 N/\(m K\): must be at most 0"):
        LinearTension(38.5e-3, 293.15, 1e-5, (473.15, 533.15))


def test_polystyrene_by_its_parachor() -> None:
    styrene = {"C": 8, "H": 8, "double bond": 3, "six-membered ring": 1}
    parachor = Parachor.of_structure(styrene)
    assert parachor.value == pytest.approx(250.9 * 1e-6 * 1e-3**0.25, rel=ROUNDING)
    # 40.7 mN/m at 20 degC (Wu 1982); additivity is good to a few percent
    assert float(parachor.tension(104.15e-3 / 1050.0)) == pytest.approx(40.7e-3, rel=0.03)
    with pytest.raises(ConfigError, match="no contribution is called 'Si'"):
        Parachor.of_structure({"Si": 1})


@given(st.floats(500.0, 2000.0), st.floats(500.0, 2000.0))
def test_eq_46_is_eq_45_at_two_densities(one, two) -> None:
    parachor, mass = Parachor(5e-5), 0.1
    direct = float(parachor.tension(mass / two))
    scaled = tension_at_density(float(parachor.tension(mass / one)), two, one)
    assert float(scaled) == pytest.approx(direct, rel=ROUNDING)


def test_girifalco_good() -> None:
    assert girifalco_good(0.02, 0.02).cosine == pytest.approx(1.0, rel=ROUNDING)  # itself: spreads
    assert girifalco_good(0.0, 0.02).contact_angle == math.pi  # nothing to hold on to
    assert girifalco_good(0.005, 0.02).contact_angle == pytest.approx(math.pi / 2, rel=ROUNDING)
    assert girifalco_good(0.01, 0.02, 8.0, 1.0) == girifalco_good(0.01, 0.02, 1.0, 8.0)
    # V_s/V_l = 8: Phi = 4 * 2/9
    assert girifalco_good(0.02, 0.02, 8.0, 1.0).cosine == pytest.approx(7 / 9, rel=ROUNDING)
    with pytest.raises(ConfigError, match="liquid tension = 0 N/m"):
        girifalco_good(0.04, 0.0)


def test_a_melt_that_spreads_gets_no_help_from_the_solid() -> None:
    wetting = girifalco_good(0.045, 0.024)
    assert wetting.spreads
    assert wetting.contact_angle == 0.0
    assert float(wetting_factor(wetting.vapor_angle)) == 1.0
    with pytest.raises(ConfigError, match="cosine of the contact angle = -2"):
        Wetting(-2.0)


def test_wetting_factor_at_its_ends_and_in_the_middle() -> None:
    assert wetting_factor([0.0, np.pi / 2, np.pi]) == pytest.approx([0.0, 0.5, 1.0], rel=ROUNDING)
    # Eq. 37 as printed
    phi = np.linspace(0.1, np.pi, 50)
    printed = 0.25 * (2.0 + np.cos(phi)) * (1.0 - np.cos(phi)) ** 2
    assert np.allclose(wetting_factor(phi), printed, rtol=ROUNDING, atol=0.0)
    assert np.all(np.diff(wetting_factor(phi)) > 0.0)


@given(st.floats(1e-12, 1.0))
def test_wetting_factor_there_and_back(factor) -> None:
    # near 180 degrees the factor is flat to fourth order: this way round it keeps its digits
    assert float(wetting_factor(vapor_angle(factor))) == pytest.approx(factor, rel=1e-11)


@pytest.mark.parametrize("angle", [-0.1, 3.2, 90.0, np.nan])
def test_no_angle(angle: float) -> None:
    with pytest.raises(ConfigError, match="vapor angle"):
        wetting_factor(angle)
    with pytest.raises(ConfigError, match="wetting factor"):
        vapor_angle(angle + 2.0 if angle < 0 else angle)


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: Arrhenius(1e-5, 5e3, (550.0, 450.0)), r"diffusion\.temperatures\[0\] = 550 K"),
        (lambda: LinearTension(0.03, 500.0, -6e-5, (550.0, 450.0)), r"at most 450 K; the lowest"),
        (lambda: LinearTension(0.03, 500.0, -6e-5, (450.0, np.inf)), r"temperatures\[1\] = inf K"),
        (lambda: Parachor(1e-5).tension(0.0), "molar volume = 0 m3/mol: must be above 0 m3/mol$"),
        (lambda: tension_at_density(0.03, [1e3, 0.0], 1e3), "density = 0 kg/m3: must be above 0"),
    ],
)
def test_ranges_and_bounds_in_words(make, key) -> None:
    with pytest.raises(ConfigError, match=key):
        make()
