"""Equivalent aspect ratios: the paper's pair, inverses, ranges."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    cox_cylinder_ratio,
    cox_ellipse_ratio,
    zhang_cylinder_ratio,
    zhang_ellipse_ratio,
)
from fibermelt.fiber.equivalent import COX_RANGE, ZHANG_RANGE


def test_the_paper_s_pair() -> None:
    assert zhang_ellipse_ratio(7.66) == pytest.approx(6.0, abs=5e-3)  # three digits are given
    assert zhang_cylinder_ratio(6.0) == pytest.approx(7.66, abs=5e-3)


def test_values() -> None:
    """Zhang's cubic and Cox's relation at 20, by hand."""
    assert zhang_ellipse_ratio(20.0) == pytest.approx(0.28 - 1.868 + 15.28 + 0.404, rel=1e-12)
    assert cox_ellipse_ratio(np.exp(4.0)) == pytest.approx(0.62 * np.exp(4.0), rel=1e-12)


@given(st.floats(*ZHANG_RANGE))
def test_zhang_inverted(ratio: float) -> None:
    assert zhang_cylinder_ratio(zhang_ellipse_ratio(ratio)) == pytest.approx(ratio, rel=1e-12)


@given(st.floats(*COX_RANGE))
def test_cox_inverted(ratio: float) -> None:
    assert cox_cylinder_ratio(cox_ellipse_ratio(ratio)) == pytest.approx(ratio, rel=1e-12)


def test_slender_cylinders_lose_relative_length_within_the_range() -> None:
    """``r_e/r_c`` falls: the reason for the range's upper end."""
    ratios = np.linspace(*ZHANG_RANGE, 200)
    relative = np.array([zhang_ellipse_ratio(float(r)) for r in ratios]) / ratios
    assert np.all(np.diff(relative) < 0)


@pytest.mark.parametrize("value", [np.nan, -1.0, 0.0, 0.99, 67.5, np.inf])
def test_zhang_out_of_range(value: float) -> None:
    with pytest.raises(ConfigError, match=f"cylinder aspect ratio = {value:g}.*1 to 67"):
        zhang_ellipse_ratio(value)


def test_other_ranges() -> None:
    with pytest.raises(ConfigError, match=r"cylinder aspect ratio = 4\.9: Cox"):
        cox_ellipse_ratio(4.9)
    with pytest.raises(ConfigError, match="aspect ratio = 1: Zhang"):
        zhang_cylinder_ratio(1.0)
    with pytest.raises(ConfigError, match="aspect ratio = 2: Cox"):
        cox_cylinder_ratio(2.0)
