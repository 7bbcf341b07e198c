"""Figures in the dark: paper and ink are the page's, hue and order of lightness stay."""

from __future__ import annotations

import re

import matplotlib as mpl
import numpy as np
import pytest

from fibermelt.report.kit.dark import (
    DARK_GROUND,
    DARK_INK,
    _hexed,
    _lab,
    _rgb,
    darkened,
    in_both_schemes,
)
from fibermelt.report.kit.style import BLUE, GREEN, INK, LOW, VERMILION
from fibermelt.report.kit.templates import text_of


def test_paper_and_ink_are_those_of_the_page_in_the_dark() -> None:
    assert _hexed(darkened(np.vstack([_rgb("#ffffff"), _rgb(INK)]))) == [DARK_GROUND, DARK_INK]
    dark = text_of("report/page/style.css").split("@media")[1]
    assert f"--card: {DARK_GROUND};" in dark
    assert f"--ink: {DARK_INK};" in dark


def test_lightness_is_turned_over_in_order() -> None:
    colors = mpl.colormaps["cividis"](np.linspace(0, 1, 64))[:, :3]
    before, after = (_lab(one)[:, 0] for one in (colors, darkened(colors)))
    assert np.all(np.diff(after)[np.diff(before) > 0] < 0)


@pytest.mark.parametrize("color", [BLUE, VERMILION, GREEN, LOW])
def test_hue_stays(color: str) -> None:
    """Within 4 degrees: the ground and the letters have a tint of their own."""
    before, after = (_lab(one)[0] for one in (_rgb(color), darkened(_rgb(color))))
    hues = [np.degrees(np.arctan2(lab[2], lab[1])) for lab in (before, after)]
    assert abs((hues[1] - hues[0] + 180) % 360 - 180) < 4


def test_a_drawing_has_both_schemes_and_no_color_of_its_own() -> None:
    svg = f'<svg><defs/><defs></defs><path style="fill: {INK}; stroke: #ffffff"/></svg>'
    both = in_both_schemes(svg, str)
    assert 'style="fill: var(--1a1a1a); stroke: var(--ffffff)"' in both
    dark = both.partition("(prefers-color-scheme: dark)")[2]
    assert f"--1a1a1a:{DARK_INK};" in dark
    assert f"--ffffff:{DARK_GROUND};" in dark
    assert not re.search(r'style="[^"]*#', both)
