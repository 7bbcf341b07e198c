"""The sizes of window that a page is tested in."""

from typing import Any

import pytest

PHONE, DESKTOP = (375, 740), (1280, 900)

every_width = pytest.mark.parametrize("size", [PHONE, DESKTOP], ids=["phone", "desktop"])


def rgb(css: str) -> list[int]:
    """Return the three parts of a color as a browser computes it."""
    return [int(part) for part in css.partition("(")[2].partition(")")[0].split(",")[:3]]


def assert_it_fits(page: Any, size: tuple[int, int], scheme: str) -> None:
    """Assert that nothing runs over the width, images are shown, and colors suit the scheme."""
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    assert page.evaluate(
        "Promise.all([...document.images].map(image => image.decode())).then(() => true)"
    )
    ink, paper = (
        page.evaluate(f"getComputedStyle(document.body).{name}") for name in ("color", "background")
    )
    assert (sum(rgb(ink)) < sum(rgb(paper))) == (scheme == "light")


def assert_figures_can_be_read(page: Any, size: tuple[int, int]) -> None:
    """Assert that no figure is small, and that one that is too wide scrolls within its card.

    Letters of 2.5 mm on a page of 190 mm: at 700 px they are 9 px high.
    """
    for image in page.locator("figure .card img").all():
        own = float(image.get_attribute("width")) / 20 * 16
        assert image.bounding_box()["width"] >= min(own, 700)
    for card in page.locator("figure .card").all():
        box = card.bounding_box()
        assert box["x"] + box["width"] <= size[0]
        assert card.get_attribute("tabindex") == "0"
        assert card.get_attribute("aria-label")
        is_wide = card.evaluate("one => one.scrollWidth > one.clientWidth")
        assert is_wide == (size == PHONE)
        if is_wide:
            assert card.evaluate("one => { one.scrollLeft = 99; return one.scrollLeft }") > 0
