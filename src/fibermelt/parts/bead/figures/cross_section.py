"""What fibers have met, over the section of the finished bead: maps between the ends of paths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.tri import Triangulation
from scipy.spatial import Delaunay

from fibermelt.parts.bead.figures.strand import Skin, skin_of
from fibermelt.parts.flow.figures.judged import colors_said, held_against
from fibermelt.parts.flow.figures.lines import at_corners, regular
from fibermelt.parts.flow.figures.timeline import on_fibers
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM
from fibermelt.report.kit.style import (
    FULL,
    GREY,
    INK,
    SEQUENTIAL,
    UNJUDGED,
    Array,
    Words,
    add_axes,
    color_bar,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_cross_section"]

BASIS = "bounds"
"""Whose growth exponent is drawn: that of a fiber in its worst direction."""

TALL, BETWEEN = 62.0, 20.0
"""Height of a map with its colour bar, and room between two maps side by side [mm]."""


@dataclass(frozen=True, eq=False)
class Map:
    """A map of the section: what it shows, in which colours, and in words."""

    name: str
    values: Array
    norm: Normalize
    colors: str
    label: str
    zero: float = 0.0


def _maps(results: xr.Dataset) -> Iterator[Map]:
    """Return the maps that results have: pressure, exposure, orientation; by path."""
    kept = regular(results)
    rows = range(results.sizes["streamline"])
    lowest = np.array([on_fibers(results, "bound_lowest", row).min() for row in rows])
    what = "lowest pressure on a fiber"
    against = held_against(results, lowest[kept], what)
    yield Map(what, lowest, against.norm, against.colors, against.label, against.zero)
    if "void_exponent" in results and BASIS in results["void_basis"]:
        exponent = results["void_exponent"].sel(void_basis=BASIS).to_numpy()
        known = exponent[kept]
        high = float(np.nanmax(known, initial=0.0)) or 1.0
        yield Map(
            "exposure", exponent, Normalize(0.0, high), SEQUENTIAL, "growth exponent on a fiber"
        )
    if "orientation" in results:
        share = results["orientation"].isel(axis=0, other_axis=0, point=-1).to_numpy()
        yield Map(
            "orientation along the bead", share, _range(share[kept]), SEQUENTIAL, "a_xx at the end"
        )


def _range(known: Array) -> Normalize:
    """Return a scale between the tenths around some values in [0, 1]."""
    if not known.size:
        return Normalize(0.0, 1.0)
    return Normalize(np.floor(10.0 * known.min()) / 10.0, np.ceil(10.0 * known.max()) / 10.0)


def cross_section_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    kept = regular(results)
    y, z = (MM * results[name].to_numpy()[:, -1] for name in "yz")
    maps = list(_maps(results))
    left = at_corners(results, "Hatched, left out: paths", ", near the lip, and what lies beyond.")
    told = []
    for one in maps:
        values = np.where(kept & np.isfinite(one.values), one.values, np.nan)
        if np.isnan(values).all():
            continue
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        told.append(
            f"{one.name} from {number(values[low], 3)} (y = {number(y[low], 2)} mm, z = "
            f"{number(z[low], 2)} mm) to {number(values[high], 3)} (y = {number(y[high], 2)} mm, "
            f"z = {number(z[high], 2)} mm)"
        )
    names = "; ".join(f"({'abc'[k]}) {one.name}" for k, one in enumerate(maps))
    return Words(
        caption=(
            "What a fiber met on its way, over the section of the finished bead, looking upstream: "
            f"{names}. Between the ends of paths (points), linear; "
            f"({'abcd'[len(maps)]}) where they begin in the nozzle, in the colours of (a); "
            f"{colors_said(results, line=False)}.{left}"
        ),
        alt=f"Maps of the bead's section: {'; '.join(told)}.",
    )


@plate(
    "cross-section",
    "Over the bead's section",
    section="fibers",
    words=cross_section_words,
    needs="extreme strand_cells",
    place=0,
)
def figure_cross_section(results: xr.Dataset) -> Figure:
    """Draw lowest pressure, exposure and orientation over the section at the outlet."""
    maps, skin = list(_maps(results)), skin_of(results)
    rows = len(maps) // 2 + 1
    figure = new_figure(FULL, 4 + (TALL + 6) * rows)
    wide = (FULL - 16 - BETWEEN) / 2
    for k, one in enumerate(maps):
        row, column = divmod(k, 2)
        left, bottom = 14 + column * (wide + BETWEEN), 10 + (TALL + 6) * (rows - 1 - row)
        axes = add_axes(figure, left, bottom + 12, wide, TALL - 20)
        _paint(axes, results, skin, one)
        letter(axes, f"{'abc'[k]}  {one.name}")
        bar = add_axes(figure, left, bottom, wide, 2.2)
        color_bar(ScalarMappable(one.norm, one.colors), bar, one.label, extend="neither")
    row, column = divmod(len(maps), 2)
    left, bottom = 14 + column * (wide + BETWEEN), 10 + (TALL + 6) * (rows - 1 - row)
    axes = add_axes(figure, left, bottom + 2, wide, TALL - 10)
    _origins(axes, results, maps[0])
    letter(axes, f"{'abcd'[len(maps)]}  where they came from, in the nozzle")
    return figure


def _origins(axes: Axes, results: xr.Dataset, one: Map) -> None:
    """Draw where paths begin in the nozzle's section, in the colours of a map."""
    radius, angle = (results[f"start_{name}"].to_numpy() for name in ("radius", "angle"))
    known = regular(results) & np.isfinite(one.values)
    for side in (1.0, -1.0):
        x, z = radius * np.cos(angle), side * radius * np.sin(angle)
        axes.scatter(z[~known], x[~known], s=9, facecolors="none", edgecolors=GREY, linewidths=0.6)
        axes.scatter(
            z[known],
            x[known],
            c=one.values[known] - one.zero,
            norm=one.norm,
            cmap=one.colors,
            s=16,
            edgecolors=INK,
            linewidths=0.3,
        )
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(np.cos(around), np.sin(around), color=INK, linewidth=0.9)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("z [radii]")
    axes.set_ylabel("x [radii], downstream up")


def _paint(axes: Axes, results: xr.Dataset, skin: Skin, one: Map) -> None:
    """Paint a map between the ends of paths, both halves."""
    y, z = (MM * results[name].to_numpy()[:, -1] for name in "yz")
    known = regular(results) & np.isfinite(one.values)
    outline = _outline(skin)
    axes.add_patch(PathPatch(outline, **UNJUDGED))
    y, z, values = np.r_[y, y], np.r_[z, -z], np.r_[one.values, one.values] - one.zero
    known = np.r_[known, known]
    places = np.stack([z, y], axis=-1)
    corners = Delaunay(places).simplices
    inside = outline.contains_points(places[corners].mean(axis=1))
    corners = corners[known[corners].all(axis=1) & inside]
    if len(corners):
        triangles = Triangulation(z, y, corners)
        painted = axes.tripcolor(
            triangles,
            np.where(known, values, 0.0),
            norm=one.norm,
            cmap=one.colors,
            shading="gouraud",
        )
        painted.set_rasterized(True)
    axes.plot(z[known], y[known], ".", color=INK, markersize=1.6)
    axes.plot(z[~known], y[~known], ".", color=GREY, markersize=1.6)
    rim = skin.points[skin.outlet][..., [2, 1]]
    axes.add_collection(LineCollection(list(rim), colors=INK, linewidths=0.9))
    axes.axhline(0.0, color=INK, linewidth=0.6, zorder=0.5)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("z [mm]")
    axes.set_ylabel("y [mm]")


def _outline(skin: Skin) -> Path:
    """Return the rim of the outlet as a closed curve around its middle, (z, y)."""
    points = skin.points[np.unique(skin.outlet)][:, [2, 1]]
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    order = np.argsort(np.arctan2(*(points - middle).T))
    return Path(points[order], closed=False)
