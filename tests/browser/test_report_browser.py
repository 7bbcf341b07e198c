"""The report in a browser: from disk, silent, without a request, and its moving figure moves."""

from __future__ import annotations

from typing import Any

import pytest
from sizes import (
    DESKTOP,
    PHONE,
    assert_figures_have_the_colors_of_the_page,
    assert_figures_open_large,
    assert_it_fits,
    assert_it_prints,
    every_scheme,
    every_width,
    shown,
)
from stored_bead import stored_results, stored_summary

from fibermelt.parts.voids.summary import summarize_voids
from fibermelt.report.page.page import render


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    results = stored_results()
    path = tmp_path_factory.mktemp("page") / "report.html"
    summary = {**stored_summary(results), **summarize_voids(results)}
    path.write_bytes(render(results, summary))
    return path.as_uri()


def told(page: Any, name: str) -> str:
    return str(page.inner_text(f"#out-{name}"))


@every_width
@every_scheme
def test_it_fits_and_its_images_are_shown(opened: Any, size: tuple[int, int], scheme: str) -> None:
    page = opened(size, color_scheme=scheme)
    assert_it_fits(page, size, scheme)


@every_width
def test_the_answer_is_on_the_first_screen(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    first = page.locator("dl.answer dd").first.bounding_box()
    assert first["y"] + first["height"] < size[1]
    last = page.locator("dl.answer dt").last.bounding_box()
    assert last["y"] + last["height"] < size[1]


@every_width
def test_claims_can_be_sifted_by_verdict(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    rows = page.locator("#claims > .scroll tbody tr:visible")
    assert rows.count() == 2
    page.check("#show-differs")
    assert rows.count() == 1
    assert "Minima are uniform" in rows.inner_text()
    assert page.locator("#claims > .scroll:visible").count() == 1
    assert page.locator(".tally tbody tr:visible").count() > 1
    page.emulate_media(media="print")
    assert rows.count() == 2


@every_width
def test_rows_of_a_table_that_is_too_wide_are_lists(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    page.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    head = page.locator("table.many thead").first
    assert (head.bounding_box()["width"] <= 1) == (size == PHONE)
    labels = page.evaluate(
        """[...document.querySelectorAll("table.many td")]
          .filter(cell => getComputedStyle(cell, "::before").content !== "none").length"""
    )
    assert (labels > 0) == (size == PHONE)


@every_scheme
def test_figures_have_the_colors_of_the_page(opened: Any, scheme: str) -> None:
    page = opened(DESKTOP, color_scheme=scheme)
    assert_figures_have_the_colors_of_the_page(page)
    page.emulate_media(media="print")
    assert shown(page, "figure .card img").getpixel((2, 2)) == (255, 255, 255)


@every_width
def test_figures_open_large(opened: Any, size: tuple[int, int]) -> None:
    assert_figures_open_large(opened(size), size)


@every_width
def test_a_streamline_can_be_picked(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    before = told(page, "deepest")
    page.select_option("#pick-line", label="2")
    assert page.locator("#scene [data-line='2']").count() == 1
    assert told(page, "deepest") != before
    page.focus("#scene")
    page.keyboard.press("ArrowRight")
    assert page.input_value("#pick-line") == "2"
    assert "streamline 3" in page.get_attribute("#scene", "aria-valuetext")
    page.keyboard.press("End")
    page.keyboard.press("ArrowRight")
    assert page.input_value("#pick-line") == "5"
    page.keyboard.press("Home")
    assert page.get_attribute("#scene", "aria-valuenow") == "1"


def over_the_line(page: Any, number: int) -> tuple[float, float]:
    """Return a point of the window on a streamline, where it leaves the bead."""
    page.select_option("#pick-line", label=str(number))
    page.locator("#scene").scroll_into_view_if_needed()
    x, y = page.evaluate(
        """number => {
          const line = document.querySelector(`#scene [data-line='${number}']`);
          const point = line.getPointAtLength(0.9 * line.getTotalLength());
          const box = document.querySelector('#scene').getBoundingClientRect();
          return [box.left + point.x, box.top + point.y];
        }""",
        number,
    )
    return x, y


def test_pointing_shows_and_a_click_keeps(opened: Any) -> None:
    page = opened(DESKTOP)
    at = over_the_line(page, 5)
    page.select_option("#pick-line", label="2")
    page.mouse.move(*at)
    assert page.locator("#scene [data-line='5']").count() == 1
    assert page.input_value("#pick-line") == "1"
    page.mouse.move(2, 2)
    assert page.locator("#scene [data-line='2']").count() == 1
    page.mouse.click(*at)
    page.mouse.move(2, 2)
    assert page.locator("#scene [data-line='5']").count() == 1
    assert page.input_value("#pick-line") == "4"


def test_a_finger_picks_too(opened: Any) -> None:
    page = opened(PHONE, has_touch=True, is_mobile=True)
    at = over_the_line(page, 5)
    page.select_option("#pick-line", label="2")
    page.touchscreen.tap(*at)
    assert page.input_value("#pick-line") == "4"


@every_width
def test_time_and_fiber_follow_their_sliders(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    ellipse = page.locator("#scene ellipse")
    page.focus("#pick-time")
    page.keyboard.press("Home")
    first = told(page, "time"), ellipse.get_attribute("transform")
    assert first[0] == "0.000 s"
    for _ in range(3):
        page.keyboard.press("PageUp")
    assert told(page, "time") != first[0]
    assert ellipse.get_attribute("transform") != first[1]
    assert told(page, "time") in page.get_attribute("#pick-time", "aria-valuetext")
    before = told(page, "angle"), page.inner_text("#start-shown")
    page.focus("#pick-start")
    page.keyboard.press("ArrowRight")
    assert page.inner_text("#start-shown") == "90°"
    assert (told(page, "angle"), page.inner_text("#start-shown")) != before
    page.click("#view-exit")
    assert page.get_attribute("#view-exit", "aria-pressed") == "true"


def test_readouts_are_the_stored_numbers(opened: Any) -> None:
    results = stored_results()
    page = opened(DESKTOP)
    page.select_option("#pick-line", label="3")
    page.focus("#pick-time")
    page.keyboard.press("End")
    middle = results.sizes["initial_angle"] // 2
    last = results.isel(streamline=2, initial_angle=middle, point=-1)
    low = 1e-6 * float(last["pressure"] + last["lowest"])
    shown = float(told(page, "low").removesuffix(" MPa").replace("−", "-"))
    # The page holds two numbers in whole kilopascals, each rounded by at most half of one.
    assert shown == pytest.approx(low, abs=1.01e-3)
    assert told(page, "place").startswith(f"{1e3 * float(last['x']):.2f}, ")


def test_a_closer_view_brings_the_fiber_into_sight(opened: Any) -> None:
    page = opened(DESKTOP)
    page.focus("#pick-time")
    page.keyboard.press("Home")
    page.click("#view-exit")
    assert told(page, "deepest").endswith(f" at {told(page, 'time')}")
    page.click("#view-whole")
    assert told(page, "deepest").endswith(f" at {told(page, 'time')}")


def test_playing_goes_on_until_it_is_stopped(opened: Any) -> None:
    page = opened(DESKTOP)
    page.focus("#pick-time")
    page.keyboard.press("Home")
    page.click("#play")
    # No function of ours: the page's content security policy has none evaluated from a text.
    page.locator("#out-time", has_not_text="0.000 s").wait_for()
    assert page.get_attribute("#play", "aria-label") == "Pause"
    page.click("#play")
    stopped = told(page, "time")
    assert page.get_attribute("#play", "aria-label") == "Play"
    page.wait_for_timeout(100)
    assert told(page, "time") == stopped


def test_the_keyboard_reaches_the_content_first(opened: Any) -> None:
    page = opened(DESKTOP)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to the content"


def test_without_script_the_overview_stays(opened: Any) -> None:
    page = opened(PHONE, java_script_enabled=False)
    assert page.locator("#figure-overview img").is_visible()
    assert not page.locator("#moving").is_visible()


def test_it_prints(opened: Any) -> None:
    page = opened(DESKTOP)
    assert_it_prints(page)
    assert not page.locator("#moving").is_visible()
    # Words have the room: bounds and numbers beside them are short.
    says, tested, bound = (
        page.locator(f"#claims > .scroll thead th:nth-child({k})").first.bounding_box()["width"]
        for k in (1, 2, 3)
    )
    assert min(says, tested) > 2 * bound
