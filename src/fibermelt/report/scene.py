"""The bead and its nozzle as a scene to draw in: outline, mesh and metal, in millimetres.

All of it is read off the stored flow, so that a field that another solver made draws as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import TriMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon, Rectangle
from matplotlib.path import Path
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from fibermelt.report.style import FULL, GREY, INK, PALE, Array, add_axes, new_figure

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "MM",
    "Scene",
    "Window",
    "bed_speed",
    "by_area",
    "curves",
    "draw_bed",
    "draw_bed_motion",
    "draw_field",
    "draw_mesh",
    "draw_metal",
    "draw_outline",
    "frame",
    "free_room",
    "main_scene",
    "mark_window",
    "read_scene",
    "scale_bar",
    "scene_axes",
]

Index = NDArray[np.intp]

MM = 1e3
"""Millimetres in a metre."""

METAL, METAL_EDGE = "#c9ced4", "#7b848d"
MELT = PALE

METAL_THICKNESS = 0.07
"""Of the nozzle's wall as it is drawn, over the inlet's width; what it really is does not matter."""

MAIN_LEFT, MAIN_BOTTOM, MAIN_WIDTH = 10.0, 8.5, 136.0
"""Where the scene stands in a figure across the page [mm]."""

STRAIGHT = 2e-3
"""An edge that bends less than this [mm] is drawn straight: a fraction of a line's width."""

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
        width, gap = float(np.ptp(self.lips[:, 0])), float(self.lips[0, 1])
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
    inlet, outlet = loop[loop[:, 1] > top - 1e-6], loop[loop[:, 0] > right - 1e-6]
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


def scene_axes(figure: Figure, left: float, bottom: float, width: float, window: Window) -> Axes:
    """Return axes with equal scales: ``width`` [mm] on paper, height as the window asks."""
    wide, high = window.size
    axes = add_axes(figure, left, bottom, width, width * high / wide)
    axes.set_xlim(window.left, window.right)
    axes.set_ylim(window.bottom, window.top)
    return axes


def main_scene(scene: Scene) -> tuple[Figure, Axes]:
    """Return a figure across the page with axes for the whole scene, left; x and y in [mm]."""
    wide, high = scene.whole.size
    height = MAIN_WIDTH * high / wide
    figure = new_figure(FULL, MAIN_BOTTOM + height + 1.0)
    axes = scene_axes(figure, MAIN_LEFT, MAIN_BOTTOM, MAIN_WIDTH, scene.whole)
    axes.set_xlabel("x [mm]", loc="left")
    axes.set_ylabel("y [mm]", loc="bottom")
    return figure, axes


@dataclass(frozen=True)
class Room:
    """A free rectangle of a figure [mm]."""

    left: float
    bottom: float
    width: float
    height: float

    @property
    def top(self) -> float:
        """Return its upper side."""
        return self.bottom + self.height

    def fit(self, window: Window) -> float:
        """Return the height of a window that is as wide as the room."""
        wide, high = window.size
        return self.width * high / wide


def free_room(axes: Axes, scene: Scene) -> Room:
    """Return the room right of the nozzle and above the bead in a `main_scene`."""
    whole = scene.whole
    scale = MAIN_WIDTH / whole.size[0]
    right = float(scene.sides["inlet"][:, 0].max()) * (1 + 2 * METAL_THICKNESS)
    left = MAIN_LEFT + scale * (right - whole.left) + 5.0
    bottom = MAIN_BOTTOM + scale * (1.35 * scene.bead_height - whole.bottom) + 6.0
    top = 25.4 * float(axes.figure.get_figheight()) - 7.0  # type: ignore[union-attr]  # always one
    return Room(left, bottom, FULL - 2.0 - left, top - bottom)


def frame(axes: Axes, color: str = GREY) -> None:
    """Make an inset of axes: a frame, no scales."""
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(True)
    axes.spines[:].set_edgecolor(color)


def mark_window(axes: Axes, window: Window) -> None:
    """Show by a frame where an inset lies."""
    axes.add_patch(
        Rectangle(
            (window.left, window.bottom),
            *window.size,
            facecolor="none",
            edgecolor=GREY,
            linewidth=0.8,
            linestyle=(0, (4, 2)),
            zorder=4,
        )
    )


def scale_bar(axes: Axes, window: Window, *, height: float = 0.08, share: float = 0.5) -> None:
    """Draw a bar of a round length at the right, at most a share of the window's width."""
    wide, high = window.size
    power = 10.0 ** np.floor(np.log10(share * wide))
    length = float(power * max(step for step in (1, 2, 5) if step * power <= share * wide))
    name = f"{length:g} mm" if length >= 0.1 else f"{1e3 * length:g} µm"
    end, y = window.right - 0.05 * wide, window.bottom + height * high
    axes.plot([end - length, end], [y, y], color=INK, linewidth=1.5, zorder=6)
    axes.annotate(
        name,
        (end - 0.5 * length, y),
        xytext=(0, 2),
        textcoords="offset points",
        ha="center",
        va="bottom",
        zorder=6,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.8},
    )


def curves(points: Array, edges: Index, straight: float = STRAIGHT) -> Path:
    """Return edges (n, k) as one path; those that bend less than ``straight`` by their ends."""
    lines = points[edges]
    chord = lines[:, -1] - lines[:, 0]
    away = lines - lines[:, :1]
    bend = np.abs(away[..., 0] * chord[:, None, 1] - away[..., 1] * chord[:, None, 0])
    bent = bend.max(axis=1) > straight * np.hypot(*chord.T)
    pieces = [line for line in lines[~bent][:, [0, -1]]] + list(lines[bent])  # noqa: C416
    codes = [np.r_[Path.MOVETO, np.full(len(p) - 1, Path.LINETO)] for p in pieces]
    return Path(np.vstack(pieces), np.concatenate(codes).astype(np.uint8))


def draw_metal(axes: Axes, scene: Scene) -> None:
    """Draw the nozzle's body on both sides of the melt."""
    thick = METAL_THICKNESS * float(np.ptp(scene.sides["inlet"][:, 0]))
    for name, side in (("left wall", -1), ("right wall", 1)):
        wall = scene.sides[name]
        body = np.vstack([wall, wall[::-1] + [side * thick, 0.0]])
        axes.add_patch(
            Polygon(body, facecolor=METAL, edgecolor=METAL_EDGE, linewidth=0.4, zorder=0.5)
        )


def draw_bed(axes: Axes, window: Window, thickness: float = 0.5) -> None:
    """Draw the bed below the melt."""
    axes.axhspan(-thickness, 0.0, facecolor="#e3ddd3", edgecolor="none", linewidth=0, zorder=0.4)
    axes.plot([window.left, window.right], [0, 0], color=METAL_EDGE, linewidth=0.6, zorder=0.6)


def bed_speed(results: xr.Dataset) -> float:
    """Return the speed of the bed [m/s], that of the melt on it."""
    on_bed = results["node_y"].to_numpy() <= results["node_y"].to_numpy().max() * 1e-9
    return float(np.median(results["node_velocity"].to_numpy()[on_bed, 0]))


def draw_bed_motion(axes: Axes, results: xr.Dataset, scene: Scene) -> None:
    """Draw an arrow below the bed, with its speed."""
    y = 0.62 * scene.whole.bottom
    x = 0.45 * scene.whole.right
    axes.annotate(
        f"bed, {MM * bed_speed(results):.1f} mm/s ",
        (x + 0.2 * scene.whole.right, y),
        xytext=(x, y),
        ha="right",
        va="center",
        arrowprops={"arrowstyle": "-|>", "linewidth": 0.9, "color": INK, "shrinkA": 1},
    )


def draw_outline(axes: Axes, scene: Scene, *, fill: bool = False) -> None:
    """Draw the melt: walls dark, free surfaces as such."""
    if fill:
        axes.add_patch(Polygon(scene.outline, facecolor=MELT, edgecolor="none", zorder=0.7))
    for name, line in scene.sides.items():
        wall = name.endswith("wall")
        color = INK if wall or name.endswith("surface") else GREY
        axes.plot(*line.T, color=color, linewidth=0.9 if wall else 0.7, zorder=3)


def inside(scene: Scene, window: Window) -> Index:
    """Return the small triangles that reach into a window."""
    corners = scene.points[scene.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    here = (high > [window.left, window.bottom]).all(axis=1)
    return scene.triangles[here & (low < [window.right, window.top]).all(axis=1)]


def by_area(scene: Scene, values: Array, window: Window) -> tuple[Array, Array]:
    """Return mean values (n,) over the small triangles in a window, and their areas (n,) [mm2]."""
    triangles = inside(scene, window)
    (ax, ay), (bx, by) = np.diff(scene.points[triangles], axis=1).transpose(1, 2, 0)
    return values[triangles].mean(axis=1), 0.5 * np.abs(ax * by - ay * bx)


def draw_field(
    axes: Axes, scene: Scene, window: Window, values: Array, norm: Normalize, cmap: str
) -> TriMesh:
    """Paint nodal values over the melt, linear between nodes (painted inside SVG as well)."""
    mesh = axes.tripcolor(
        Triangulation(*scene.points.T, inside(scene, window)),
        values,
        shading="gouraud",
        norm=norm,
        cmap=cmap,
        rasterized=True,
        zorder=1,
    )
    return cast(TriMesh, mesh)


def draw_mesh(axes: Axes, scene: Scene, color: str, linewidth: float) -> None:
    """Draw the curved triangles by their edges."""
    axes.add_patch(
        PathPatch(
            curves(scene.points, scene.edges),
            facecolor="none",
            edgecolor=color,
            linewidth=linewidth,
            zorder=2,
        )
    )
