"""The bead in space: a view of it, its three projections, and where it lies on the bed.

Drawn as flat faces from the farthest to the nearest, each as bright as it looks towards the light.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from fibermelt.fields.simplices import facets
from fibermelt.flow.problem import WET
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, Index
from fibermelt.report.kit.style import (
    BLUE,
    FULL,
    GREY,
    INK,
    VERMILION,
    Array,
    Words,
    add_axes,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Skin", "figure_strand", "skin_of"]

VIEW = (0.62, 0.42, 0.66)
"""Where the view is taken from: downstream, from above, from the side."""

LIGHT = (0.25, 0.85, 0.46)
"""Where the light comes from."""

PAINT, SHADE = (0.42, 0.62, 0.80), 0.35
"""Colour of a face that looks into the light, and what is left of it on one that does not."""

SAME = 1e-6
"""Parts of the bead's extent within which nodes lie in a plane."""


@dataclass(frozen=True, eq=False)
class Skin:
    """The bead's surface, both halves.

    Parameters
    ----------
    points : (n, 3) array
        Nodes [mm].
    faces : (m, 3) int array
        Triangles: on the nozzle's wall, the free surface, inlet and outlet.
    normal : (m, 3) array
        Outward, of length one.
    outlet : (k, 2) int array
        Edges of the outlet's rim.
    """

    points: Array
    faces: Index
    normal: Array
    outlet: Index


def skin_of(results: xr.Dataset) -> Skin:
    """Return the surface of a bead that was solved, with its mirror image."""
    points = MM * results["field_points"].to_numpy()
    found = facets(results["field_cells"].to_numpy())
    faces, inside = found.boundary, found.inside
    near = SAME * float(np.ptp(points[:, 0]))
    keep = ~np.all(points[faces][..., 2] < near, axis=1)  # the plane of symmetry is no surface
    faces, inside = faces[keep], inside[keep]
    corner = points[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    away = np.einsum("mi,mi->m", normal, points[inside] - corner[:, 0])
    normal *= (np.where(away > 0.0, -1.0, 1.0) / np.linalg.norm(normal, axis=1))[:, None]
    at_end = faces[np.all(corner[..., 0] > points[:, 0].max() - near, axis=1)]
    edges = np.sort(at_end[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    rim = edges[(count == 1) & ~np.all(points[edges][..., 2] < near, axis=1)]
    other = np.array([1.0, 1.0, -1.0])
    n = len(points)
    return Skin(
        np.concatenate([points, points * other]),
        np.concatenate([faces, faces + n]),
        np.concatenate([normal, normal * other]),
        np.concatenate([rim, rim + n]),
    )


def _axes_of(view: Array) -> tuple[Array, Array]:
    """Return the directions to the right and up of who looks from a side, y up if it can be.

    From above z goes up, along the bed to the right: both halves are mirror images.
    """
    if view[1] > 1.0 - SAME:
        return np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    if view[0] > 1.0 - SAME:
        return np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    right = np.cross([0.0, 1.0, 0.0], view)
    right /= np.linalg.norm(right)
    return right, np.cross(view, right)


def _draw(axes: Axes, skin: Skin, view: Array) -> None:
    """Draw a surface as seen from a direction of length one."""
    right, up = _axes_of(view)
    seen = np.flatnonzero(skin.normal @ view > 0.0)
    corner = skin.points[skin.faces[seen]]
    seen = seen[np.argsort(corner.mean(axis=1) @ view, kind="stable")]
    corner = skin.points[skin.faces[seen]]
    light = np.array(LIGHT) / np.linalg.norm(LIGHT)
    bright = SHADE + (1.0 - SHADE) * np.clip(skin.normal[seen] @ light, 0.0, 1.0)
    colors = 1.0 - (1.0 - np.array(PAINT)) * (1.35 - bright[:, None])
    colors = np.clip(colors * (0.35 + 0.65 * bright[:, None]), 0.0, 1.0)
    shape = np.stack([corner @ right, corner @ up], axis=-1)
    painted = PolyCollection(list(shape), facecolors=colors, edgecolors=colors, linewidths=0.6)
    painted.set_rasterized(True)
    axes.add_collection(painted)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")


def strand_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    size = MM * float(results["bead_height"])

    def told(name: str) -> str:
        return sized(MM * float(results[name]), size, 3)

    return Words(
        caption=(
            "The bead in space, solved for one half and mirrored: (a) a view from downstream; "
            "(b) from its side; (c) from above; (d) along the bed, with the outlet's rim; (e) what "
            f"lies on the bed: the surface within {WET:g} films of it, a film being "
            f"{sized(1e6 * float(results['film']), 100.0, 3)} µm thick. "
            f"{int(results['elements'])} curved tetrahedra, {int(results['unknowns'])} unknowns."
        ),
        alt=(
            "Melt leaves a round nozzle and is laid on a bed as a bead "
            f"{told('bead_height')} mm high and {told('bead_width')} mm wide, "
            f"{told('widest')} mm at its widest. Upstream it reaches x = {told('heel')} mm; it "
            f"first lies on the bed at x = {told('front')} mm, and at the outlet on a width of "
            f"{told('wet_width')} mm."
        ),
    )


@plate(
    "strand",
    "The bead in space",
    section="flow",
    words=strand_words,
    needs="extreme strand_cells",
    place=-1,
)
def figure_strand(results: xr.Dataset) -> Figure:
    """Draw the bead: a view, three projections, and the patch that lies on the bed."""
    skin = skin_of(results)
    figure = new_figure(FULL, 168)
    view = np.array(VIEW) / np.linalg.norm(VIEW)
    whole = add_axes(figure, 4, 92, 110, 72)
    _draw(whole, skin, view)
    _bed(whole, skin, view)
    whole.set_axis_off()
    letter(whole, "a  seen from downstream", inside=True)
    panels = (
        ((13, 55, 92, 33), (0.0, 0.0, 1.0), "b  from its side", ("x", "y")),
        ((13, 9, 92, 33), (0.0, 1.0, 0.0), "c  from above", ("x", "z")),
        ((122, 100, 62, 60), (1.0, 0.0, 0.0), "d  along the bed, from its end", ("z", "y")),
    )
    for place, side, name, labels in panels:
        axes = add_axes(figure, *place)
        _draw(axes, skin, np.array(side))
        axes.set_xlabel(f"{labels[0]} [mm]")
        axes.set_ylabel(f"{labels[1]} [mm]")
        letter(axes, name)
        if side[0]:
            rim = skin.points[skin.outlet][..., [2, 1]]
            axes.add_collection(LineCollection(list(rim), colors=INK, linewidths=0.9))
        if not side[1]:
            axes.axhline(0.0, color=INK, linewidth=0.8, zorder=0.5)
    patch = add_axes(figure, 122, 9, 62, 75)
    _patch(patch, skin, results)
    letter(patch, "e  what lies on the bed")
    return figure


def _bed(axes: Axes, skin: Skin, view: Array) -> None:
    """Draw the bed below a view."""
    right, up = _axes_of(view)
    low, high = skin.points.min(axis=0), skin.points.max(axis=0)
    side = 0.35 * (high[2] - low[2])
    x = (low[0] - side, high[0], high[0], low[0] - side)
    z = (low[2] - side, low[2] - side, high[2] + side, high[2] + side)
    corner = np.stack([x, np.zeros(4), z], axis=-1)
    axes.fill(corner @ right, corner @ up, color="#e9e6df", zorder=0.4, linewidth=0)
    axes.autoscale_view()


def _patch(axes: Axes, skin: Skin, results: xr.Dataset) -> None:
    """Draw the surface as seen from below, and the contour within which it lies on the bed."""
    below = skin.faces[skin.normal[:, 1] < 0.0]
    corner = skin.points[below]
    film = MM * float(results["film"])
    low = corner[..., 1].min(axis=1) < WET * film
    axes.add_collection(
        PolyCollection(list(corner[..., [2, 0]]), facecolors="#eef2f6", edgecolors="none")
    )
    tri = Triangulation(skin.points[:, 2], skin.points[:, 0], below[low])
    height, wet = skin.points[:, 1], WET * film
    axes.tricontourf(tri, height, levels=[-wet, wet], colors=[BLUE], alpha=0.35)
    axes.tricontour(tri, height, levels=[wet], colors=[BLUE], linewidths=1.0)
    front = MM * float(results["front"])
    axes.plot(0.0, front, marker="o", markersize=3.5, color=VERMILION, zorder=4)
    angle = np.linspace(0.0, 2.0 * np.pi, 121)
    radius = 0.5 * float(np.ptp(skin.points[skin.points[:, 1] > 0.999 * height.max()][:, 0]))
    axes.plot(radius * np.sin(angle), radius * np.cos(angle), color=GREY, linewidth=0.7)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("z [mm]")
    axes.set_ylabel("x [mm], the bed's way up")
