"""Stall curves without cells: roots, ranges and refusals on curves made from a formula."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber.shape import jeffery_factor
from fibermelt.fiber.stall import StallCurve, paper_stall_angle, stall_curve

ROUNDING = 1e-12


def falling(M):
    """A polynomial of degree four in s, which thirteen points hold exactly."""
    return 1.2 - 0.3 * (1.0 - (2.0 / M) ** 2) ** 2


def made_curve(function=falling, smallest: float = 2.1, largest: float = np.inf) -> StallCurve:
    low, high = (math.sqrt(1.0 - (2.0 / M) ** 2) for M in (smallest, largest))
    s = 0.5 * (low + high - (high - low) * np.cos(np.pi * np.arange(13) / 12))
    with np.errstate(divide="ignore"):
        M = 2.0 / np.sqrt(1.0 - s**2)
    M[0], M[-1] = smallest, largest
    return StallCurve(6.0, M, function(M), 0.0)


@given(st.floats(2.1, 1e6))
def test_a_curve_holds_the_function_between_its_points(M: float) -> None:
    curve = made_curve()
    B = falling(M)
    assert curve.value(M) == pytest.approx(B, abs=ROUNDING)
    if B > 1.0 + 1e-9:
        assert math.cos(2.0 * float(curve.stall_angle(M))) == pytest.approx(1.0 / B, abs=ROUNDING)
    elif B < 1.0 - 1e-9:
        assert np.isnan(curve.stall_angle(M))


def test_largest_stalling_domain_is_where_b_is_one() -> None:
    exact = 2.0 / math.sqrt(1.0 - math.sqrt(2.0 / 3.0))  # 0.2 = 0.3 s^4
    curve = made_curve()
    assert curve.largest_stalling_domain == pytest.approx(exact, rel=ROUNDING)
    assert curve.domain_size_at(0.0) == pytest.approx(exact, rel=ROUNDING)


@given(st.floats(0.0, 0.28))
def test_domain_size_at_an_angle_is_the_inverse(angle: float) -> None:
    curve = made_curve()
    M = curve.domain_size_at(angle)
    assert curve.value(M) == pytest.approx(1.0 / math.cos(2.0 * angle), abs=ROUNDING)


def test_the_largest_of_several_domains_is_returned() -> None:
    # the angle rises and falls again, as near contact for a slender fiber
    curve = made_curve(lambda M: 1.1 - 0.2 * ((1.0 - (2.0 / M) ** 2) - 0.3) ** 2)
    target = 1.1 - 0.2 * 0.1**2
    M = curve.domain_size_at(0.5 * math.acos(1.0 / target))
    assert pytest.approx(2.0 / math.sqrt(1.0 - 0.4), rel=1e-9) == M  # s^2 = 0.4, not 0.2


def test_what_no_cell_gives_is_refused() -> None:
    curve = made_curve()
    with pytest.raises(ConfigError, match=r"no cell stalls a fiber of r_e = 6 there.*up to 0\.29"):
        curve.domain_size_at(0.5)
    for angle in (-0.1, 0.25 * math.pi, math.nan):
        with pytest.raises(ConfigError, match="below pi/4"):
            curve.domain_size_at(angle)
    with pytest.raises(ConfigError, match=r"runs from 2\.1 to inf"):
        curve.value([3.0, 2.05])
    tumbling = made_curve(lambda M: 0.5 * falling(M))
    with pytest.raises(ConfigError, match=r"tumbles in every cell from M = 2\.1"):
        _ = tumbling.largest_stalling_domain
    with pytest.raises(ConfigError, match="tumbles in every cell: take a longer fiber"):
        tumbling.domain_size_at(0.0)
    with pytest.raises(ConfigError, match="stalls in every cell"):
        _ = made_curve(largest=3.0).largest_stalling_domain


def test_what_is_no_curve_is_refused() -> None:
    with pytest.raises(ConfigError, match="must increase from above 2"):
        StallCurve(6.0, np.array([3.0, 2.5]), np.ones(2), 0.0)
    with pytest.raises(ConfigError, match="must increase from above 2"):
        StallCurve(6.0, np.array([2.0, 2.5]), np.ones(2), 0.0)
    with pytest.raises(ConfigError, match="shape factors"):
        StallCurve(6.0, np.array([2.5, 3.0]), np.ones(3), 0.0)


def test_bad_curves_are_refused_before_a_cell_is_solved() -> None:
    with pytest.raises(ConfigError, match="a circle does not feel strain"):
        stall_curve(1.0)
    with pytest.raises(ConfigError, match=r"fiber\.aspect_ratio = nan"):
        stall_curve(math.nan)
    with pytest.raises(ConfigError, match=r"smallest_domain = 2: must be at least 2\.001"):
        stall_curve(6.0, smallest_domain=2.0)
    with pytest.raises(ConfigError, match="tolerance = 1e-09"):
        stall_curve(6.0, tolerance=1e-9)


def test_the_papers_parabola() -> None:
    assert paper_stall_angle([3.0, 4.0, 5.0]) == pytest.approx([0.203, 0.127, 0.036], abs=5e-4)
    assert paper_stall_angle(5.3) > 0.0
    for M in (2.0, 5.4, math.nan):
        with pytest.raises(ConfigError, match=r"Eq\. 32 holds above 2 and up to 5\.3"):
            paper_stall_angle(M)


def test_the_unbounded_end_is_jefferys() -> None:
    curve = made_curve(lambda M: jeffery_factor(6.0) + (2.0 / M) ** 2)
    assert curve.value(np.inf) == pytest.approx(35.0 / 37.0, abs=ROUNDING)
