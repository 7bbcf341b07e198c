"""Interaction coefficients, regimes and the paper's polynomials."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.orientation.interaction import (
    INTERACTION_LAWS,
    PAPER_ANGLE_END,
    PAPER_DOMAIN_END,
    bay,
    checked_interaction,
    interaction_law,
    paper_domain_size,
    paper_preferred_angle,
    phan_thien,
    regime,
)

contents = st.floats(1e-6, 0.99)
ratios = st.floats(1.0, 200.0)


def test_the_papers_content_gives_the_papers_coefficient() -> None:
    assert bay(0.084, 6.0) == pytest.approx(0.0128, abs=5e-5)  # printed to four decimals
    assert phan_thien(0.084, 6.0) == pytest.approx(0.0032, abs=5e-5)


@given(contents, ratios)
def test_limits_and_trends(content: float, ratio: float) -> None:
    more = 0.5 * (content + 1.0)
    assert bay(more, ratio) < bay(content, ratio) < 0.0184
    assert 0.0 < phan_thien(content, ratio) <= phan_thien(more, ratio) <= 0.03
    for name, law in INTERACTION_LAWS.items():
        assert law.name == name
        assert law.coefficient(content, ratio) == {"bay": bay, "phan-thien": phan_thien}[name](
            content, ratio
        )
        assert law.extrapolates(content, ratio) == (regime(content, ratio) not in law.regimes)


def test_a_dilute_melt_interacts_in_proportion_to_its_content() -> None:
    # the slope at zero is 0.03 x 0.224; the next term of the exponential is smaller by 0.112 v_f r
    assert phan_thien(1e-8, 2.0) == pytest.approx(0.03 * 0.224 * 2e-8, rel=1e-8)


def test_laws_are_found_by_name_and_cannot_be_changed() -> None:
    law = interaction_law("bay")
    assert "10.1002/pc.750130409" in law.source
    assert law.extrapolates(0.084, 6.0)  # the paper's own melt is semi-dilute
    assert not law.extrapolates(0.2, 20.0)
    with pytest.raises(ConfigError, match='did you mean "phan-thien"'):
        interaction_law("Phan Thien")
    with pytest.raises(dataclasses.FrozenInstanceError):
        law.name = "other"  # type: ignore[misc]  # what is tested
    with pytest.raises(TypeError):
        INTERACTION_LAWS["bay"] = law  # type: ignore[index]  # what is tested


def test_regimes_with_their_bounds() -> None:
    assert regime(0.084, 6.0) == "semi-dilute"
    assert regime(0.01, 6.0) == "dilute"
    assert regime(0.2, 6.0) == "concentrated"
    # a bound belongs to what lies above it; inverses of powers of two are exact
    assert regime(1.0 / 64.0, 8.0) == "semi-dilute"
    assert regime(np.nextafter(1.0 / 64.0, 0.0), 8.0) == "dilute"
    assert regime(1.0 / 8.0, 8.0) == "concentrated"
    assert regime(np.nextafter(1.0 / 8.0, 0.0), 8.0) == "semi-dilute"
    assert regime(0.99, 1.0) == "dilute"  # a sphere has one bound, at one


def test_the_papers_polynomials() -> None:
    assert paper_preferred_angle(0.0128) == pytest.approx(0.120, abs=5e-4)
    assert paper_domain_size(0.0128) == pytest.approx(4.08, abs=5e-3)
    C_I = np.array([1e-3, PAPER_DOMAIN_END])
    assert paper_domain_size(C_I) == pytest.approx([5.24, 2.01], abs=5e-3)
    rising = paper_preferred_angle(np.linspace(1e-3, PAPER_ANGLE_END, 200))
    assert np.all(np.diff(rising) > 0.0)
    assert np.all(np.diff(paper_domain_size(np.linspace(1e-3, PAPER_DOMAIN_END, 200))) < 0.0)


def test_eq_34_is_eq_32_and_33_put_together() -> None:
    C_I = np.linspace(0.005, 0.04, 8)
    M = paper_domain_size(C_I)
    stall = 0.33839 - 0.022 * M - 0.0077 * M**2
    # coefficients rounded to three digits: the root's argument is off by 0.01 of 46, times 0.0077
    assert stall == pytest.approx(paper_preferred_angle(C_I), abs=1e-4)


@pytest.mark.parametrize("content", [0.0, 1.0, -0.1, 8.4, np.nan])
@pytest.mark.parametrize("law", [bay, phan_thien, regime])
def test_content_outside_zero_and_one(law, content: float) -> None:
    with pytest.raises(ConfigError, match="between 0 and 1"):
        law(content, 6.0)


@pytest.mark.parametrize("ratio", [0.99, 0.0, -6.0, np.inf, np.nan])
def test_no_fiber(ratio: float) -> None:
    with pytest.raises(ConfigError, match="at least 1"):
        bay(0.1, ratio)


@pytest.mark.parametrize("interaction", [0.0, -0.01, np.nan, np.inf])
def test_no_interaction(interaction: float) -> None:
    with pytest.raises(ConfigError, match="C_I must be positive"):
        checked_interaction(interaction)


def test_interaction_is_returned() -> None:
    assert checked_interaction(0.0128) == 0.0128


@pytest.mark.parametrize("value", [0.0, -1.0, 0.2, np.nan])
@pytest.mark.parametrize("fit", [paper_preferred_angle, paper_domain_size])
def test_the_papers_polynomials_have_an_end(fit, value: float) -> None:
    with pytest.raises(ConfigError, match=r"the paper's Eq. 3[34] holds"):
        fit([0.01, value])
