"""The moving figure of paths in space, in a browser: it turns, and tells what is stored."""

from __future__ import annotations

from typing import Any

import pytest
import xarray as xr
from drawn_cases import case
from markupsafe import Markup
from sizes import DESKTOP, PHONE, every_width

from fibermelt.parts.bead.figures.interactive import moving_figure
from fibermelt.parts.flow.section import FLOW
from fibermelt.report.kit.templates import rendered, text_of
from fibermelt.report.page.sections import Filled


def results() -> xr.Dataset:
    return case("paths in space")


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A page of nothing but the figure."""
    values = {
        "title": "Paths",
        "answer": "",
        "glossary": "",
        "judges": False,
        "what_was_run": "",
        "moving": moving_figure(results()),
        "opening": None,
        "sections": [Filled(FLOW, FLOW.title, Markup())],
        "style": Markup(text_of("report/page/style.css")),
        "script": Markup(text_of("report/page/moving.js")),
    }
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(str(rendered("report/page/page.html.j2", values)))
    return path.as_uri()


def drawn(page: Any, number: int) -> str:
    return str(page.get_attribute(f"#scene [data-line='{number}']", "d"))


@every_width
def test_it_is_seen_from_three_sides(opened: Any, size: tuple[int, int]) -> None:
    page = opened(size)
    page.select_option("#pick-line", label="6")
    seen = set()
    for view in ("side", "above", "along"):
        page.click(f"#view-{view}")
        assert page.get_attribute(f"#view-{view}", "aria-pressed") == "true"
        seen.add(drawn(page, 6))
    assert len(seen) == 3
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]


def test_it_is_turned_by_dragging_and_by_keys(opened: Any) -> None:
    page = opened(DESKTOP)
    page.select_option("#pick-line", label="2")
    box = page.locator("#scene").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = drawn(page, 2)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y + 30, steps=4)
    page.mouse.up()
    assert page.input_value("#pick-line") == "1"  # turning it picks nothing
    turned = drawn(page, 2)
    assert turned != before
    assert page.locator("#moving [aria-pressed='true']").count() == 0
    page.focus("#scene")
    page.keyboard.press("Shift+ArrowRight")
    assert drawn(page, 2) != turned
    assert page.input_value("#pick-line") == "1"
    page.keyboard.press("ArrowRight")
    assert page.input_value("#pick-line") == "2"


def test_a_finger_picks_and_readouts_are_the_stored_numbers(opened: Any) -> None:
    page = opened(PHONE, has_touch=True, is_mobile=True)
    page.select_option("#pick-line", label="3")
    page.focus("#pick-time")
    page.keyboard.press("End")
    last = results().isel(streamline=2, point=-1)
    place = ", ".join(f"{1e3 * float(last[name]):.2f}" for name in "xyz")
    assert page.inner_text("#out-place").replace("−", "-") == f"{place} mm"
    # Of a path that was held at the middle of its length: a tap there picks it again.
    x, y = page.evaluate(
        """() => {
          const line = document.querySelector("#scene [data-line='3']");
          line.scrollIntoView({ block: "center" });
          const point = line.getPointAtLength(0.5 * line.getTotalLength());
          const box = document.querySelector("#scene").getBoundingClientRect();
          return [box.left + point.x, box.top + point.y];
        }"""
    )
    page.select_option("#pick-line", label="5")
    page.touchscreen.tap(x, y)
    assert page.inner_text("#pick-line option:checked") == "3"
