from __future__ import annotations

import struct
import subprocess
import sys
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree as ET

import matplotlib as mpl
import pytest
import xarray as xr
from drawn_bead import made_up
from figure_texts import texts
from matplotlib.backends.backend_agg import FigureCanvasAgg

from fibermelt.engine.toml import resolved_toml
from fibermelt.paper.claims.conditions import conditions_of
from fibermelt.report.kit.plates import Plate
from fibermelt.report.kit.style import FULL, PNG_DOTS, STYLE, save
from fibermelt.report.page.figures import FIGURES, draw_figures
from fibermelt.study.loading import load_study

SMALLEST_TYPE = 6.5
"""Points; smaller type cannot be read on paper."""

LARGEST_SVG = 450_000
"""Bytes; a dozen of them, most of them smaller, must fit into a report of 5 MB."""

BEAD = [
    plate for plate in FIGURES if plate.needs.startswith("extreme") and "field" not in plate.needs
]
"""Figures of fibers in the bead; those of other parts have tests of their own."""

every_figure = pytest.mark.parametrize("plate", BEAD, ids=lambda plate: plate.name)


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return made_up()


@pytest.fixture(scope="module")
def folder(results: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("figures")
    written = draw_figures(results, folder)
    assert sorted(written) == sorted(folder.iterdir())
    return folder


@every_figure
def test_png_is_as_wide_as_a_page(plate: Plate, folder: Path) -> None:
    data = (folder / f"{plate.name}.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", data[16:24])
    assert abs(width - FULL / 25.4 * PNG_DOTS) <= 1
    assert 0.3 * width < height < 1.2 * width


@every_figure
def test_svg_is_small_and_says_what_it_is(plate: Plate, folder: Path) -> None:
    data = (folder / f"{plate.name}.svg").read_bytes()
    assert len(data) < LARGEST_SVG
    root = ET.fromstring(data)
    assert root.findtext("{http://www.w3.org/2000/svg}title") == plate.title
    assert b"<dc:date" not in data


@every_figure
def test_same_results_give_same_bytes_whatever_the_users_settings(
    plate: Plate, results: xr.Dataset, folder: Path, tmp_path: Path
) -> None:
    with mpl.rc_context({"font.size": 20, "svg.hashsalt": "another", "lines.linewidth": 9}):
        again = save(plate.draw(results), tmp_path / plate.name, plate.title, plate.words(results))
        assert mpl.rcParams["font.size"] == 20
    for path in again:
        assert path.read_bytes() == (folder / path.name).read_bytes()


@every_figure
def test_words_tell_numbers_and_are_no_leftovers(plate: Plate, results: xr.Dataset) -> None:
    words = plate.words(results)
    for text in (words.caption, words.alt):
        assert len(text) > 80
        assert text.endswith(".")
        assert "nan" not in text
        assert "  " not in text
        assert "{" not in text
    assert words.caption != words.alt


def _five_marked() -> xr.Dataset:
    config = "[streamlines]\nfeatures = [2, 6, 10, 14, 18]"
    bead = made_up(angles=13)
    return bead.assign_attrs(config=bead.attrs["config"].split("[streamlines]")[0] + config)


def _side_by_side() -> xr.Dataset:
    bead = made_up()
    return bead.assign_attrs(config=bead.attrs["config"].replace("4, 10, 18", "9, 10, 11"))


VARIANTS = {
    "the paper's": made_up,
    "one streamline, one angle": lambda: made_up(count=1, angles=1),
    "five marked streamlines": _five_marked,
    "marked side by side": _side_by_side,
}


@every_figure
@pytest.mark.parametrize("variant", VARIANTS)
def test_text_is_large_enough_and_neither_cut_off_nor_overlapping(
    plate: Plate, variant: str
) -> None:
    figure = plate.draw(VARIANTS[variant]())
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


@pytest.mark.parametrize("plate", [p for p in BEAD if p.paper], ids=lambda plate: plate.name)
def test_caption_names_the_papers_figure(plate: Plate, results: xr.Dataset) -> None:
    assert plate.words(results).caption.startswith(f"{plate.paper} of the paper: ") or (
        plate.words(results).caption.startswith(f"{plate.paper} of the paper, ")
    )


def test_the_papers_figures_are_all_there() -> None:
    told = " ".join(plate.paper for plate in FIGURES)
    for number in ("2a", "2b", "3", "4", *map(str, range(8, 14)), "16", "17", "18", "19", "20"):
        assert f"Fig. {number}" in told


@pytest.mark.parametrize("name", ["history", "profiles", "extremes", "positions"])
def test_the_papers_numbers_stand_beside_those_of_its_study_only(
    name: str, results: xr.Dataset
) -> None:
    (plate,) = (plate for plate in FIGURES if plate.name == name)

    def of_study(*overrides: str) -> xr.Dataset:
        config = load_study("paper", overrides).config
        return results.assign_attrs(
            title="fibermelt study paper",
            config=resolved_toml(config, "made up"),
            **conditions_of(config),
        )

    assert "The paper's text" in plate.words(of_study()).caption
    assert "The paper's text" in plate.words(of_study("voids.moisture=0.3 %")).caption
    assert "The paper's text" not in plate.words(results).caption
    # The name alone, as of the shipped study with something overridden, does not count.
    assert "The paper's text" not in plate.words(of_study("flow.gap=3.5 mm")).caption


@every_figure
def test_drawing_leaves_the_results_alone(plate: Plate, results: xr.Dataset) -> None:
    before = results.copy(deep=True)
    plate.draw(results)
    plate.words(results)
    xr.testing.assert_identical(results, before)


def test_words_follow_the_numbers() -> None:
    overview = next(plate for plate in FIGURES if plate.name == "overview")
    calm = made_up()
    deep = calm.assign(bound_lowest=2 * calm["bound_lowest"])
    deep["extreme"] = 2 * calm["extreme"]
    assert overview.words(calm).alt != overview.words(deep).alt


def test_command_line_starts_without_matplotlib() -> None:
    code = "import sys, fibermelt.cli; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
