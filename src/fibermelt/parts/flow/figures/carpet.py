"""What is known on streamlines only, painted as a map: a membrane stretched between the lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.path import Path
from matplotlib.tri import Triangulation
from scipy.sparse import csr_array
from scipy.sparse.linalg import factorized
from scipy.spatial import Delaunay, cKDTree

from fibermelt.report.kit.scene import MM, Index, Window, read_scene
from fibermelt.report.kit.style import Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Carpet", "weave"]

MOST_LINES, LINE_POINTS = 100, 900
"""Streamlines that a map is made of at most, and points of each, evenly spread: no more show."""

BETWEEN = 8000
"""Points of the lattice between the lines, over the whole melt and again over the exit's window:
less than a millimetre apart on paper, whatever the size of the nozzle."""

CLEAR = 0.6
"""Lattice points nearer to a line's points than this part of their distance are left out."""

FLAT = 1e-9
"""Triangles of less area than this part of a lattice's square have no inside to paint."""


@dataclass(frozen=True, eq=False)
class Carpet:
    """What is painted between the first and the last streamline.

    Parameters
    ----------
    triangles : Triangulation
        Triangles between points of the lines, which come first, and of the lattice [mm].
    rows : (line,) array
        The streamlines that it is made of.
    when : (line, n) array
        Times at which these pass their points [s].
    time : (streamline, point) array
        Times of the stored points [s].
    stretch : callable
        From the values at all points of the lines to those at all points.
    """

    triangles: Triangulation
    rows: Index
    when: Array
    time: Array
    stretch: Callable[[Array], Array]

    def values(self, stored: Array) -> Array:
        """Return values at the carpet's points from those at the stored ones."""
        lines = zip(self.when, self.time[self.rows], stored[self.rows], strict=True)
        return self.stretch(np.concatenate([np.interp(*line) for line in lines]))


def weave(results: xr.Dataset) -> Carpet | None:
    """Return the carpet of all streamlines; None if there is but one.

    Between the lines values are harmonic, as the height of a membrane held on the lines: smooth,
    nowhere beyond the values around, and the same whether neighbours run side by side or one turns
    early and the other goes around it.
    """
    lines = np.stack([results[name].to_numpy() for name in ("time", "x", "y")])
    count = lines.shape[1]
    if count < 2:
        return None
    scene = read_scene(results)
    return _woven(lines.tobytes(), count, (scene.exit, scene.whole))


@lru_cache(maxsize=1)
def _woven(stored: bytes, count: int, windows: tuple[Window, Window]) -> Carpet:
    """Return the carpet of lines; kept, as several figures of the same results are painted on it.

    Parameters
    ----------
    stored : bytes
        Times and places x, y of the streamlines, (3, count, points).
    count : int
        Streamlines.
    windows : tuple of Window
        On the exit and on the whole.
    """
    time, x, y = np.frombuffer(stored).reshape(3, count, -1)
    exit_, _ = windows
    rows = np.unique(np.linspace(0, count - 1, min(count, MOST_LINES)).round().astype(np.intp))
    passing, lines = [], []
    for row in rows:
        way = np.r_[0.0, np.cumsum(np.hypot(np.diff(x[row]), np.diff(y[row])))]
        at = np.interp(np.linspace(0.0, way[-1], LINE_POINTS), way, time[row])
        passing.append(at)
        lines.append(MM * np.stack([np.interp(at, time[row], z[row]) for z in (x, y)], axis=-1))
    # The hull is convex, the melt is not: what lies beyond the outer lines is left out.
    rim = Path(np.vstack([lines[0], lines[-1][::-1]]))
    held = np.vstack(lines)
    lattices = [_lattice(window, rim) for window in windows]
    beyond = (lattices[1] < [exit_.left, exit_.bottom]).any(axis=1)
    beyond |= (lattices[1] > [exit_.right, exit_.top]).any(axis=1)
    free = np.vstack([_clear(held, lattices[0]), _clear(held, lattices[1][beyond])])
    points = np.vstack([held, free])
    corners = _triangles(points, rim)
    stretch = _membrane(points, corners, len(held))
    return Carpet(
        Triangulation(points[:, 0], points[:, 1], corners), rows, np.array(passing), time, stretch
    )


def _lattice(window: Window, rim: Path) -> Array:
    """Return about `BETWEEN` points of an even triangular lattice in a window and a rim, (n, 2)."""
    line = np.clip(rim.vertices, [window.left, window.bottom], [window.right, window.top])
    x, y = line.T
    area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    # A lattice of the distance d has a point on sqrt(3)/2 d^2.
    apart = np.sqrt(2.0 / np.sqrt(3.0) * area / BETWEEN)
    rise = 0.5 * np.sqrt(3.0) * apart
    across = np.arange(window.left, window.right, apart)
    up = np.arange(window.bottom, window.top, rise)
    x, y = np.meshgrid(across, up)
    x[1::2] += 0.5 * apart
    points = np.stack([x, y], axis=-1).reshape(-1, 2)
    found: Array = points[rim.contains_points(points)]
    return found


def _clear(held: Array, lattice: Array) -> Array:
    """Return the points of a lattice that are clear of the lines."""
    if len(lattice) < 2:
        return lattice
    apart = float(cKDTree(lattice).query(lattice[0], k=2)[0][1])
    found: Array = lattice[cKDTree(held).query(lattice)[0] > CLEAR * apart]
    return found


def _triangles(points: Array, rim: Path) -> Index:
    """Return Delaunay's triangles of points within a rim, (n, 3)."""
    corners = Delaunay(points).simplices.astype(np.intp)
    (ax, ay), (bx, by) = np.diff(points[corners], axis=1).transpose(1, 2, 0)
    twice = np.abs(ax * by - ay * bx)
    found: Index = corners[
        (twice > FLAT * np.median(twice)) & rim.contains_points(points[corners].mean(axis=1))
    ]
    return found


def _membrane(points: Array, corners: Index, held: int) -> Callable[[Array], Array]:
    """Return the function that extends values at the first points to all, by linear elements.

    ``div grad f = 0`` between the lines, the natural condition at the melt's ends. The weights of
    an edge, half the sum of the cotangents of the angles opposite it, are not negative for
    Delaunay's triangles: no value lies beyond those around it.
    """
    n = len(points)
    at = points[corners]
    opposite = np.roll(at, -2, axis=1) - np.roll(at, -1, axis=1)
    ahead, behind = opposite[:, 0], opposite[:, 1]
    twice = np.abs(ahead[:, 0] * behind[:, 1] - ahead[:, 1] * behind[:, 0])
    local = np.einsum("nai,nbi->nab", opposite, opposite) / (2.0 * twice)[:, None, None]
    i, j = np.repeat(corners, 3, axis=1), np.tile(corners, (1, 3))
    stiffness = csr_array((local.ravel(), (i.ravel(), j.ravel())), shape=(n, n))
    free = np.setdiff1d(np.unique(corners), np.arange(held))
    if not len(free):
        return lambda values: np.r_[values, np.zeros(n - held)]
    solve = factorized(stiffness[free][:, free].tocsc())
    pull = stiffness[free][:, :held]

    def stretch(values: Array) -> Array:
        # Points of no triangle are not painted; zero would pass for a value, the mean does not.
        found: Array = np.r_[values, np.full(n - held, float(np.mean(values)))]
        found[free] = -solve(pull @ values)
        return found

    return stretch
