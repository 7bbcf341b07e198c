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
