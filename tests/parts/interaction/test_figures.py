"""Figures of interaction and orientation: what they tell of a suspension."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from drawn_cases import case
from suspended_fibers import oriented

from fibermelt.parts.orientation.figures import angle_from, component_along
from fibermelt.report.page.figures import FIGURES

ROUNDING = 1e-12


def _words(name: str, results: xr.Dataset) -> str:
    words = next(plate for plate in FIGURES if plate.name == name).words(results)
    return f"{words.caption} {words.alt}"


def test_the_largest_differences_are_told() -> None:
    results = case("suspension")
    text = _words("interaction", results)
    for difference in (
        results["stall_curve_difference"].item(),
        *results["interaction_angle_difference"].to_numpy(),
    ):
        assert f"{difference:.4f} rad" in text
    text = _words("interaction-domain-size", results)
    for difference in results["interaction_domain_size_difference"].to_numpy():
        assert f"{difference:.3f} in the" in text
    assert f"C_I = 0.0128, M = {float(results['content_domain_size']):.3f}" in text


def test_what_is_amiss_is_told() -> None:
    assert "Not everywhere with a steady state: ORF." in _words("interaction", case("gaps"))
    assert "leave [0, 1] by up to 1.0e-03" in _words("orientation", case("gaps"))
    assert "polynomials are of 6" in _words("interaction", case("another closure"))
    assert "closure hybrid" in _words("orientation-history", case("another closure"))


def test_a_distribution_that_is_not_known_is_not_drawn() -> None:
    names = ("suspension", "another model")
    usual, other = (_words("orientation-history", case(name)) for name in names)
    assert "Folgar-Tucker (C_I = 0.0128), closure ORE, standard convention" in usual
    assert "RSC (C_I = 0.0128, kappa = 0.1), closure ORE, standard convention" in other
    assert "distribution" in usual
    assert "distribution" not in other
    (plate,) = (one for one in FIGURES if one.name == "orientation-history")
    panels = [len(plate.draw(case(name)).axes) for name in names]
    assert panels == [3, 2]


def test_an_angle_is_not_told_where_there_is_none() -> None:
    none = case("suspension").copy(deep=True).assign(stall_curve_difference=np.nan)
    none["interaction_angle"][0, 0] = np.nan
    text = _words("interaction", none)
    assert "nowhere to compare with" in text
    assert "but for ORE, which has no steady state" in text


def test_the_component_along_a_streamline() -> None:
    """Where the melt flows down it is a_yy, along the bed a_xx."""
    results = oriented(2, points=40)
    along = component_along(results)
    a = results["orientation"].to_numpy()
    np.testing.assert_allclose(along[:, 0], a[:, 0, 1, 1], rtol=ROUNDING)
    np.testing.assert_allclose(along[:, -1], a[:, -1, 0, 0], rtol=ROUNDING)


@pytest.mark.parametrize("angle", [-1.2, -0.3, 0.0, 0.7, 1.5])
def test_the_preferred_direction_is_the_largest_eigenvalues(angle: float) -> None:
    p, q = (np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))
    a = np.diag([0.0, 0.0, 0.1])
    a[:2, :2] = 0.6 * np.outer(p, p) + 0.3 * np.outer(q, q)
    assert angle_from(a) == pytest.approx(angle, abs=ROUNDING)
