"""Figures as parts of one HTML file: small enough, sharp enough, and without any address."""

from __future__ import annotations

import base64
import io
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING
from urllib.parse import quote

from markupsafe import Markup
from PIL import Image

from fibermelt.report.kit.dark import darkened_image, in_both_schemes
from fibermelt.report.kit.plates import SUFFIXES, Plate
from fibermelt.report.page.figures import FIGURES, draw_figures

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Embedded", "embed_figures", "embed_plates"]

FIGURE_BUDGET = 3_800_000
"""Bytes that all figures together may take: the rest of the 5 MB is for the other sections."""

QUALITY = 90
"""Of WebP: no difference can be seen, unlike with 256 colours, that make a green line blue."""

EFFORT = 2
"""Of 6: half the time of the usual 4, for a tenth more bytes."""

_ESCAPED = re.compile(r"[^A-Za-z0-9_~ /=;,\-.'()+*!@?\[\]{}]+")
"""What does not stand in a data address, or in an attribute, as it is."""

_NOTES = re.compile(r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>|<!--.*?-->", re.S)
_PATH = re.compile(r' d="([^"]*)"')
_LONG = re.compile(r"-?\d+\.\d{3,}")


@dataclass(frozen=True)
class Embedded:
    """A figure in the page.

    Parameters
    ----------
    name, title, section, paper, caption, alt : str
        As in `Plate` and `Words`.
    source, dark : Markup
        The figure itself, as a data address that can stand in an attribute as it is; another one
        for a dark page, empty where the first has both.
    width, height : int
        Its size in dots, for the room that it takes before it is shown.
    """

    name: str
    title: str
    section: str
    paper: str
    caption: str
    alt: str
    source: Markup
    dark: Markup
    width: int
    height: int


def embed_figures(results: xr.Dataset, drawn: Mapping[str, bytes] | None = None) -> list[Embedded]:
    """Return every figure that the results are enough for, ready to stand in a page.

    They have the colours of a light page and of a dark one. They stay in lines (SVG) as long as
    all of them are within `FIGURE_BUDGET`; beyond, the largest go over to dots (WebP) until they
    are.

    Parameters
    ----------
    results : xarray.Dataset
        Results of a study.
    drawn : mapping, optional
        Figures of these very results that were drawn before, by file name; the others are drawn.
        They are what drawing gives, so the answer is the same with and without them.
    """
    plates = [plate for plate in FIGURES if plate.is_of(results)]
    names = [f"{plate.name}{suffix}" for plate in plates for suffix in SUFFIXES]
    files = dict(drawn or {})
    if not files.keys() >= set(names):
        files = _draw(results)
    return embed_plates(plates, results, files)


def embed_plates(
    plates: Sequence[Plate], results: xr.Dataset, files: Mapping[str, bytes]
) -> list[Embedded]:
    """Return figures that were drawn, ready to stand in a page, as `embed_figures` does.

    Parameters
    ----------
    plates : sequence of Plate
        The figures.
    results : xarray.Dataset
        What they were drawn from.
    files : mapping
        Each as SVG and as PNG, by file name.
    """
    sources = _within_budget(plates, files)
    return [_embedded(plate, results, files, sources[plate.name]) for plate in plates]


def _draw(results: xr.Dataset) -> dict[str, bytes]:
    with TemporaryDirectory() as folder:
        return {path.name: path.read_bytes() for path in draw_figures(results, Path(folder))}


def _within_budget(
    plates: Sequence[Plate], files: Mapping[str, bytes]
) -> dict[str, tuple[str, str]]:
    """Return the data addresses of figures by name, each as `Embedded` has them."""
    sources = {plate.name: (_in_lines(files[f"{plate.name}.svg"].decode()), "") for plate in plates}
    size = {name: len(lines) for name, (lines, _) in sources.items()}
    for name in sorted(size, key=lambda name: (-size[name], name)):
        if sum(size.values()) <= FIGURE_BUDGET:
            break
        dots = _in_dots(files[f"{name}.png"], size[name])
        if dots is not None:
            size[name] = sum(map(len, dots))
            sources[name] = dots
    return sources


def _in_lines(svg: str) -> str:
    """Return a drawing as a data address: without notes, paths to a hundredth of a point."""
    svg = in_both_schemes(svg, _address)
    bare = _PATH.sub(lambda path: f' d="{_rounded(path[1])}"', _NOTES.sub("", svg))
    bare = re.sub(r"\n\s*", "\n", bare).strip().replace('"', "'")
    # Most of a drawing is numbers: only what has to be is looked at letter by letter.
    return "data:image/svg+xml," + _ESCAPED.sub(lambda found: _quoted(found[0]), bare)


@cache
def _quoted(text: str) -> str:
    return quote(text, safe="")


def _rounded(path: str) -> str:
    short = _LONG.sub(lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), path)
    return short.replace("\n", "")


def _in_dots(png: bytes, most: int) -> tuple[str, str] | None:
    """Return a drawing, light and dark, in dots; None if they take as many bytes as there are."""
    light = Image.open(io.BytesIO(png)).convert("RGB")
    day = _address(light)
    if len(day) >= most:
        return None
    night = _address(darkened_image(light).convert("RGB"))
    return (day, night) if len(day) + len(night) < most else None


def _address(image: Image.Image) -> str:
    """Return an image as a data address, in dots that take a third of what PNG takes."""
    stream = io.BytesIO()
    image.save(stream, "webp", quality=QUALITY, method=EFFORT)
    return "data:image/webp;base64," + base64.b64encode(stream.getvalue()).decode()


def _embedded(
    plate: Plate, results: xr.Dataset, files: Mapping[str, bytes], source: tuple[str, str]
) -> Embedded:
    words = plate.words(results)
    width, height = struct.unpack(">II", files[f"{plate.name}.png"][16:24])
    return Embedded(
        name=plate.name,
        title=plate.title,
        section=plate.section,
        paper=plate.paper,
        caption=words.caption,
        alt=words.alt,
        source=Markup(source[0]),
        dark=Markup(source[1]),
        width=width,
        height=height,
    )
