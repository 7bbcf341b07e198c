"""Makes the shipped table of a spheroid's answers in power-law melts.

``python -m fibermelt.fiber.cell.spheroid_table FILE`` solves what FILE (CSV) does not hold yet and
adds it there, the indices of one aspect ratio and direction at a time, each from the flow of the
larger index before: half a minute on a quiet core. `fibermelt.fiber.thinning_spheroid` reads it.
"""

from __future__ import annotations

import csv
import sys
from itertools import product
from pathlib import Path

import numpy as np

from fibermelt.fiber.cell.spheroid import SpheroidCell
from fibermelt.fiber.spheroid import Spheroid
from fibermelt.fiber.spheroid_data import SpheroidNumerics, ThinningSpheroid
from fibermelt.fiber.thinning_spheroid import COLUMNS
from fibermelt.melt import PowerLaw

__all__ = ["make_table"]

INDICES = (1.0, 0.75, 0.5, 0.35, 0.25)
ASPECT_RATIOS = (1.0, 1.5, 2.5, 4.0, 6.0, 10.0, 20.0)
PHASES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
"""Degrees."""

PLATEAU = 1e-3
"""Lowest rate of a power law over the far field's: at 1e-2 spin and pressures of n = 0.5 are the
same to 1e-5, those of n = 0.25 to 3e-3 (r_e = 6)."""

SLENDER = 6.0
"""Aspect ratio beyond which a layer more is taken."""


def make_table(path: Path) -> None:
    """Solve what the file does not hold yet, and add it."""
    path.touch()
    with path.open(newline="", encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    done = {tuple(map(float, row[:2])) for row in csv.reader(lines[1:])}
    if not lines:
        _append(path, [COLUMNS])
    for key in product(ASPECT_RATIOS, PHASES):
        if key not in done:
            _append(path, _chain(*key))


def _append(path: Path, rows: list[tuple[str, ...]]) -> None:
    with path.open("a", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def _chain(aspect_ratio: float, degrees: float) -> list[tuple[str, ...]]:
    """Return the rows of all indices at one aspect ratio and one direction."""
    numerics = SpheroidNumerics(layers=7 if aspect_ratio > SLENDER else 6)
    rows, before = [], None
    for index in INDICES:
        law = PowerLaw(1.0, index, PLATEAU)
        cell = SpheroidCell(Spheroid(1.0, aspect_ratio), law, numerics)
        if before is not None:
            cell.start_from(before)
        before = cell
        found = cell.solved(1.0, float(np.radians(degrees)))
        values = (aspect_ratio, degrees, index, found.spin, *_extremes(found))
        rows.append(tuple(f"{value:.8g}" for value in values))
    return rows


def _extremes(found: ThinningSpheroid) -> tuple[float, ...]:
    """Return the pressures, and the angles [degrees] of their places, in the order of `COLUMNS`."""
    angle, pressure = found.meridian()
    low, high = np.argmin(pressure), np.argmax(pressure)
    places = []
    for e in (found.where_lowest, found.where_highest):
        # from the tip, and off the flow's plane
        places += [np.arccos(min(e[0], 1.0)), np.arctan2(e[2], e[1])]
    at = np.degrees([*places, angle[low], angle[high]])
    return (found.lowest, found.highest, found.tip, pressure[low], pressure[high], *at)


if __name__ == "__main__":
    make_table(Path(sys.argv[1]))
