"""Figures in the dark: every colour's lightness turned over, hue and order of lightness kept.

A figure is turned as a whole, fields and what is drawn over them alike, so that whatever stood out
from its ground still does, and a field still has the colours of its bar.
"""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable

import numpy as np
from PIL import Image

from fibermelt.report.kit.style import INK, Array

__all__ = ["DARK_GROUND", "DARK_INK", "darkened", "darkened_image", "in_both_schemes"]

DARK_GROUND, DARK_INK = "#1b1e23", "#e4e3df"
"""What white paper and ink become: ``--card`` and ``--ink`` of the page in the dark."""

SCHEME = "(prefers-color-scheme: dark)"

_TO_CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
"""Of Oklab (B. Ottosson, *A perceptual color space for image processing*, 2020): from linear sRGB
to cones, and from their cube roots to lightness and two opponent axes."""

_HALVINGS = 12
"""Of the share of chroma that a screen can show: to 1/4096, below one step of 8 bits."""

_COLOR = re.compile(r"(?<=: )#[0-9a-f]{6}\b")
_STYLED = re.compile(r'style="[^"]*"')
_IMAGE = re.compile(r'<image\b([^>]*?)data:image/png;base64,([^"]*)("[^>]*/>)')
_ID = re.compile(r' id="[^"]*"')


def _lab(rgb: Array) -> Array:
    """Return Oklab of sRGB (IEC 61966-2-1), both (..., 3), sRGB from 0 to 1."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    lab: Array = np.cbrt(linear @ _TO_CONES.T) @ _TO_LAB.T
    return lab


def _linear(lab: Array) -> Array:
    """Return linear sRGB of Oklab; outside 0 to 1 where no screen shows it."""
    cones = np.linalg.solve(_TO_LAB, lab.T).T ** 3
    linear: Array = np.linalg.solve(_TO_CONES, cones.T).T
    return linear


def _rgb(color: str) -> Array:
    return np.array([[int(color[k : k + 2], 16) for k in (1, 3, 5)]]) / 255.0


def _hexed(rgb: Array) -> list[str]:
    return ["#{:02x}{:02x}{:02x}".format(*map(int, row)) for row in np.rint(255 * rgb)]


def darkened(rgb: Array) -> Array:
    """Return colours as they are on a dark ground.

    Lightness falls in proportion as it rose, from `DARK_GROUND` for white through `DARK_INK` for
    ink; hue stays, and as much of the chroma as a screen shows at that lightness.

    Parameters
    ----------
    rgb : (n, 3) array
        Colours in sRGB, 0 to 1.

    Returns
    -------
    (n, 3) array
        Colours in sRGB, 0 to 1.
    """
    white, ink, ground, letters = (
        _lab(_rgb(color))[0] for color in ("#ffffff", INK, DARK_GROUND, DARK_INK)
    )
    lab = _lab(rgb)
    turned = ground + (white[0] - lab[:, :1]) / (white[0] - ink[0]) * (letters - ground)
    # Black is darker than ink: it becomes no lighter than white.
    turned[:, 0] = np.minimum(turned[:, 0], white[0])
    chroma = np.column_stack([np.zeros(len(lab)), lab[:, 1:]])
    shown, too_much = np.zeros((len(lab), 1)), np.ones((len(lab), 1))
    for k in range(_HALVINGS + 1):
        share = 0.5 * (shown + too_much) if k else too_much
        linear = _linear(turned + share * chroma)
        # Rounding's: white and the greys lie on the edge.
        fits = np.all((linear > -1e-4) & (linear < 1 + 1e-4), axis=1, keepdims=True)
        shown, too_much = np.where(fits, share, shown), np.where(fits, too_much, share)
    linear = np.clip(_linear(turned + shown * chroma), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def darkened_image(image: Image.Image) -> Image.Image:
    """Return an image in its dark colours, as transparent as before."""
    # One number for a dot, little end first: red, green, blue, and how opaque it is.
    dots = np.asarray(image.convert("RGBA")).view("<u4")[..., 0]
    number = dots & 0xFFFFFF
    # A table of all that there can be is looked up faster than the dots are sorted.
    is_there = np.zeros(1 << 24, dtype=bool)
    is_there[number] = True
    there = np.flatnonzero(is_there)
    colors = np.stack([there >> shift & 255 for shift in (0, 8, 16)], axis=-1)
    dark = np.rint(255 * darkened(colors / 255.0)).astype("<u4")
    table = np.empty(1 << 24, dtype="<u4")
    table[there] = dark[:, 0] | dark[:, 1] << 8 | dark[:, 2] << 16
    painted = table[number] | (dots & 0xFF000000)
    return Image.fromarray(painted.view(np.uint8).reshape(*painted.shape, 4))


def in_both_schemes(svg: str, address: Callable[[Image.Image], str]) -> str:
    """Return a drawing that takes the colours of the scheme that it is looked at in.

    Parameters
    ----------
    svg : str
        As matplotlib writes it: colours in style attributes, paintings as PNG.
    address : callable
        From a painting to its data address.
    """

    def twice(found: re.Match[str]) -> str:
        image = Image.open(io.BytesIO(base64.b64decode(found[2])))
        pair = {"day": image, "night": darkened_image(image)}
        return "".join(
            f'<image class="{name}"{_ID.sub("", found[1])}{address(one)}{_ID.sub("", found[3])}'
            for name, one in pair.items()
        )

    colors = sorted({color for style in _STYLED.findall(svg) for color in _COLOR.findall(style)})
    # What has no fill of its own is black.
    black, *dark = _hexed(darkened(np.vstack([_rgb(color) for color in ["#000000", *colors]])))
    day = "".join(f"--{color[1:]}:{color};" for color in colors)
    night = "".join(f"--{color[1:]}:{one};" for color, one in zip(colors, dark, strict=True))
    rules = (
        f"<style>svg{{{day}}}.night{{display:none}}@media {SCHEME}{{svg{{{night}fill:{black}}}"
        ".day{display:none}.night{display:inline}}</style>\n"
    )
    named = _STYLED.sub(lambda style: _COLOR.sub(lambda c: f"var(--{c[0][1:]})", style[0]), svg)
    return _IMAGE.sub(twice, named).replace("<defs>", f"{rules}<defs>", 1)
