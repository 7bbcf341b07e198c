"""The page of a sweep in a browser: it fits, is read by eye and keyboard, and prints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from sizes import (
    DESKTOP,
    assert_figures_have_the_colors_of_the_page,
    assert_figures_open_large,
    assert_it_fits,
    assert_it_prints,
    every_scheme,
    every_width,
)
from swept_cases import COMPUTED, GRID, NUMBERS, made_up, with_errors

from fibermelt.report.sweep.page import render_sweep


def holds(point: dict[str, float]) -> float:
    """Return a value with which the claim "parabola" holds, for gaps up to 3 mm only."""
    return 0.0 if point["flow.gap"] < 3.1e-3 else 1e9


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("page")
    collected = made_up(folder, GRID, NUMBERS, failed={5}, verdicts={"parabola": holds})
    path: Path = folder / "report.html"
    path.write_bytes(render_sweep(with_errors(collected), COMPUTED))
    return path.as_uri()


@every_width
@every_scheme
def test_it_fits_and_its_images_are_shown(opened: Any, size: tuple[int, int], scheme: str) -> None:
    page = opened(size, color_scheme=scheme)
    assert page.locator("figure img").count() > 1
    assert_it_fits(page, size, scheme)


@every_width
def test_the_answer_begins_on_the_first_screen(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    box = page.locator("#answer > p").first.bounding_box()
    assert box["y"] + box["height"] < size[1]


@every_width
def test_every_section_is_in_the_contents(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    listed = page.locator("nav.contents > ul > li > a")
    targets = [listed.nth(k).get_attribute("href") for k in range(listed.count())]
    sections = page.evaluate("[...document.querySelectorAll('main section')].map(one => one.id)")
    assert targets == [f"#{name}" for name in sections]
    assert {"computed", "sources"} <= set(sections)
    page.locator("nav.contents a[href='#computed']").click()
    assert page.locator("#computed h2").is_visible()
    assert page.evaluate("location.hash") == "#computed"


@every_width
def test_words_of_the_sections_are_not_cut(opened: Any, size: tuple[int, int]) -> None:
    """What stands in a section is never wider than the page."""
    page = opened(size)
    for name in ("computed", "sources"):
        box = page.locator(f"#{name}").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= size[0]
    assert "2 started from cold and 4 from" in page.inner_text("#computed")
    assert "6.2.1, 6.2.2" in page.inner_text("#computed")


def test_tables_that_scroll_can_be_reached_by_keyboard(opened: Any) -> None:
    page = opened(DESKTOP)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to the content"
    regions = page.locator("main .scroll")
    assert regions.count() > 3
    for k in range(regions.count()):
        assert regions.nth(k).get_attribute("tabindex") == "0"
        assert regions.nth(k).get_attribute("aria-label")


@every_width
def test_figures_open_large(opened: Any, size: tuple[int, int]) -> None:
    assert_figures_open_large(opened(size), size)


@every_scheme
def test_figures_have_the_colors_of_the_page(opened: Any, scheme: str) -> None:
    assert_figures_have_the_colors_of_the_page(opened(DESKTOP, color_scheme=scheme))


def test_it_prints(opened: Any) -> None:
    assert_it_prints(opened(DESKTOP))
