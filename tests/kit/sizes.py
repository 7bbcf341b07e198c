"""The sizes of window that a page is tested in."""

import io
from typing import Any

import pytest
from PIL import Image

PHONE, TABLET, DESKTOP = (390, 740), (768, 1024), (1280, 900)

LANDSCAPE = (1001, 657)
"""What the margins leave of an A4 sheet on its side, in CSS pixels of 1/96 inch."""

every_width = pytest.mark.parametrize(
    "size", [PHONE, TABLET, DESKTOP], ids=["phone", "tablet", "desktop"]
)
every_scheme = pytest.mark.parametrize("scheme", ["light", "dark"])

OFF_THE_EDGE = """() => [...document.querySelectorAll("body *")]
  .filter(one => !one.closest(".skip, .heard, thead"))
  .filter(one => innerWidth > 480 || !one.closest(".scroll:has(> .wide)"))
  .filter(one => {
    const box = one.getBoundingClientRect();
    const scrolls = getComputedStyle(one).overflowX !== "visible" && one.clientWidth > 0
      && one.scrollWidth > one.clientWidth + 1;
    return box.width > 0 && (box.left < -1 || box.right > innerWidth + 1 || scrolls);
  })
  .map(one => `${one.tagName} ${one.closest("[id]")?.id}: ${one.textContent.slice(0, 60)}`)"""
"""What stands beyond a window's sides or hides a part of itself there, by more than rounding; on a
phone but for the tables that are there to be moved under a finger."""


def rgb(css: str) -> list[int]:
    """Return the three parts of a color as a browser computes it."""
    return [int(part) for part in css.partition("(")[2].partition(")")[0].split(",")[:3]]


def shown(page: Any, selector: str) -> Image.Image:
    """Return what a browser shows of an element."""
    return Image.open(io.BytesIO(page.locator(selector).first.screenshot())).convert("RGB")


def assert_it_fits(page: Any, size: tuple[int, int], scheme: str) -> None:
    """Assert that nothing is off the edge, images are shown, and colors suit the scheme."""
    page.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    off = page.evaluate(OFF_THE_EDGE)
    assert not off, off
    assert page.evaluate(
        "Promise.all([...document.images].map(image => image.decode())).then(() => true)"
    )
    ink, paper = (
        page.evaluate(f"getComputedStyle(document.body).{name}") for name in ("color", "background")
    )
    assert (sum(rgb(ink)) < sum(rgb(paper))) == (scheme == "light")


def assert_figures_have_the_colors_of_the_page(page: Any) -> None:
    """Assert that a figure's ground is its card's, and that letters on it are the page's ink."""
    card = page.locator("figure .card").first
    ground = rgb(card.evaluate("one => getComputedStyle(one).backgroundColor"))
    ink = rgb(page.evaluate("getComputedStyle(document.body).color"))
    dots = shown(page, "figure .card img")
    assert list(dots.getpixel((2, 2))) == ground
    # Thin letters are mixed with their ground: no more than a third of it in the strongest dots.
    far = max(abs(sum(dot) - sum(ground)) for _, dot in dots.getcolors(dots.width * dots.height))
    assert far > 2 / 3 * abs(sum(ink) - sum(ground))


def assert_figures_open_large(page: Any, size: tuple[int, int]) -> None:
    """Assert that a figure fits its card, and at a click takes the window until it is closed.

    Letters of 2.5 mm on a page of 190 mm: at 1000 px they are 13 px high.
    """
    card = page.locator("figure .card").first
    image = card.locator("img")
    before = image.bounding_box()["width"]
    assert before <= card.bounding_box()["width"]
    card.locator(".open").click()
    box = card.bounding_box()
    assert (box["x"], box["y"], box["width"], box["height"]) == (0, 0, *size)
    assert image.bounding_box()["width"] >= max(before, 1000)
    assert not page.locator("h1").is_visible()
    assert card.evaluate("one => one === document.activeElement")
    # It can be moved to each of its ends.
    assert card.evaluate(
        "one => { one.scrollLeft = 1e4; return one.scrollLeft + one.clientWidth }"
    ) == card.evaluate("one => one.scrollWidth")
    card.locator(".close").click()
    assert image.bounding_box()["width"] == before
    assert page.locator("h1").is_visible()


BREAKS = """() => {
  const all = selector => [...document.querySelectorAll(selector)];
  const styled = one => getComputedStyle(one);
  return [
    ...all("h2, h3, caption, thead").filter(one => styled(one).breakAfter !== "avoid"),
    ...all("figure, tr").filter(one => styled(one).breakInside !== "avoid"),
    ...all("tbody tr:first-child, tbody tr:nth-child(2), tbody tr:last-child")
      .filter(one => styled(one).breakBefore !== "avoid"),
  ].map(one => `${one.tagName} of ${one.closest("[id]")?.id}`);
}"""
"""Heads that may stand alone at the foot of a printed page, figures and rows that may be cut, rows
that may stand alone on one side of a break."""


def assert_it_prints(page: Any) -> None:
    """Assert that a figure and its caption fit a sheet on its side, and that no head stands alone.

    A figure higher than the sheet leaves its heading on an empty page, and is cut on the next.
    """
    assert page.pdf()[:5] == b"%PDF-"
    page.set_viewport_size({"width": LANDSCAPE[0], "height": LANDSCAPE[1]})
    page.emulate_media(media="print")
    heights = page.evaluate(
        "[...document.querySelectorAll('figure')].map(one => one.getBoundingClientRect().height)"
    )
    assert max(heights) < LANDSCAPE[1]
    assert page.evaluate(BREAKS) == []
    # What is for a pointer, or for a program to read, is not on paper.
    assert not page.locator("nav").is_visible()
    assert not any(one.is_visible() for one in page.locator("pre").all())
    assert page.locator("#sources li").first.is_visible()
