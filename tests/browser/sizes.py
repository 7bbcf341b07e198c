"""The sizes of window that a page is tested in."""

import pytest

PHONE, DESKTOP = (375, 740), (1280, 900)

every_width = pytest.mark.parametrize("size", [PHONE, DESKTOP], ids=["phone", "desktop"])


def rgb(css: str) -> list[int]:
    """Return the three parts of a color as a browser computes it."""
    return [int(part) for part in css.partition("(")[2].partition(")")[0].split(",")[:3]]
