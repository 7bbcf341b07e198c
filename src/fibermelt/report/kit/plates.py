"""What a figure of the report is."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from fibermelt.report.kit.style import Words, save

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Plate", "draw_plates"]


@dataclass(frozen=True)
class Plate:
    """A figure of the report.

    Parameters
    ----------
    name : str
        Name of its files, without suffix.
    title : str
        What it is, in a few words.
    draw : callable
        From the results to the figure.
    words : callable
        From the results to caption and alternative text.
    needs : str
        Variables that only the results of its part of a study have, with blanks between.
    paper : str
        Which figure of the paper it stands for, such as ``Fig. 16``; empty if for none.
    """

    name: str
    title: str
    draw: Callable[[xr.Dataset], Figure]
    words: Callable[[xr.Dataset], Words]
    needs: str = "extreme"
    paper: str = ""

    def is_of(self, results: xr.Dataset) -> bool:
        """Tell whether results are enough for it."""
        return all(name in results for name in self.needs.split())


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
        for plate in plates
        for path in save(
            plate.draw(results), directory / plate.name, plate.title, plate.words(results)
        )
    ]
