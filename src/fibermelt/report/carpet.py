"""What is known on streamlines only, painted as a map: strips between neighbouring lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.tri import Triangulation

from fibermelt.report.scene import MM
from fibermelt.report.style import Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Carpet", "weave"]

CARPET_POINTS = 900
"""Points of each streamline that the map is made of, evenly spread: about one to a pixel."""

SMOOTHING = 61
"""Points over which the strips between streamlines are smoothed: about two capillary widths."""


def _partners(left: Array, right: Array) -> Array:
    """Return for each point of a line (n, 2) the place on its neighbour (n, 2) to join it with.

    The lines are stitched step by step with the shorter diagonal of the two; the places, counted
    in points, are then smoothed along the line, since a jump would show as a streak.
    """
    a, b = [complex(*p) for p in left], [complex(*p) for p in right]
    i, j, last = 0, 0, len(a) - 1
    places: list[list[int]] = [[] for _ in a]
    while i < last or j < last:
        places[i].append(j)
        if j == last or (i < last and abs(a[i + 1] - b[j]) < abs(a[i] - b[j + 1])):
            i += 1
        else:
            j += 1
    places[i].append(j)
    even = np.arange(len(a), dtype=np.float64)
    offset = np.array([0.5 * (found[0] + found[-1]) for found in places]) - even
    window = np.hanning(SMOOTHING + 2)[1:-1]
    padded = np.pad(offset, SMOOTHING // 2, mode="edge")
    smooth = even + np.convolve(padded, window / window.sum(), mode="valid")
    smooth[[0, -1]] = 0.0, last
    return np.maximum.accumulate(np.minimum(smooth, last))


@dataclass(frozen=True, eq=False)
class Carpet:
    """What is painted between neighbouring streamlines: a strip of triangles for each pair.

    Parameters
    ----------
    triangles : Triangulation
        Triangles of all strips [mm].
    when : (streamline - 1, 2, n) array
        Times at which the two lines of each pair pass the strip's points [s].
    time : (streamline, point) array
        Times of the stored points [s].
    """

    triangles: Triangulation
    when: Array
    time: Array

    def values(self, stored: Array) -> Array:
        """Return values at the carpet's points from those at the stored ones."""
        return _at(self.when, self.time, stored).ravel()


def _at(when: Array, time: Array, stored: Array) -> Array:
    """Return values on both lines of each pair at given times, (streamline - 1, 2, n)."""
    return np.array(
        [
            [np.interp(when[k, side], time[k + side], stored[k + side]) for side in (0, 1)]
            for k in range(len(when))
        ]
    )


def weave(results: xr.Dataset) -> Carpet | None:
    """Return strips between points evenly spread along each streamline; None if there is one."""
    time, x, y = (results[name].to_numpy() for name in ("time", "x", "y"))
    if len(time) < 2:
        return None
    passing, lines = [], []
    for row in range(len(time)):
        way = np.r_[0.0, np.cumsum(np.hypot(np.diff(x[row]), np.diff(y[row])))]
        at = np.linspace(0.0, way[-1], CARPET_POINTS)
        passing.append(np.interp(at, way, time[row]))
        lines.append(np.column_stack([np.interp(at, way, x[row]), np.interp(at, way, y[row])]))
    even = np.arange(CARPET_POINTS)
    when = np.array(
        [
            [passing[k], np.interp(_partners(lines[k], lines[k + 1]), even, passing[k + 1])]
            for k in range(len(lines) - 1)
        ]
    )
    number = np.arange(when.size).reshape(when.shape)
    here, beside = number[:, 0, :-1].ravel(), number[:, 1, :-1].ravel()
    ahead, across = here + 1, beside + 1
    triangles = np.column_stack([here, beside, across, here, across, ahead]).reshape(-1, 3)
    across_x, across_y = (MM * _at(when, time, values).ravel() for values in (x, y))
    return Carpet(Triangulation(across_x, across_y, triangles), when, time)
