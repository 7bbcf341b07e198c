"""Figures of the sensitivity studies: what they tell of turns."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from drawn_cases import case
from turned_fibers import PARAMETERS

from fibermelt.paper.orbits.figures.orbits import figure_motion
from fibermelt.paper.orbits.figures.turns import half_turn, read_turn, swept
from fibermelt.report.page.figures import FIGURES

TURNS = [plate for plate in FIGURES if plate.needs == "orbit_period"]


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return case("turns")


def test_captions_say_what_is_ours_and_what_jefferys(results: xr.Dataset) -> None:
    for plate in TURNS:
        caption = plate.words(results).caption
        assert "cell of M = 28" in caption
        assert "Jeffery" in caption or plate.name == "orbit-around"


def test_half_a_turn_covers_every_angle_once(results: xr.Dataset) -> None:
    turn = read_turn(results, 0, "ellipse")
    angle, lowest, highest = half_turn(turn)
    assert np.all(np.diff(angle) > 0.0)
    assert angle[0] <= -90.0
    assert angle[-1] >= 90.0
    ratio = PARAMETERS["fiber.aspect_ratio"]
    # at 45 degrees, as exact as interpolation between the instants
    assert np.interp(45.0, angle, lowest) == pytest.approx(-0.817 * (1.0 + ratio), rel=2e-3)
    assert np.interp(-45.0, angle, highest) == pytest.approx(0.817 * (1.0 + ratio), rel=2e-3)


def test_lines_of_a_sweep_are_in_order_and_told_apart(results: xr.Dataset) -> None:
    lines = swept(results, "shear_rate")
    assert [name for _, name, _ in lines] == [
        rf"$\dot\gamma$ = {rate} s$^{{-1}}$" for rate in ("0.5", "1", "2")
    ]
    light = [np.dot(mpl.colors.to_rgb(color), (0.2126, 0.7152, 0.0722)) for *_, color in lines]
    assert np.all(np.diff(light) > 0.1)  # by lightness alone


def test_deeper_pressures_are_told(results: xr.Dataset) -> None:
    deep = results.assign(orbit_lowest=2 * results["orbit_lowest"])
    for plate in TURNS:
        if plate.name in ("orbit-motion", "orbit-around"):
            continue
        assert plate.words(deep).alt != plate.words(results).alt


def test_a_fiber_that_stalls_is_told_so() -> None:
    words = figure_motion.words(case("fibers that stall"))
    assert "comes to rest at 7." in words.alt  # the stall angle of M = 4: 0.129 rad
    assert "it comes to rest in the cell" in words.caption
