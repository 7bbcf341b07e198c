"""The bead and its nozzle as a scene to draw: points, triangles, outline, in millimetres.

All of it is read off the stored flow, so that a field that another solver made draws as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fibermelt.report.kit.style import Array
from fibermelt.units import MM, MPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MM", "MPA", "Index", "Scene", "Window", "bed_speed", "by_area", "inside", "read_scene"]

Index = NDArray[np.intp]

SAME = 1e-7
"""Nodes of a straight side differ by less than this, over the size of the domain."""

SIDES = (
    "left wall",
    "upstream surface",
    "bed",
    "outlet",
    "downstream surface",
    "right wall",
    "inlet",
)


@dataclass(frozen=True)
class Window:
    """A part of the plane [mm]."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def size(self) -> tuple[float, float]:
        """Return width and height [mm]."""
        return self.right - self.left, self.top - self.bottom


@dataclass(frozen=True, eq=False)
class Scene:
    """The flow's geometry in [mm].

    Parameters
    ----------
    points : (N, 2) array
        Nodes.
    triangles : (n, 3) array
        Small triangles between the nodes of the curved ones.
    edges : (n_edges, order + 1) array
        Nodes along each edge of the curved triangles.
    sides : mapping
        Each of `SIDES` as a line (n, 2), counter-clockwise around the melt from the inlet's left.
    capillary_entrance : float
        Height of the capillary's entrance.
    """

    points: Array
    triangles: Index
    edges: Index
    sides: Mapping[str, Array]
    capillary_entrance: float

    @property
    def outline(self) -> Array:
        """Return the melt's boundary as one closed line (n, 2)."""
        return np.vstack([self.sides[name] for name in SIDES])

    @property
    def lips(self) -> Array:
        """Return the upstream and the downstream lip, (2, 2)."""
        return np.stack([self.sides["left wall"][-1], self.sides["right wall"][0]])

    @property
    def contact(self) -> Array:
        """Return where the upstream surface meets the bed, (2,)."""
        return np.array(self.sides["bed"][0])

    @property
    def width(self) -> float:
        """Return the capillary's width: the size that places near the exit are told by."""
        return float(np.ptp(self.lips[:, 0]))

    @property
    def bead_height(self) -> float:
        """Return the height at the outlet."""
        return float(np.ptp(self.sides["outlet"][:, 1]))

    @property
    def whole(self) -> Window:
        """Return a window on all of it, nozzle and bed with some room around."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        room = 0.04 * float((high - low).max())
        return Window(
            float(low[0]) - 1.3 * room,
            float(high[0]) + 0.4 * room,
            float(low[1]) - 1.2 * room,
            float(high[1]) + 1.2 * room,
        )

    @property
    def exit(self) -> Window:
        """Return a window on the gap: both lips, both surfaces, the bead as it settles."""
        width, gap = self.width, float(self.lips[0, 1])
        heel = float(self.sides["upstream surface"][:, 0].min())
        return Window(heel - 0.2 * width, heel + 2.75 * width, -0.12 * gap, 1.5 * gap)


def _lattice(order: int) -> dict[tuple[int, int], int]:
    """Return the number of each node (i, j), i + j <= order, of a triangle in VTK's order.

    Corners, then the edges 01, 12, 20, then the inside, ordered as a triangle of degree less 3.
    """
    if order == 0:
        return {(0, 0): 0}
    places = [(0, 0), (order, 0), (0, order)]
    steps = range(1, order)
    places += [(k, 0) for k in steps]
    places += [(order - k, k) for k in steps]
    places += [(0, order - k) for k in steps]
    if order >= 3:
        places += [(i + 1, j + 1) for i, j in _lattice(order - 3)]
    return {place: number for number, place in enumerate(places)}


def _small_triangles(cells: Index, order: int) -> Index:
    """Return the small triangles between the nodes of the curved ones, (n order^2, 3)."""
    at = _lattice(order)
    small = [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in at if i + j < order]
    small += [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in at if i + j < order - 1]
    return cells[:, np.array(small)].reshape(-1, 3)


def _edges(cells: Index, order: int) -> tuple[Index, Index]:
    """Return all edges once, and those of the boundary in the sense of their triangle."""
    between = [np.arange(3 + k * (order - 1), 3 + (k + 1) * (order - 1)) for k in range(3)]
    local = [np.r_[k, between[k], (k + 1) % 3] for k in range(3)]
    edges = cells[:, np.array(local)].reshape(-1, order + 1)
    ends = np.sort(edges[:, [0, -1]], axis=1)
    _, first, count = np.unique(ends, axis=0, return_index=True, return_counts=True)
    return edges[first], edges[first[count == 1]]


def _loop(boundary: Index, points: Array) -> Array:
    """Return the boundary as one closed line, counter-clockwise, its first point not repeated."""
    following = {int(edge[0]): edge for edge in boundary}
    start = node = int(boundary[0, 0])
    chain: list[int] = []
    for _ in range(len(boundary)):
        edge = following[node]
        chain += [int(n) for n in edge[:-1]]
        node = int(edge[-1])
        if node == start:
            break
    line = points[chain]
    x, y = line.T
    area = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    return line if area > 0 else line[::-1]


def read_scene(results: xr.Dataset) -> Scene:
    """Read the flow's geometry from results."""
    points = MM * np.stack([results["node_x"], results["node_y"]], axis=-1)
    cells = results["cell_nodes"].to_numpy().astype(np.intp)
    order = int(results["field_order"])
    edges, boundary = _edges(cells, order)
    loop = _loop(boundary, points)
    surfaces = [MM * results[f"{name}_surface"].to_numpy() for name in ("upstream", "downstream")]
    top, right = points[:, 1].max(), points[:, 0].max()
    same = SAME * float(np.ptp(points, axis=0).max())
    inlet, outlet = loop[loop[:, 1] > top - same], loop[loop[:, 0] > right - same]
    marks = [
        inlet[np.argmin(inlet[:, 0])],
        surfaces[0][0],
        surfaces[0][-1],
        outlet[np.argmin(outlet[:, 1])],
        outlet[np.argmax(outlet[:, 1])],
        surfaces[1][0],
        inlet[np.argmax(inlet[:, 0])],
    ]
    cuts = [int(np.argmin(np.hypot(*(loop - mark).T))) for mark in marks]
    n = len(loop)
    sides = {}
    for name, here, there in zip(SIDES, cuts, [*cuts[1:], cuts[0]], strict=True):
        sides[name] = loop[(here + np.arange((there - here) % n + 1)) % n]
    zone, time, y = (results[v].to_numpy() for v in ("zone_time", "time", "y"))
    entrance = [np.interp(zone[k, 0], time[k], MM * y[k]) for k in range(len(y))]
    return Scene(
        points=points,
        triangles=_small_triangles(cells, order),
        edges=edges,
        sides=sides,
        capillary_entrance=float(np.median(entrance)),
    )


def inside(scene: Scene, window: Window) -> Index:
    """Return the small triangles that reach into a window."""
    corners = scene.points[scene.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    here = (high > [window.left, window.bottom]).all(axis=1)
    found: Index = scene.triangles[here & (low < [window.right, window.top]).all(axis=1)]
    return found


def by_area(scene: Scene, values: Array, window: Window) -> tuple[Array, Array]:
    """Return mean values (n,) over the small triangles in a window, and their areas (n,) [mm2]."""
    triangles = inside(scene, window)
    (ax, ay), (bx, by) = np.diff(scene.points[triangles], axis=1).transpose(1, 2, 0)
    return values[triangles].mean(axis=1), 0.5 * np.abs(ax * by - ay * bx)


def bed_speed(results: xr.Dataset) -> float:
    """Return the speed of the bed [m/s], that of the melt on it."""
    on_bed = results["node_y"].to_numpy() <= results["node_y"].to_numpy().max() * 1e-9
    return float(np.median(results["node_velocity"].to_numpy()[on_bed, 0]))
