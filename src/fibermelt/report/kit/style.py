"""How figures look: sizes, type, colours, and the same bytes from the same store.

Sizes are millimetres on paper, so that the type is as large as it says: a figure stands across a
page. Colours are told apart by people with any colour vision: Okabe and Ito's set for lines
(jfly.uni-koeln.de/color), maps of even lightness for fields.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import BoundaryNorm, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator, ScalarFormatter
from numpy.typing import NDArray

from fibermelt.report.kit.tables import short

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.cm import ScalarMappable
    from matplotlib.colorbar import Colorbar

__all__ = [
    "BAND",
    "BLUE",
    "COLUMN",
    "DIVERGING",
    "FULL",
    "GREEN",
    "GREY",
    "HIGH",
    "INK",
    "JUDGED",
    "LOW",
    "ORANGE",
    "OTHERS",
    "PALE",
    "PINK",
    "SEQUENTIAL",
    "UNJUDGED",
    "VERMILION",
    "Array",
    "Plain",
    "Roomy",
    "Words",
    "add_axes",
    "color_bar",
    "drawn_in_style",
    "key_above",
    "key_mark",
    "letter",
    "new_figure",
    "plain_numbers",
    "round_up",
    "save",
    "shades",
    "share_within",
]

Array = NDArray[np.float64]

FULL, COLUMN = 190.0, 90.0
"""Width of a figure [mm]: across a page, or one column of it."""

INK, GREY, OTHERS, BAND, PALE = "#1a1a1a", "#8c8c8c", "#bdbdbd", "#dedede", "#f0f3f6"
BLUE, VERMILION, GREEN = "#0072b2", "#d55e00", "#009e73"
ORANGE, PINK = "#e69f00", "#cc79a7"

LOW, HIGH = "#8c510a", "#5b4a9e"
"""Lowest and highest surface pressure: no colour of a streamline."""

SEQUENTIAL = "cividis"
DIVERGING = "PuOr"
"""What has a sign, without a verdict: orange below zero, purple above, as `LOW` and `HIGH` are."""

JUDGED = "RdBu"
"""Pressure against the vapor's of the melt's moisture, and nothing else: red is below it."""

UNJUDGED: dict[str, Any] = {
    "facecolor": "#e2e2e2",
    "edgecolor": GREY,
    "hatch": "/////",
    "linewidth": 0,
}
"""Melt that no verdict is given on: white would pass for harmless."""

SHADES, DARKEST, LIGHTEST = "plasma", 0.12, 0.85
"""Colours of a sweep: no darker than shows a dashed line on top, no lighter than shows on white."""

PNG_DOTS, SVG_DOTS = 180, 115
"""Dots per inch of PNG, and of what is painted inside SVG: smooth fields, whose bytes count."""

EFFORT = 3
"""Of 9, to pack PNG: in 60 % of the time of the usual 6, for 7 % more bytes."""

DECIMALS = re.compile(r"(\.\d\d)\d+")
"""Digits of an SVG's coordinates beyond hundredths of a point, which is a few micrometres."""

INDENT = re.compile(r"\n\s+")

COORDINATES = re.compile(r' (?:d|x|y)="[^"]*"')

SALT = "fibermelt"
"""Fixes the names of SVG's clip paths, which are random otherwise."""

SMALLEST, LARGEST = 1e-3, 1e6
"""Of the largest number of an axis: beyond, each is written with a power of its own."""

LABEL = 7.0
"""Size of the numbers [points]."""

DIGIT, BETWEEN = 0.64, 0.8
"""Width of a digit of DejaVu Sans, and what stays free between two numbers, in ems."""

MOST = 9
"""Steps along an axis at most, as matplotlib has."""

STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.5,
    "xtick.labelsize": LABEL,
    "ytick.labelsize": LABEL,
    "legend.fontsize": 7.0,
    "mathtext.fontset": "dejavusans",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#4d4d4d",
    "xtick.color": "#4d4d4d",
    "ytick.color": "#4d4d4d",
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "axes.linewidth": 0.6,
    "axes.labelpad": 2.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "xtick.major.pad": 2.0,
    "ytick.major.pad": 2.0,
    "lines.linewidth": 1.0,
    "lines.solid_capstyle": "round",
    "patch.linewidth": 0.6,
    "hatch.linewidth": 0.4,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.labelspacing": 0.3,
    "legend.borderpad": 0.0,
    "legend.borderaxespad": 0.2,
    "image.interpolation": "nearest",
    # Points within 0.2 of a pixel, in SVG of a point, of a line's course are left out.
    "path.simplify_threshold": 0.2,
    "savefig.facecolor": "white",
    "svg.fonttype": "path",
    "svg.hashsalt": SALT,
}
"""Letters go into SVG as outlines: the same on every machine, whatever fonts it has."""


@dataclass(frozen=True)
class Words:
    """What stands under a figure, and what stands in its place for who cannot see it.

    Parameters
    ----------
    caption : str
        What is drawn, how to read it, and what was left out.
    alt : str
        What a look at it tells.
    """

    caption: str
    alt: str


@contextmanager
def _style() -> Iterator[None]:
    """Set the style on top of matplotlib's defaults, whatever the user's own settings are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(STYLE)
        yield


def drawn_in_style(drawing: Callable[[xr.Dataset], Figure], results: xr.Dataset) -> Figure:
    """Return a figure drawn in this style."""
    with _style():
        return drawing(results)


def shades(count: int) -> list[str]:
    """Return the colours of so many lines of a sweep, in order of lightness."""
    found = mpl.colormaps[SHADES](np.linspace(DARKEST, LIGHTEST, count))
    return [mpl.colors.to_hex(shade) for shade in found]


class Plain(ScalarFormatter):
    """Writes whole numbers, where matplotlib's own puts what they share over the next chart."""

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(b=False)

    def format_ticks(self, values: list[float]) -> list[str]:
        """Return the texts of the ticks."""
        largest = max(map(abs, values), default=0.0)
        if largest and not SMALLEST <= largest < LARGEST:
            return [short(value, 3) for value in values]
        return super().format_ticks(values)


class Roomy(MaxNLocator):
    """Sets ticks along x in round steps, so few that their numbers do not run together.

    Parameters
    ----------
    most : int
        Steps at most.
    beyond : float
        How far a number may reach beyond the ends of the axis [points].
    """

    def __init__(self, most: int = MOST, beyond: float = np.inf) -> None:
        super().__init__(nbins=most, steps=[1, 2, 2.5, 5, 10])
        self.most, self.beyond = most, beyond

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the places of the ticks."""
        for steps in range(self.most, 0, -1):
            self.set_params(nbins=steps)
            found = np.asarray(super().tick_values(vmin, vmax))
            if not isinstance(self.axis, Axis) or found.size < 2:
                return found
            box, low, high = self.axis.axes.get_window_extent(), *sorted((vmin, vmax))
            points = 72.0 * box.width / self.axis.axes.figure.dpi / (high - low)
            shown = [float(place) for place in found if low <= place <= high]
            texts = self.axis.get_major_formatter().format_ticks(shown)
            wide = DIGIT * LABEL * max(map(len, texts), default=0)
            if points * float(found[1] - found[0]) >= wide + BETWEEN * LABEL:
                break
        inset = max(0.0, 0.5 * wide - self.beyond) / points
        return found[(found >= low + inset) & (found <= high - inset)] if inset else found


def plain_numbers(axes: Axes) -> None:
    """Have both axes of a chart tell whole numbers, without an offset beside them."""
    axes.xaxis.set_major_formatter(Plain())
    axes.yaxis.set_major_formatter(Plain())


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in [mm]."""
    return Figure(figsize=(width / 25.4, height / 25.4))


def add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Return axes at a place of the figure in [mm], with whole numbers that have room."""
    size = 25.4 * figure.get_size_inches()
    place = (left / size[0], bottom / size[1], width / size[0], height / size[1])
    axes = figure.add_axes(place)
    axes.xaxis.set_major_locator(Roomy())
    plain_numbers(axes)
    return axes


def letter(axes: Axes, text: str, *, inside: bool = False) -> None:
    """Write a panel's letter and what it shows over its upper left corner, or in it."""
    axes.annotate(
        text,
        (0.0, 1.0),
        xycoords="axes fraction",
        xytext=(3, -3) if inside else (0, 3),
        textcoords="offset points",
        ha="left",
        va="top" if inside else "bottom",
    )


def key_above(
    axes: Axes, handles: Sequence[Line2D | Patch], rise: float, columns: int, between: float
) -> None:
    """Draw a key over axes: its foot at a height in parts of theirs, columns apart in ems."""
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, rise),
        ncols=columns,
        columnspacing=between,
        handletextpad=0.5,
    )


def key_mark(
    marker: str, label: str, color: str, size: float, *, face: str | None = None, edge: str = ""
) -> Line2D:
    """Return a mark for a key, in one colour or with a face or an edge of another."""
    return Line2D(
        [],
        [],
        linestyle="none",
        marker=marker,
        markersize=size,
        markerfacecolor=face or color,
        markeredgecolor=edge or color,
        label=label,
    )


def share_within(values: Array, weights: Array, share: float) -> float:
    """Return the magnitude that a share of the values does not exceed, by weight.

    Parameters
    ----------
    values, weights : (n,) arrays
        What is to be drawn, and on how much area each value stands.
    share : float
        Share of the area, 0 to 1.
    """
    size = np.abs(values)
    order = np.argsort(size)
    total = np.cumsum(weights[order])
    return float(size[order][np.searchsorted(total, share * total[-1])])


def round_up(value: float) -> float:
    """Return the least of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten that is not below."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])
    # The tolerance is rounding's: 0.3 / 0.1 must stay 3, not become 4.
    return float(power * steps[np.searchsorted(steps, value / power * (1 - 1e-12))])


def color_bar(
    field: ScalarMappable, axes: Axes, label: str, *, extend: str = "neither", upright: bool = False
) -> Colorbar:
    """Draw the colour bar of a field into axes of its own."""
    figure = axes.figure
    bar = figure.colorbar(
        field,
        cax=axes,
        orientation="vertical" if upright else "horizontal",
        extend=extend,
        extendfrac=0.04,
    )
    bar.set_label(label)
    if not isinstance(field.norm, LogNorm):
        bar.formatter = Plain()
        if not upright and not isinstance(field.norm, BoundaryNorm):
            bar.locator = Roomy()
    bar.outline.set_linewidth(0.4)
    return bar


def _shortened(svg: str) -> str:
    """Return an SVG without indents, cut to hundredths of a point: a third fewer bytes."""
    cut = COORDINATES.sub(lambda found: DECIMALS.sub(r"\1", found.group()), svg)
    return INDENT.sub("\n", cut)


def save(figure: Figure, stem: Path, title: str, words: Words) -> list[Path]:
    """Write a figure as SVG and PNG, with its words inside, and return the two paths.

    Parameters
    ----------
    figure : Figure
        The figure.
    stem : Path
        Path without suffix.
    title : str
        A few words: what a browser shows for it.
    words : Words
        Written into the files as their description.
    """
    svg, png = stem.with_suffix(".svg"), stem.with_suffix(".png")
    told = {"Title": title, "Description": words.alt}
    drawn = StringIO()
    with _style():
        figure.savefig(
            drawn, format="svg", dpi=SVG_DOTS, metadata={**told, "Date": None, "Creator": SALT}
        )
        svg.write_text(_shortened(drawn.getvalue()), encoding="utf-8", newline="\n")
        figure.savefig(
            png,
            dpi=PNG_DOTS,
            metadata={**told, "Software": None},
            pil_kwargs={"compress_level": EFFORT},
        )
    return [svg, png]
