"""What the page's moving figure is fed with: paths and fibers in whole numbers, what is around.

Any paths will do: streamlines in a bead, or those of a flow from elsewhere, in a plane or in space.

Lengths are in hundredths of a millimetre, times in tenths of a millisecond, pressures in
kilopascals, angles in tenths of a degree: finer than a screen shows, and short to write. What is
smaller than a bead is told in steps that are as much finer.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from fibermelt.parts.bead.figures.paths import field_edges
from fibermelt.parts.flow.figures.judged import vapor_above_air
from fibermelt.parts.flow.figures.lines import evenly, features, line_word
from fibermelt.report.kit.drawing import METAL_THICKNESS
from fibermelt.report.kit.scene import MM, Window, read_scene
from fibermelt.report.kit.style import Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Moving", "moving_data", "moving_figure"]

NEEDS = frozenset({"lowest", "bound_lowest", "near_singularity"})
"""Variables that results of fibers along paths have."""

STEPS = {"length": 1e-5, "time": 1e-4, "pressure": 1e3}
"""What a whole number of the page stands for, at most [SI]."""

FEWEST_STEPS = 500
"""Steps of the largest length, time and pressure, at least."""

ANGLE = 1800.0 / np.pi
"""From radians to the page's whole numbers."""

MOST_LINES, MOST_ANGLES, MOST_POINTS = 30, 13, 120
"""Streamlines, initial angles and points that are shown of however many there are."""

MOST_IN_SPACE = 20
"""Paths in space that are shown: their fibers have two angles."""

MOST_EDGES = 3000
"""Edges around paths that are shown: more of them hide the paths, and take their room."""

EXACT = 0.01
"""Largest distance [mm] of the shown outline from the stored one: less than a dot."""


@dataclass(frozen=True)
class Moving:
    """The moving figure as a page takes it.

    Parameters
    ----------
    section : str
        Name of the section that it stands in.
    line : str
        What a line that fibers are followed along is called.
    views : mapping
        From where or how near it is seen, in words, by name; the first is shown first.
    in_space : bool
        Whether the paths leave the plane, so that the drawing can be turned.
    fibers_in_space : bool
        Whether the fibers do.
    zones : str
        Which zones' times are known, such as "1 to 3".
    data : Markup
        `moving_data`, escaped there.
    """

    section: str
    line: str
    views: Mapping[str, str]
    in_space: bool
    fibers_in_space: bool
    zones: str
    data: Markup


BEAD_VIEWS = {"whole": "whole bead", "exit": "nozzle’s exit"}
SPACE_VIEWS = {"side": "from its side", "above": "from above", "along": "along the x axis"}


def moving_figure(results: xr.Dataset) -> Moving | None:
    """Return the moving figure of results, None of those without fibers along paths."""
    if not NEEDS.issubset(results):
        return None
    in_bead, in_space = "node_x" in results, "z" in results
    return Moving(
        section="bead" if in_bead else "flow",
        line=line_word(results),
        views=BEAD_VIEWS if in_bead else SPACE_VIEWS if in_space else {},
        in_space=in_space,
        fibers_in_space=in_space or "elevation" in results,
        zones=_named(results),
        data=Markup(moving_data(results)),
    )


def _named(results: xr.Dataset) -> str:
    """Return the numbers of the zones that paths reach, in words."""
    if "zone_time" not in results:
        return ""
    first, *_, last = results["zone"].to_numpy().tolist() * 2
    return f"{first} to {last}" if last > first else f"{first}"


def moving_data(results: xr.Dataset) -> str:
    """Return JSON for the moving figure, safe inside a script element.

    Parameters
    ----------
    results : xarray.Dataset
        Results of fibers along paths.

    Returns
    -------
    str
        Paths with, for each point that is kept, place, time, pressure of the melt, bounds
        over every orientation, direction of the flow, and for each initial angle the fiber's
        direction and its lowest and highest pressure less the melt's. Points are dense where
        something changes, and hold every fiber's lowest pressure. ``vapor`` is the vapor pressure
        of the moisture in the melt, null where the study has none. Directions in space have a
        second angle, out of the plane.
    """
    starts = evenly(results.sizes["initial_angle"], MOST_ANGLES)
    marked = {feature.row: feature for feature in features(results)}
    most = MOST_IN_SPACE if "elevation" in results else MOST_LINES
    rows = sorted({*evenly(results.sizes["streamline"], most), *marked})
    colors = {feature.number: k for k, feature in enumerate(marked.values())}
    vapor, steps = vapor_above_air(results), _steps(results)
    data = {
        "scene": _bead(results) if "node_x" in results else _around(results),
        "steps": steps,
        "vapor": None if vapor is None else round(vapor, 6),
        "ratio": float(results["aspect_ratio"]),
        "starts": [_start(results, k) for k in starts],
        "zones": results["zone"].to_numpy().tolist() if "zone_time" in results else [],
        "marked": colors,
        "lines": [_line(results, row, starts, steps) for row in rows],
        "picked": _in_the_middle(results, rows, list(marked)),
    }
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _in_the_middle(results: xr.Dataset, rows: list[int], marked: list[int]) -> int:
    """Return which line is shown first: the marked one nearest to the middle of the flux."""
    fraction = results["flux_fraction"].to_numpy()
    return rows.index(min(marked, key=lambda row: abs(float(fraction[row]) - 0.5)))


def _start(results: xr.Dataset, k: int) -> str:
    """Return how a fiber enters, in words."""
    angle = f"{np.degrees(float(results['initial_angle'][k])):.0f}°"
    if "initial_elevation" in results:
        angle += f", {np.degrees(float(results['initial_elevation'][k])):.0f}° out of the plane"
    return angle.replace("-", "−")


def _whole(values: Array, scale: float) -> list[int]:
    return [int(value) for value in np.rint(scale * values)]


def _steps(results: xr.Dataset) -> dict[str, float]:
    """Return what whole numbers stand for [SI]: powers of ten."""
    of = {"length": "xyz", "time": ("time",), "pressure": ("pressure", "lowest", "highest")}
    found = {}
    for kind, names in of.items():
        largest = max(float(np.abs(results[name]).max()) for name in names if name in results)
        finest = largest / FEWEST_STEPS
        power = 10.0 ** np.floor(np.log10(finest)) if finest > 0.0 else np.inf
        found[kind] = float(min(STEPS[kind], power))
    return found


def _line(
    results: xr.Dataset, row: int, starts: list[int], steps: Mapping[str, float]
) -> dict[str, Any]:
    """Return one path and the fibers on it."""
    keep = _points(results, row)
    length, time, pressure = (1.0 / steps[kind] for kind in ("length", "time", "pressure"))

    def along(name: str, scale: float) -> list[int]:
        return _whole(results[name].to_numpy()[row, keep], scale)

    def of_fibers(name: str, scale: float) -> list[list[int]]:
        return [_whole(one, scale) for one in results[name].to_numpy()[row][starts][:, keep]]

    u, v, *w = (results[name].to_numpy()[row, keep] for name in "uvw" if name in results)
    kinds = {"a": ("angle", ANGLE), "low": ("lowest", pressure), "high": ("highest", pressure)}
    if "elevation" in results:
        kinds["e"] = ("elevation", ANGLE)
    fibers = {kind: of_fibers(*what) for kind, what in kinds.items()}
    line: dict[str, Any] = {
        "n": int(results["streamline"][row]),
        "near": bool(results["near_singularity"][row]),
        "t": along("time", time),
        **{name: along(name, length) for name in "xyz" if name in results},
        "p": along("pressure", pressure),
        "d": _whole(np.arctan2(v, u), ANGLE),
        "low": along("bound_lowest", pressure),
        "high": along("bound_highest", pressure),
        "zones": _whole(results["zone_time"].to_numpy()[row], time)
        if "zone_time" in results
        else [],
        "fibers": [{kind: fibers[kind][k] for kind in kinds} for k in range(len(starts))],
    }
    if w:
        line["de"] = _whole(np.arctan2(w[0], np.hypot(u, v)), ANGLE)
    return line


def _points(results: xr.Dataset, row: int) -> list[int]:
    """Return the points to keep: evenly by what changes, and each fiber's deepest."""
    names = ("time", "pressure", "bound_lowest", "bound_highest", "x", "y", "z")
    changing = [results[name].to_numpy()[row] for name in names if name in results]
    way = np.zeros(len(changing[0]) - 1)
    for values in changing:
        step = np.abs(np.diff(values))
        way += step / max(float(step.sum()), np.finfo(float).tiny)
    total = np.r_[0.0, np.cumsum(way)]
    even = np.searchsorted(total, np.linspace(0.0, total[-1], MOST_POINTS))
    less = results["lowest"].to_numpy()[row]
    # Both are read from the page: less than the melt's own pressure, and less than the air's.
    deepest = [np.argmin(values, axis=-1) for values in (less, less + changing[1])]
    last = len(total) - 1
    return [int(k) for k in np.unique(np.r_[0, np.minimum(even, last), *deepest, last])]


def _bead(results: xr.Dataset) -> dict[str, Any]:
    """Return what is drawn below the streamlines of a bead [mm]."""
    scene = read_scene(results)
    thick = METAL_THICKNESS * float(np.ptp(scene.sides["inlet"][:, 0]))
    return {
        "whole": _window(scene.whole),
        "exit": _window(scene.exit),
        "thick": round(thick, 2),
        "sides": {name: _plain(line) for name, line in scene.sides.items()},
    }


def _around(results: xr.Dataset) -> dict[str, Any]:
    """Return the edges of the field that paths run through [mm], as many as are shown."""
    edges = field_edges(results)
    if edges is None or len(edges) > MOST_EDGES:
        return {"edges": []}
    points = np.round(MM * results["field_points"].to_numpy(), 2) + 0.0
    return {"edges": points[edges].tolist()}


def _window(window: Window) -> list[float]:
    return [round(side, 2) for side in (window.left, window.right, window.bottom, window.top)]


def _plain(line: Array) -> list[list[float]]:
    """Return a line (n, 2) with as few points as show it, to a hundredth of a millimetre."""
    keep = {0, len(line) - 1}
    spans = [(0, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        chord = line[last] - line[first]
        length = max(float(np.hypot(*chord)), np.finfo(float).tiny)
        between = line[first + 1 : last] - line[first]
        away = np.abs(between[:, 0] * chord[1] - between[:, 1] * chord[0]) / length
        if float(away.max()) > EXACT:
            middle = first + 1 + int(np.argmax(away))
            keep.add(middle)
            spans += [(first, middle), (middle, last)]
    return [[round(float(x), 2) + 0.0, round(float(y), 2) + 0.0] for x, y in line[sorted(keep)]]
