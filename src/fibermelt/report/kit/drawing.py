"""Draw the scene: its metal, its bed, its outline, its mesh and the fields on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import TriMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon, Rectangle
from matplotlib.path import Path
from matplotlib.tri import Triangulation

from fibermelt.report.kit.scene import MM, Index, Scene, Window, bed_speed, inside
from fibermelt.report.kit.style import FULL, GREY, INK, PALE, Array, add_axes, new_figure
from fibermelt.report.kit.tables import short

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "Room",
    "curves",
    "draw_bead",
    "draw_bed",
    "draw_bed_motion",
    "draw_field",
    "draw_mesh",
    "draw_metal",
    "draw_outline",
    "frame",
    "main_scene",
    "mark_exit",
    "mark_window",
    "on_paper",
    "paint",
    "plain",
    "scale_bar",
    "scene_axes",
    "spread_out",
    "zone_badge",
]

METAL, METAL_EDGE = "#c9ced4", "#7b848d"
MELT: Mapping[str, Any] = {"facecolor": PALE, "edgecolor": "none"}

METAL_THICKNESS = 0.07
"""Of the nozzle's wall as drawn, over the inlet's width; what it really is does not matter."""

MAIN_LEFT, MAIN_BOTTOM, MAIN_WIDTH = 12.0, 8.5, 134.0
"""Where the scene stands in a figure across the page, and its width at most [mm]."""

ROOM_WIDTH, MARGIN = (88.0, 102.0), 2.0
"""Least and largest width of the room beside the nozzle, and what stays free at its right [mm]."""

STRAIGHT = 0.02
"""An edge that bends less on paper [mm], a quarter of a line's width, is drawn straight."""

OUTLINE = 0.01
"""The melt's filled outline is true to this on paper [mm]: a thirtieth of its line's width."""

MOST_EDGES = 6000
"""A mesh of more edges than this is painted in dots inside SVG, which would grow beyond 1 MB."""


def scene_axes(figure: Figure, left: float, bottom: float, width: float, window: Window) -> Axes:
    """Return axes with equal scales: ``width`` [mm] on paper, height as the window asks."""
    wide, high = window.size
    axes = add_axes(figure, left, bottom, width, width * high / wide)
    axes.set_xlim(window.left, window.right)
    axes.set_ylim(window.bottom, window.top)
    return axes


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


def main_scene(scene: Scene, extra: float, below: float = 0.0) -> tuple[Figure, Axes, Room]:
    """Return a figure across the page, axes for the whole scene, and the room beside the nozzle.

    The scene stands left, with x and y in [mm]. The room right of the nozzle and above the bead
    is wide enough for a chart and high enough for the scene's exit and what goes with it: where
    the nozzle leaves too little, the scene is drawn smaller, or the figure higher.

    Parameters
    ----------
    scene : Scene
        What is to be drawn.
    extra : float
        Height on paper that is needed in the room besides the exit's [mm].
    below : float
        Height on paper to leave free below the scene [mm].
    """
    whole = scene.whole
    wide, high = whole.size
    nozzle = float(scene.sides["inlet"][:, 0].max()) * (1 + 2 * METAL_THICKNESS) - whole.left
    beside = FULL - MAIN_LEFT - MARGIN - 5.0
    width = min(MAIN_WIDTH, (beside - ROOM_WIDTH[0]) * wide / nozzle)
    scale = width / wide
    free = min(beside - scale * nozzle, ROOM_WIDTH[1])
    foot = below + MAIN_BOTTOM
    bottom = foot + scale * (1.35 * scene.bead_height - whole.bottom) + 6.0
    least = Room(FULL - MARGIN - free, bottom, free, 0.0).fit(scene.exit) + extra
    paper = max(foot + scale * high + 1.0, bottom + least + 7.0)
    figure = new_figure(FULL, paper)
    axes = scene_axes(figure, MAIN_LEFT, foot, width, whole)
    axes.set_xlabel("x [mm]", loc="left")
    axes.set_ylabel("y [mm]", loc="bottom")
    return figure, axes, Room(FULL - MARGIN - free, bottom, free, paper - 7.0 - bottom)


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


def spread_out(places: Array, least: float) -> Array:
    """Return places moved apart so that none is nearer than ``least`` to the next, (n,).

    Labels that would overlap share the room around their mean; the rest stay where they are.

    Parameters
    ----------
    places : (n,) array
        Where labels are wanted along a line.
    least : float
        Least distance of two, in the same unit.
    """
    order = np.argsort(places, kind="stable")
    groups: list[tuple[float, int]] = []  # the middle of each group of touching labels, how many
    for place in places[order]:
        middle, count = float(place), 1
        while groups and middle - groups[-1][0] < 0.5 * least * (count + groups[-1][1]):
            before, fewer = groups.pop()
            middle = (middle * count + before * fewer) / (count + fewer)
            count += fewer
        groups.append((middle, count))
    moved = np.empty(len(places))
    moved[order] = np.concatenate(
        [middle + least * (np.arange(n) - 0.5 * (n - 1)) for middle, n in groups]
    )
    return moved


def on_paper(axes: Axes, points: float) -> float:
    """Return the length in an axes' units that is so many points on paper."""
    return _drawn(axes) * points * 25.4 / 72.0


def zone_badge(
    axes: Axes,
    zone: int,
    at: tuple[float, float],
    offset: tuple[float, float],
    coords: tuple[str, str] = ("data", "data"),
) -> None:
    """Write the number of a zone, 1 to 3, in a dark disc at an offset in points from a place."""
    axes.annotate(
        str(zone),
        at,
        xycoords=coords,
        xytext=offset,
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=6.5,
        color="white",
        fontweight="bold",
        zorder=7,
        bbox={"boxstyle": "circle,pad=0.18", "facecolor": INK, "edgecolor": "none"},
    )


def curves(points: Array, edges: Index, straight: float) -> Path:
    """Return edges (n, k) as one path; those that bend less than ``straight`` by their ends."""
    lines = points[edges]
    chord = lines[:, -1] - lines[:, 0]
    away = lines - lines[:, :1]
    bend = np.abs(away[..., 0] * chord[:, None, 1] - away[..., 1] * chord[:, None, 0])
    bent = bend.max(axis=1) > straight * np.hypot(*chord.T)
    pieces = [*lines[~bent][:, [0, -1]], *lines[bent]]
    codes = [np.r_[Path.MOVETO, np.full(len(p) - 1, Path.LINETO)] for p in pieces]
    return Path(np.vstack(pieces), np.concatenate(codes).astype(np.uint8))


def plain(path: Path, tolerance: float) -> Path:
    """Return a path without the points that lie closer than a tolerance to the rest's course."""
    path.should_simplify = True
    path.simplify_threshold = tolerance
    return path.cleaned(simplify=True)


def _drawn(axes: Axes) -> float:
    """Return the length that is drawn as a millimetre on paper [mm]."""
    low, high = axes.get_xlim()
    inches = axes.get_position().width * axes.figure.bbox.width / axes.figure.dpi
    return float((high - low) / (25.4 * inches))


def draw_metal(axes: Axes, scene: Scene) -> None:
    """Draw the nozzle's body on both sides of the melt."""
    thick = METAL_THICKNESS * float(np.ptp(scene.sides["inlet"][:, 0]))
    for name, side in (("left wall", -1), ("right wall", 1)):
        wall = scene.sides[name]
        body = np.vstack([wall, wall[::-1] + np.array([side * thick, 0.0])])
        axes.add_artist(
            Polygon(body, facecolor=METAL, edgecolor=METAL_EDGE, linewidth=0.4, zorder=0.5)
        )


def draw_bed(axes: Axes, window: Window) -> None:
    """Draw the bed below the melt, as far down as a window shows."""
    low = min(window.bottom, 0.0)
    axes.axhspan(low, 0.0, facecolor="#e3ddd3", edgecolor="none", linewidth=0, zorder=0.4)
    axes.plot([window.left, window.right], [0, 0], color=METAL_EDGE, linewidth=0.6, zorder=0.6)


def draw_bed_motion(axes: Axes, results: xr.Dataset, scene: Scene) -> None:
    """Draw an arrow below the bed, with its speed."""
    y = 0.62 * scene.whole.bottom
    x = 0.45 * scene.whole.right
    axes.annotate(
        f"bed, {short(MM * bed_speed(results), 4)} mm/s ",
        (x + 0.2 * scene.whole.right, y),
        xytext=(x, y),
        ha="right",
        va="center",
        arrowprops={"arrowstyle": "-|>", "linewidth": 0.9, "color": INK, "shrinkA": 1},
    )


def draw_outline(axes: Axes, scene: Scene, *, fill: Mapping[str, Any] | None = None) -> None:
    """Draw the melt: walls dark, free surfaces as such."""
    if fill is not None:
        melt = plain(Path(scene.outline), OUTLINE * _drawn(axes))
        axes.add_artist(PathPatch(melt, **fill, zorder=0.7))
    for name, line in scene.sides.items():
        wall = name.endswith("wall")
        color = INK if wall or name.endswith("surface") else GREY
        axes.plot(*line.T, color=color, linewidth=0.9 if wall else 0.7, zorder=3)


def draw_bead(
    axes: Axes, scene: Scene, window: Window, *, fill: Mapping[str, Any] | None = MELT
) -> None:
    """Draw the nozzle, the bed and the melt, as far as a window shows them."""
    draw_metal(axes, scene)
    draw_bed(axes, window)
    draw_outline(axes, scene, fill=fill)


def mark_exit(axes: Axes, inset: Axes, scene: Scene) -> None:
    """Mark the exit in the whole scene, and make axes its inset, with a bar of a round length."""
    mark_window(axes, scene.exit)
    frame(inset)
    scale_bar(inset, scene.exit, height=0.85, share=0.12)


def paint(
    axes: Axes, triangles: Triangulation, values: Array, norm: Normalize, cmap: str
) -> TriMesh:
    """Paint values at the points of triangles, linear between them; in dots inside SVG as well."""
    mesh = TriMesh(triangles, norm=norm, cmap=cmap, rasterized=True, zorder=1)
    mesh.set_array(values)
    axes.add_collection(mesh, autolim=False)
    return mesh


def draw_field(
    axes: Axes, scene: Scene, window: Window, values: Array, norm: Normalize, cmap: str
) -> TriMesh:
    """Paint nodal values over the part of the melt that a window shows."""
    x, y = scene.points.T
    return paint(axes, Triangulation(x, y, inside(scene, window)), values, norm, cmap)


def draw_mesh(axes: Axes, scene: Scene, window: Window, color: str, linewidth: float) -> None:
    """Draw the curved triangles by their edges, as far as a window shows them."""
    lines = scene.points[scene.edges]
    low, high = lines.min(axis=1), lines.max(axis=1)
    here = (high > [window.left, window.bottom]).all(axis=1)
    here &= (low < [window.right, window.top]).all(axis=1)
    axes.add_artist(
        PathPatch(
            curves(scene.points, scene.edges[here], STRAIGHT * _drawn(axes)),
            facecolor="none",
            edgecolor=color,
            linewidth=linewidth,
            rasterized=bool(np.count_nonzero(here) > MOST_EDGES),
            zorder=2,
        )
    )
