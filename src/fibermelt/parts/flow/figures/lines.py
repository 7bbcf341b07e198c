"""The streamlines as figures show them: which are marked, with which colour, and the zones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fibermelt.engine.results import has_conditions_of_paper, study_of
from fibermelt.parts.flow.given import is_given
from fibermelt.parts.flow.marked import marked
from fibermelt.report.kit.style import BLUE, GREEN, ORANGE, PINK, VERMILION, Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "ZONES",
    "Feature",
    "against_paper",
    "at_corners",
    "at_time",
    "center_feature",
    "evenly",
    "features",
    "initial_angles",
    "line_word",
    "named",
    "numbered",
    "regular",
    "rest",
]

COLORS = (BLUE, VERMILION, GREEN, ORANGE, PINK)
"""Colours of the marked streamlines, the same in every figure: no more are marked than there are
colours to tell them apart."""

CLEAR = 0.05
"""Names of streamlines closer than this share of all would overlap."""

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
        Its number, from the upstream edge of the nozzle.
    color : str
        Its colour.
    """

    row: int
    number: int
    color: str


def features(results: xr.Dataset) -> list[Feature]:
    """Return the marked streamlines: those of the study's ``streamlines.features``, `marked`."""
    numbers, fraction = (results[name].to_numpy() for name in ("streamline", "flux_fraction"))
    asked = study_of(results).get("streamlines", {}).get("features", [])
    rows = marked(numbers, fraction, asked, given=is_given(results))
    return [
        Feature(row, int(numbers[row]), color) for row, color in zip(rows, COLORS, strict=False)
    ]


def center_feature(results: xr.Dataset) -> Feature:
    """Return the marked streamline nearest to the middle of the flux: the paper's 10."""
    fraction = results["flux_fraction"].to_numpy()
    return min(features(results), key=lambda feature: abs(float(fraction[feature.row]) - 0.5))


def line_word(results: xr.Dataset) -> str:
    """Return what a line that fibers are followed along is called, in one word."""
    return "path" if is_given(results) else "streamline"


def against_paper(results: xr.Dataset, text: str) -> str:
    """Return a sentence that sets results beside the paper's text: under its conditions only."""
    return f" {text}" if has_conditions_of_paper(results) else ""


def regular(results: xr.Dataset) -> NDArray[np.bool_]:
    """Return which streamlines pass no sharp corner; all of them if every one does."""
    found = results["near_singularity"].to_numpy() == 0
    return np.asarray(found if found.any() else ~found)


def numbered(results: xr.Dataset, rows: NDArray[np.bool_]) -> str:
    """Return the numbers of the streamlines chosen, in words."""
    return ", ".join(str(number) for number in results["streamline"].to_numpy()[rows]) or "none"


def at_corners(results: xr.Dataset, before: str, after: str) -> str:
    """Return what is told of the streamlines near a sharp corner, nothing if there is none."""
    near = results["near_singularity"].to_numpy() > 0
    return f" {before} {numbered(results, near)}{after}" if near.any() else ""


def evenly(count: int, most: int) -> list[int]:
    """Return at most so many of the first integers, evenly spread, both ends among them."""
    return [int(k) for k in np.unique(np.rint(np.linspace(0, count - 1, min(count, most))))]


def rest(results: xr.Dataset) -> Iterator[int]:
    """Yield the rows of the streamlines that are not marked."""
    marked = {feature.row for feature in features(results)}
    return (row for row in range(results.sizes["streamline"]) if row not in marked)


def named(results: xr.Dataset) -> dict[int, str | None]:
    """Return the rows of the streamlines that scales name, with the colours of the marked ones.

    The first and the last are among them where they stand clear of a marked one.
    """
    found: dict[int, str | None] = {feature.row: feature.color for feature in features(results)}
    count = results.sizes["streamline"]
    for end in (0, count - 1):
        if all(abs(end - row) > CLEAR * count for row in found):
            found[end] = None
    return dict(sorted(found.items()))


def at_time(results: xr.Dataset, name: str, when: Array) -> Array:
    """Return a variable along all streamlines at times (streamline, n), linear between points."""
    time, values = results["time"].to_numpy(), results[name].to_numpy()
    return np.array([np.interp(*line) for line in zip(when, time, values, strict=True)])


def initial_angles(results: xr.Dataset) -> str:
    """Return how many initial angles there are, in words."""
    count = results.sizes["initial_angle"]
    return f"{count} initial angle" + ("s" if count != 1 else "")
