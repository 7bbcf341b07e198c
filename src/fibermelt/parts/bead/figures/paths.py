"""Figures of a flow from elsewhere: its paths, what fibers meet on them, and the extremes.

They ask for nothing but paths: a plane or space, with a field behind them or without.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from fibermelt.fields.simplices import facets, ridges
from fibermelt.parts.bead.figures.spread import draw_spread, spread_key
from fibermelt.parts.flow.figures.judged import Against, colors_said, held_against
from fibermelt.parts.flow.figures.lines import (
    at_corners,
    evenly,
    features,
    initial_angles,
    regular,
)
from fibermelt.parts.flow.figures.timeline import SIDES, draw_own, on_fibers, own
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, MPA, Index
from fibermelt.report.kit.style import (
    BAND,
    FULL,
    GREY,
    INK,
    Array,
    Words,
    add_axes,
    key_above,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import number, ranged, short

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "field_edges",
    "figure_path_extremes",
    "figure_path_histories",
    "figure_paths",
]

SPARSE = 200
"""Points of a path that are drawn: a curve of 60 mm needs no more."""

MOST_LINES = 200
"""Paths that are drawn: more hide one another."""

MOST_CURVES = 30
"""More paths than this to a panel are painted in dots inside SVG: 200 pieces of each are heavy."""

SHARP = 0.8
"""Cosine between two faces of a boundary below which their edge is drawn: 37 degrees."""

PLACES = {
    0: "on the way",
    1: "before the capillary (Loc. 1)",
    2: "from the exit to the end of the swell (Loc. 2)",
}
"""The locations of extremes, in words."""

PLANES = (("x", "y"), ("x", "z"), ("z", "y"))
VIEWS = ("from its side", "from above", "along the x axis")
"""Projections of a flow in space."""


def _lowest(results: xr.Dataset) -> Array:
    """Return the lowest pressure on a fiber in the worst orientation, above the air's [MPa]."""
    rows = range(results.sizes["streamline"])
    return np.stack([on_fibers(results, "bound_lowest", row) for row in rows])


def _drawn_rows(results: xr.Dataset) -> list[int]:
    """Return which paths are drawn: evenly among all, the marked ones with them."""
    even = evenly(results.sizes["streamline"], MOST_LINES)
    return sorted({*even, *(feature.row for feature in features(results))})


def paths_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    lowest = np.where(regular(results)[:, None], _lowest(results), np.inf)
    row, at = np.unravel_index(np.argmin(lowest), lowest.shape)
    names = ("x", "y", "z") if "z" in results else ("x", "y")
    where = ", ".join(
        f"{name} = {number(MM * float(results[name].to_numpy()[row, at]), 3)} mm" for name in names
    )
    count = results.sizes["streamline"]
    left = at_corners(results, "Dotted, left out: paths", ", near a sharp corner.")
    sides = (
        " from its side, from above and along the flow; (d) where they end"
        if "z" in results
        else ""
    )
    return Words(
        caption=(
            f"The {count} paths{sides}. Colour: the lowest pressure on the surface of a fiber in "
            f"its worst direction there and then; {colors_said(results, line=False)}.{left}"
        ),
        alt=(
            f"{count} paths coloured by the lowest pressure on a fiber, least on path "
            f"{int(results['streamline'][row])}: {number(lowest[row, at], 3)} MPa at {where}."
        ),
    )


@plate(
    "paths", "The paths", section="flow", words=paths_words, needs="extreme field_notes", place=0
)
def figure_paths(results: xr.Dataset) -> Figure:
    """Draw the paths, coloured by the lowest pressure on a fiber, and where they end."""
    space = "z" in results
    figure = new_figure(FULL, 150 if space else 96)
    lowest = _lowest(results)
    against = held_against(results, lowest[regular(results)], "lowest pressure on a fiber")
    if space:
        places = ((13, 88, 80, 48), (13, 24, 80, 48), (108, 88, 72, 48))
        for k, (plane, place) in enumerate(zip(PLANES, places, strict=True)):
            axes = add_axes(figure, *place)
            _projection(axes, results, plane, lowest, against)
            letter(axes, f"{'abc'[k]}  {VIEWS[k]}")
        ends = add_axes(figure, 108, 24, 72, 48)
        _ends(ends, results, lowest, against)
        letter(ends, "d  where the paths end")
    else:
        axes = add_axes(figure, 13, 26, 170, 62)
        _projection(axes, results, ("x", "y"), lowest, against)
    against.bar(add_axes(figure, 13, 10, 170, 2.5))
    return figure


def _projection(
    axes: Axes, results: xr.Dataset, plane: tuple[str, str], lowest: Array, against: Against
) -> None:
    """Draw paths as seen across a plane, with the field's boundary behind them."""
    _draw_boundary(axes, results, plane)
    across, up = (MM * results[name].to_numpy() for name in plane)
    segments, colors = [], []
    near = results["near_singularity"].to_numpy() > 0
    for row in _drawn_rows(results):
        points = np.stack([across[row], up[row]], axis=-1)
        keep = np.unique(np.linspace(0, len(points) - 1, SPARSE).astype(int))
        if near[row]:
            axes.plot(*points[keep].T, color=GREY, linewidth=1.1, linestyle=":")
            continue
        pieces = np.stack([points[keep][:-1], points[keep][1:]], axis=1)
        segments.append(pieces)
        colors.append(np.minimum.reduceat(lowest[row], keep[:-1]))
    if segments:
        lines = LineCollection(
            list(np.concatenate(segments)), cmap=against.colors, norm=against.norm, linewidth=1.1
        )
        lines.set_array(np.concatenate(colors) - against.zero)
        lines.set_rasterized(len(segments) > MOST_CURVES)
        axes.add_collection(lines)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{plane[0]} [mm]")
    axes.set_ylabel(f"{plane[1]} [mm]")
    for feature in features(results):
        axes.annotate(
            str(feature.number),
            (across[feature.row, -1], up[feature.row, -1]),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            color=feature.color,
            fontweight="bold",
        )


def _draw_boundary(axes: Axes, results: xr.Dataset, plane: tuple[str, str]) -> None:
    """Draw the edges of the field: the boundary of a plane, the sharp edges of a body."""
    edges = field_edges(results)
    if edges is None:
        return
    points = MM * results["field_points"].to_numpy()[:, ["xyz".index(name) for name in plane]]
    lines = LineCollection(list(points[edges]), colors=GREY, linewidths=0.6, zorder=0.5)
    axes.add_collection(lines)


def field_edges(results: xr.Dataset) -> Index | None:
    """Return the edges (m, 2) of the field to draw: a plane's boundary, or a body's sharp ones."""
    if "field_cells" not in results:
        return None
    outer = facets(results["field_cells"].to_numpy())
    if outer.boundary.shape[1] == 2:
        return outer.boundary
    edges, turn, _ = ridges(results["field_points"].to_numpy(), outer)
    return np.asarray(edges[turn < SHARP])


def _ends(axes: Axes, results: xr.Dataset, lowest: Array, against: Against) -> None:
    """Draw where paths end, as seen along the flow, coloured by the lowest on the whole way."""
    across, up = (MM * results[name].to_numpy()[:, -1] for name in ("z", "y"))
    near = results["near_singularity"].to_numpy() > 0
    axes.scatter(across[near], up[near], s=14, facecolors="none", edgecolors=GREY, linewidths=0.6)
    axes.scatter(
        across[~near],
        up[~near],
        c=lowest[~near].min(axis=1) - against.zero,
        cmap=against.colors,
        norm=against.norm,
        s=14,
        edgecolors=INK,
        linewidths=0.3,
    )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("z [mm]")
    axes.set_ylabel("y [mm]")


def path_histories_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    level = results["quantile"].to_numpy()
    share = f"{100 * level[0]:.0f} to {100 * level[-1]:.0f} %"
    lowest = _lowest(results)
    told = "; ".join(
        f"path {feature.number}: down to {number(lowest[feature.row].min(), 3)} MPa"
        for feature in features(results)
    )
    return Words(
        caption=(
            "Pressure along marked paths, above the atmosphere's: the melt's own (black), and the "
            "lowest (brown) and highest (purple) on a fiber's surface, from the bounds over every "
            f"direction (dashed) and for {share} of randomly entering fibers (dark band)."
        ),
        alt=f"Charts over time of pressures on fibers, in the worst orientation, {told}.",
    )


@plate(
    "path-histories",
    "Pressure on fibers along paths",
    section="fibers",
    words=path_histories_words,
    needs="extreme field_notes",
    place=21,
)
def figure_path_histories(results: xr.Dataset) -> Figure:
    """Draw the pressure on fibers over time, for each of the marked paths."""
    marked = features(results)
    figure = new_figure(FULL, 16 + 52 * len(marked))
    for k, feature in enumerate(marked):
        axes = add_axes(figure, 16, 12 + 52 * (len(marked) - 1 - k), 166, 38)
        time = results["time"].to_numpy()[feature.row]
        melt = own(results, feature.row)
        for side, (_, color) in SIDES.items():
            bound = on_fibers(results, f"bound_{side}", feature.row)
            spread = melt[:, None] + MPA * results[f"quantile_{side}"].to_numpy()[feature.row]
            axes.fill_between(time, melt, bound, color=color, alpha=0.12, linewidth=0)
            axes.fill_between(
                time, spread[:, 0], spread[:, -1], color=color, alpha=0.3, linewidth=0
            )
            axes.plot(time, bound, color=color, linewidth=0.5, linestyle=(0, (4, 2)))
        draw_own(axes, results, feature.row)
        axes.grid(axis="y", color=BAND, linewidth=0.4)
        axes.set_xlim(time[0], time[-1])
        axes.set_ylabel("pressure [MPa]")
        letter(axes, f"{'abcde'[k]}  path {feature.number}")
        if feature is marked[-1]:
            axes.set_xlabel("time [s]")
    return figure


def path_extremes_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    steady = regular(results)
    value = MPA * results["extreme"].mean("initial_angle").transpose("streamline", ...)
    places = results["location"].to_numpy().tolist()
    told = []
    for place in places:
        low, high = (
            value.sel(location=place, kind=kind).to_numpy()[steady] for kind in ("min", "max")
        )
        told.append(
            f"{PLACES[place]} the lowest from {ranged(low.min(), low.max())} MPa, the highest from "
            f"{ranged(high.min(), high.max())} MPa"
        )
    error = MPA * float(results["extreme_error"].to_numpy()[steady].max())
    where = ", ".join(PLACES[place] for place in places)
    return Words(
        caption=(
            f"Extremes of the surface pressure less the melt's own {where}, by path, for "
            f"fibers of {initial_angles(results)} (points; mean blue, median dashed). Wide band: "
            "the bounds over every direction, from the mildest to the worst; narrow band: "
            "quantiles of randomly entering fibers. The points' spacing and the gradient's error "
            f"leave {short(error, 2)} MPa at most."
        ),
        alt=(
            f"{2 * len(places)} charts by path of extreme pressures on fibers "
            "less the melt's own: on the mean over the initial angles "
            f"{'; '.join(told)}."
        ),
    )


@plate(
    "path-extremes",
    "Extremes of pressure by path",
    section="fibers",
    words=path_extremes_words,
    needs="extreme field_notes",
    place=22,
)
def figure_path_extremes(results: xr.Dataset) -> Figure:
    """Draw lowest and highest surface pressure less the melt's own by path, at each location."""
    places = results["location"].to_numpy().tolist()
    figure = new_figure(FULL, 12 + 56 * len(places))
    for row, place in enumerate(places):
        for k, kind in enumerate(("min", "max")):
            axes = add_axes(figure, 15 + 95 * k, 10 + 56 * (len(places) - 1 - row), 78, 43)
            draw_spread(axes, results, place, kind)
            letter(axes, f"{'abcdef'[2 * row + k]}  {('lowest', 'highest')[k]} {PLACES[place]}")
            if k == 0:
                axes.set_ylabel("less the melt's own [MPa]")
                if row == 0:
                    key_above(axes, spread_key(results), 1.14, columns=6, between=1.1)
    return figure
