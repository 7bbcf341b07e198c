"""Figures of interaction and orientation: readable, the same bytes, words with their numbers."""

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
from suspended_fibers import interacting, oriented

from fibermelt.parts.interaction.figures import INTERACTION_FIGURES
from fibermelt.parts.orientation.figures.orientation import ORIENTATION_FIGURES
from fibermelt.parts.orientation.figures.tensors import angle_from, component_along
from fibermelt.report.kit.plates import Plate
from fibermelt.report.kit.style import FULL, PNG_DOTS, STYLE, save
from fibermelt.report.kit.turns import COLUMN
from fibermelt.report.page.figures import FIGURES as ALL

SMALLEST_TYPE = 7.0
"""Points, at the figure's own width."""

LARGEST_SVG = 1_000_000
"""Bytes, as of the other figures: they share a report."""

ROUNDING = 1e-12

FIGURES = (*INTERACTION_FIGURES, *ORIENTATION_FIGURES)

every_figure = pytest.mark.parametrize("plate", FIGURES, ids=lambda plate: plate.name)


@pytest.fixture(scope="module")
def cases() -> dict[str, xr.Dataset]:
    """Return the paper's suspension, and ones with gaps, odd names or one streamline."""
    usual = interacting()
    gaps = usual.copy(deep=True)
    gaps["interaction_angle"][0, 1, :5] = np.nan
    gaps["interaction_domain_size"][1, 9:] = np.nan
    gaps["interaction_domain_size_difference"][1] = np.nan
    other = interacting(closure="linear", coefficient=0.03).assign(stall_aspect_ratio=8.0)
    many = oriented()
    return {
        "usual": usual.merge(many),
        "gaps": gaps.merge(many.assign(orientation_violation=many["orientation_violation"] + 1e-3)),
        "other": other.merge(oriented(1, closure="hybrid", start="inlet")),
        "model": usual.merge(oriented(4, model="rsc", kappa=0.1)),
    }


def test_they_are_figures_of_a_report() -> None:
    assert set(FIGURES) <= set(ALL)
    assert len({plate.name for plate in ALL}) == len(ALL)


@every_figure
def test_same_results_give_the_same_files(
    plate: Plate, cases: dict[str, xr.Dataset], tmp_path: Path
) -> None:
    results = cases["usual"]
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
            mm = COLUMN if plate.name == "interaction-domain-size" else FULL
            assert abs(width - mm / 25.4 * PNG_DOTS) <= 1
        else:
            assert len(data) < LARGEST_SVG
    xr.testing.assert_identical(results, before)


@every_figure
@pytest.mark.parametrize("which", ["usual", "gaps", "other", "model"])
def test_text_is_large_enough_and_neither_cut_off_nor_overlapping(
    plate: Plate, which: str, cases: dict[str, xr.Dataset]
) -> None:
    figure = plate.draw(cases[which])
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
@pytest.mark.parametrize("which", ["usual", "gaps", "other", "model"])
def test_words_tell_numbers_and_are_no_leftovers(
    plate: Plate, which: str, cases: dict[str, xr.Dataset]
) -> None:
    words = plate.words(cases[which])
    for text in (words.caption, words.alt):
        assert len(text) > 80
        assert text.endswith(".")
        for leftover in ("nan", "  ", "{", "array("):
            assert leftover not in text
    assert words.caption != words.alt


def _words(name: str, results: xr.Dataset) -> str:
    words = next(plate for plate in FIGURES if plate.name == name).words(results)
    return f"{words.caption} {words.alt}"


def test_the_largest_differences_are_told(cases: dict[str, xr.Dataset]) -> None:
    results = cases["usual"]
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


def test_what_is_amiss_is_told(cases: dict[str, xr.Dataset]) -> None:
    assert "Not everywhere with a steady state: ORF." in _words("interaction", cases["gaps"])
    assert "leave [0, 1] by up to 1.0e-03" in _words("orientation", cases["gaps"])
    assert "polynomials are of 6" in _words("interaction", cases["other"])
    assert "closure hybrid" in _words("orientation-history", cases["other"])


def test_the_model_is_named_and_a_distribution_that_is_not_known_is_not_drawn(
    cases: dict[str, xr.Dataset],
) -> None:
    usual, other = (_words("orientation-history", cases[name]) for name in ("usual", "model"))
    assert "Folgar-Tucker (C_I = 0.0128), closure ORE, standard convention" in usual
    assert "RSC (C_I = 0.0128, kappa = 0.1), closure ORE, standard convention" in other
    assert "distribution" in usual
    assert "distribution" not in other
    (plate,) = (one for one in FIGURES if one.name == "orientation-history")
    panels = [len(plate.draw(cases[name]).axes) for name in ("usual", "model")]
    assert panels == [3, 2]


def test_an_angle_is_not_told_where_there_is_none(cases: dict[str, xr.Dataset]) -> None:
    none = cases["usual"].assign(stall_curve_difference=np.nan)
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
