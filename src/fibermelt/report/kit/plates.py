"""What a figure of a page is, and how many of them become files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from fibermelt.report.kit.style import Words, drawn_in_style, save

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SUFFIXES", "Plate", "draw_plates", "plate"]

SUFFIXES = (".svg", ".png")
"""Of the files of a figure."""

Drawing = Callable[["xr.Dataset"], Figure]
Wording = Callable[["xr.Dataset"], Words]


@dataclass(frozen=True)
class Plate:
    """A figure of a page.

    Parameters
    ----------
    name : str
        Name of its files, without suffix.
    title : str
        What it is, in a few words.
    drawing : callable
        From the results to the figure; `draw` has it in the style of all.
    words : callable
        From the results to caption and alternative text.
    section : str
        Name of the section of the page that it stands in; of a sweep's there is but one.
    needs : str
        Variables that only the results of its part of a study have, with blanks between.
    paper : str
        Which figure of the paper it stands for, such as ``Fig. 16``; empty if for none.
    place : float
        Where it stands in its section, on the scale of the paper's figures.
    """

    name: str
    title: str
    drawing: Drawing
    words: Wording
    section: str = ""
    needs: str = ""
    paper: str = ""
    place: float = 0.0

    def is_of(self, results: xr.Dataset) -> bool:
        """Tell whether results are enough for it."""
        return all(name in results for name in self.needs.split())

    def draw(self, results: xr.Dataset) -> Figure:
        """Draw it, whatever the user's own settings are."""
        return drawn_in_style(self.drawing, results)


def plate(
    name: str,
    title: str,
    *,
    section: str,
    words: Wording,
    needs: str,
    paper: str = "",
    place: float | None = None,
) -> Callable[[Drawing], Plate]:
    """Make a figure of the function that draws it; the page finds it where its part keeps figures.

    Parameters
    ----------
    name, title, section, words, needs, paper
        As in `Plate`.
    place : float, optional
        As in `Plate`; by default the number of the paper's figure.
    """
    at = place if place is not None else _number(paper)
    return lambda drawing: Plate(name, title, drawing, words, section, needs, paper, at)


def _number(paper: str) -> float:
    """Return the number of a figure of the paper, its letter in hundredths."""
    found = re.match(r"Fig\. (\d+)([a-z]?)", paper)
    if found is None:
        msg = f'a figure that stands for none of the paper\'s (paper = "{paper}") needs a place'
        raise ValueError(msg)
    return int(found[1]) + 0.01 * (ord(found[2]) - ord("a") + 1 if found[2] else 0)


def draw_plates(plates: Iterable[Plate], results: xr.Dataset, directory: Path) -> list[Path]:
    """Draw figures, as SVG and PNG, and return the paths.

    Parameters
    ----------
    plates : iterable of Plate
        The figures; the results must be enough for them.
    results : xarray.Dataset
        What they are drawn of.
    directory : Path
        An existing folder.
    """
    return [
        path
        for one in plates
        for path in save(one.draw(results), directory / one.name, one.title, one.words(results))
    ]
