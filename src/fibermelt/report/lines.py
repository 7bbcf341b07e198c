"""The streamlines as figures show them: which are marked, with which colour, and the zones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fibermelt.report.style import BLUE, GREEN, VERMILION, Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ZONES", "Feature", "at_time", "features", "initial_angles", "rest"]

FEATURES = ((4, BLUE), (10, VERMILION), (18, GREEN))
"""The paper's feature streamlines of its 22 and their colours, the same in every figure."""

PAPER_COUNT = 22

ZONES = ("capillary entrance", "nozzle exit", "end of swell")
"""The paper's zones 1 to 3."""


@dataclass(frozen=True)
class Feature:
    """A marked streamline.

    Parameters
    ----------
    row : int
        Its place along the dimension ``streamline``.
    number : int
        Its number, from the left edge of the nozzle.
    color : str
        Its colour.
    """

    row: int
    number: int
    color: str


def features(results: xr.Dataset) -> list[Feature]:
    """Return the marked streamlines: the paper's 4, 10 and 18 of 22.

    Of another number of streamlines, those that share the flux most nearly as these do.
    """
    fraction = results["flux_fraction"].to_numpy()
    numbers = results["streamline"].to_numpy()
    found: dict[int, Feature] = {}
    for number, color in FEATURES:
        row = int(np.argmin(np.abs(fraction - (number - 0.5) / PAPER_COUNT)))
        found.setdefault(row, Feature(row, int(numbers[row]), color))
    return list(found.values())


def rest(results: xr.Dataset) -> Iterator[int]:
    """Yield the rows of the streamlines that are not marked."""
    marked = {feature.row for feature in features(results)}
    return (row for row in range(results.sizes["streamline"]) if row not in marked)


def at_time(results: xr.Dataset, name: str, row: int, when: Array) -> Array:
    """Return a variable along one streamline at given times, linear between points."""
    time, values = results["time"].to_numpy()[row], results[name].to_numpy()[row]
    found: Array = np.interp(when, time, values)
    return found


def initial_angles(results: xr.Dataset) -> str:
    """Return how many initial angles there are, in words."""
    count = results.sizes["initial_angle"]
    return f"{count} initial angle" + ("s" if count != 1 else "")
