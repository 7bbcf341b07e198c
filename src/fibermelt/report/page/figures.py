"""All figures of a study, as its parts declare them.

Each figure is a pure function of the results; `draw_figures` writes them as SVG and PNG. The same
results give the same bytes with the same version of matplotlib.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fibermelt.report.kit.plates import SUFFIXES, Plate
from fibermelt.report.page.found import found
from fibermelt.report.page.hand import draw_with_help
from fibermelt.report.page.sections import SECTIONS
from fibermelt.threads import cores

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FIGURES", "draw_figures"]

_PLACES = {section.name: section.place for section in SECTIONS}

FIGURES = tuple(
    sorted(found(Plate, "figures"), key=lambda plate: (_PLACES[plate.section], plate.place))
)
"""The figures in the order of a report."""


def draw_figures(results: xr.Dataset, directory: Path) -> list[Path]:
    """Draw every figure that the results are enough for, as SVG and PNG, and return the paths.

    Parameters
    ----------
    results : xarray.Dataset
        Results of a study, as in results.nc.
    directory : Path
        An existing folder.
    """
    there = tuple(plate for plate in FIGURES if plate.is_of(results))
    draw_with_help(there, results, directory, hands=cores())
    return [directory / f"{plate.name}{kind}" for plate in there for kind in SUFFIXES]
