"""What every figure of a page must hold, of usual results and of odd ones."""

from __future__ import annotations

import re
import struct
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import xarray as xr
from drawn_cases import CASES, case
from figure_texts import shown

from fibermelt.report.kit.plates import Plate, draw_plates
from fibermelt.report.kit.style import COLUMN, FULL, PNG_DOTS
from fibermelt.report.page.figures import FIGURES
from fibermelt.report.page.sections import SECTIONS

SMALLEST_TYPE = 6.5
"""Points; smaller type cannot be read on paper."""

LARGEST_SVG = 450_000
"""Bytes; a dozen of them, most of them smaller, must fit into a report of 5 MB."""

LEFTOVERS = ("nan", "  ", "{", "array(")


def drawn_of(plate: Plate) -> list[str]:
    """Return the names of the results that a figure can be drawn of, the usual ones first."""
    return [name for name in CASES if plate.is_of(case(name))]


every_figure = pytest.mark.parametrize("plate", FIGURES, ids=lambda plate: plate.name)
every_case = pytest.mark.parametrize(
    ("plate", "name"),
    [(plate, name) for plate in FIGURES for name in drawn_of(plate)],
    ids=lambda one: one if isinstance(one, str) else one.name,
)


def test_figures_have_names_and_places_of_their_own() -> None:
    assert len({plate.name for plate in FIGURES}) == len(FIGURES)
    places = [
        (plate.section, plate.place, plate.needs) for plate in FIGURES
    ]  # of those that a page can hold together
    assert len({*places}) == len(places)
    assert {plate.section for plate in FIGURES} <= {section.name for section in SECTIONS}


@every_figure
def test_every_figure_is_drawn_here(plate: Plate) -> None:
    assert drawn_of(plate)


@every_case
def test_text_is_large_enough_and_neither_cut_off_nor_overlapping(plate: Plate, name: str) -> None:
    figure = plate.draw(case(name))
    boxes = shown(figure)
    assert boxes
    for text, box, size in boxes:
        assert size >= SMALLEST_TYPE, text
        assert box.x0 >= 0, text
        assert box.y0 >= 0, text
        assert box.x1 <= figure.bbox.width, text
        assert box.y1 <= figure.bbox.height, text
    for (one, first, _), (other, second, _) in combinations(boxes, 2):
        assert not first.overlaps(second), f"{one!r} overlaps {other!r}"


@every_case
def test_words_are_whole(plate: Plate, name: str) -> None:
    words = plate.words(case(name))
    for text in (words.caption, words.alt):
        assert len(text) > 80
        assert text.endswith(".")
        assert not any(leftover in text for leftover in LEFTOVERS), text
    assert words.caption != words.alt


@every_figure
def test_its_files_are_small_titled_and_dateless(plate: Plate, tmp_path: Path) -> None:
    results = case(drawn_of(plate)[0])
    before = results.copy(deep=True)
    draw_plates([plate], results, tmp_path)
    xr.testing.assert_identical(results, before)
    svg, png = ((tmp_path / f"{plate.name}.{kind}").read_bytes() for kind in ("svg", "png"))
    assert len(svg) < LARGEST_SVG
    assert ET.fromstring(svg).findtext("{http://www.w3.org/2000/svg}title") == plate.title
    assert b"<dc:date" not in svg
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", png[16:24])
    wide = min((FULL, COLUMN), key=lambda mm: abs(width - mm / 25.4 * PNG_DOTS))
    assert abs(width - wide / 25.4 * PNG_DOTS) <= 1
    assert 0.3 * width < height < 2.0 * width


@pytest.mark.parametrize(
    "plate",
    [plate for plate in FIGURES if plate.paper and "extreme" in plate.needs],
    ids=lambda plate: plate.name,
)
def test_caption_names_the_papers_figure(plate: Plate) -> None:
    caption = plate.words(case("bead")).caption
    assert caption.startswith((f"{plate.paper} of the paper: ", f"{plate.paper} of the paper, "))


def test_the_papers_figures_are_all_there() -> None:
    told = " ".join(plate.paper for plate in FIGURES)
    for number in ("2a", "2b", "3", "4", "5a", *map(str, range(8, 21))):
        assert re.search(rf"Fig\. {number}\b", told), number
