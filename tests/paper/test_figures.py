"""Figures of the sensitivity studies: readable in a column, the same bytes, words with numbers."""

from __future__ import annotations

import struct
from itertools import combinations
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from figure_texts import texts
from matplotlib.backends.backend_agg import FigureCanvasAgg
from turned_fibers import PARAMETERS, compared, turned

from fibermelt.paper.orbits.figures.plates import DIMENSION_FIGURES, ORBIT_FIGURES
from fibermelt.report.kit.plates import Plate
from fibermelt.report.kit.style import PNG_DOTS, STYLE, save
from fibermelt.report.kit.turns import COLUMN, half_turn, read_turn, swept

SMALLEST_TYPE = 7.0
"""Points, at the width of a column."""

LARGEST_SVG = 600_000
"""Bytes."""

FIGURES = (*ORBIT_FIGURES, *DIMENSION_FIGURES)

every_figure = pytest.mark.parametrize("plate", FIGURES, ids=lambda plate: plate.name)


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return xr.merge([turned(), compared()], compat="identical", join="exact")


@pytest.fixture(scope="module")
def others() -> dict[str, xr.Dataset]:
    """Return results of fibers that stall, and of as many cases as fit, with one streamline."""
    stalls = turned(domain_size=4.0, aspect_ratios=(1.0, 6.0))
    many = turned(
        aspect_ratios=(1.0, 2.0, 3.0, 4.0),
        shear_rates=(0.01, 0.1, 0.25, 0.5, 1.0, 12.5, 100.0),
        viscosities=(0.1, 1e5),
    )
    return {
        "stalls": stalls.merge(compared(aspect_ratios=(1.0, 6.0)), compat="identical"),
        "many": many.merge(compared(1, aspect_ratios=(1.0, 2.0, 3.0, 4.0)), compat="identical"),
    }


@every_figure
def test_same_results_give_the_same_files(
    plate: Plate, results: xr.Dataset, tmp_path: Path
) -> None:
    before = results.copy(deep=True)
    stems = tmp_path / "first", tmp_path / "again"
    for stem, size in zip(stems, (8, 20), strict=True):
        with mpl.rc_context({"font.size": size, "lines.linewidth": size}):
            save(plate.draw(results), stem, plate.title, plate.words(results))
    for suffix in (".svg", ".png"):
        data = stems[0].with_suffix(suffix).read_bytes()
        assert data == stems[1].with_suffix(suffix).read_bytes()
        if suffix == ".png":
            width, _ = struct.unpack(">II", data[16:24])
            assert abs(width - COLUMN / 25.4 * PNG_DOTS) <= 1
        else:
            assert len(data) < LARGEST_SVG
    xr.testing.assert_identical(results, before)


@every_figure
@pytest.mark.parametrize("which", ["all", "stalls", "many"])
def test_text_is_large_enough_and_neither_cut_off_nor_overlapping(
    plate: Plate, which: str, results: xr.Dataset, others: dict[str, xr.Dataset]
) -> None:
    figure = plate.draw(results if which == "all" else others[which])
    canvas = FigureCanvasAgg(figure)
    with mpl.rc_context(STYLE):
        canvas.draw()
        boxes = [
            (text.get_text(), text.get_window_extent(canvas.get_renderer()), text.get_fontsize())
            for text in texts(figure)
        ]
    assert boxes
    for name, box, size in boxes:
        assert size >= SMALLEST_TYPE, name
        assert box.x0 >= 0, name
        assert box.y0 >= 0, name
        assert box.x1 <= figure.bbox.width, name
        assert box.y1 <= figure.bbox.height, name
    for (one, first, _), (other, second, _) in combinations(boxes, 2):
        assert not first.overlaps(second), f"{one!r} overlaps {other!r}"


@every_figure
@pytest.mark.parametrize("which", ["all", "stalls", "many"])
def test_words_tell_numbers_and_are_no_leftovers(
    plate: Plate, which: str, results: xr.Dataset, others: dict[str, xr.Dataset]
) -> None:
    words = plate.words(results if which == "all" else others[which])
    for text in (words.caption, words.alt):
        assert len(text) > 80
        assert text.endswith(".")
        for leftover in ("nan", "  ", "{"):
            assert leftover not in text
    assert words.caption != words.alt


def test_captions_say_what_is_ours_and_what_jefferys(results: xr.Dataset) -> None:
    for plate in ORBIT_FIGURES:
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
    for plate in ORBIT_FIGURES:
        if plate.name in ("orbit-motion", "orbit-around"):
            continue
        assert plate.words(deep).alt != plate.words(results).alt


def test_a_fiber_that_stalls_is_told_so(others: dict[str, xr.Dataset]) -> None:
    words = next(p for p in FIGURES if p.name == "orbit-motion").words(others["stalls"])
    assert "comes to rest at 7." in words.alt  # the stall angle of M = 4: 0.129 rad
    assert "it comes to rest in the cell" in words.caption
