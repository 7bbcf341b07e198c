"""What the page's moving figure is fed with: bead, streamlines and fibers in whole numbers.

Lengths are in hundredths of a millimetre, times in tenths of a millisecond, pressures in
kilopascals, angles in tenths of a degree: finer than a screen shows, and short to write.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.parts.flow.figures.judged import vapor_above_air
from fibermelt.parts.flow.figures.lines import evenly, features
from fibermelt.report.kit.drawing import METAL_THICKNESS
from fibermelt.report.kit.scene import MPA, Scene, Window, read_scene
from fibermelt.report.kit.style import Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["NEEDS", "bead_data"]

NEEDS = frozenset({"zone_angle", "node_x"})
"""Variables that only results of fibers in the bead have together."""

LENGTH, TIME, PRESSURE, ANGLE = 1e5, 1e4, 1e-3, 1800.0 / np.pi
"""From SI to the page's whole numbers."""

MOST_LINES, MOST_ANGLES, MOST_POINTS = 30, 13, 120
"""Streamlines, initial angles and points that are shown of however many there are."""

EXACT = 0.01
"""Largest distance [mm] of the shown outline from the stored one: less than a dot."""


def bead_data(results: xr.Dataset) -> str:
    """Return JSON for the moving figure, safe inside a script element.

    Parameters
    ----------
    results : xarray.Dataset
        Results with fibers in the bead.

    Returns
    -------
    str
        Streamlines with, for each point that is kept, place, time, pressure of the melt, bounds
        over every orientation, direction of the flow, and for each initial angle the fiber's
        angle and its lowest and highest pressure less the melt's. Points are dense where
        something changes, and hold every fiber's lowest pressure. ``vapor`` is the vapor pressure
        of the moisture in the melt, null where the study has none.
    """
    scene = read_scene(results)
    starts = evenly(results.sizes["initial_angle"], MOST_ANGLES)
    marked = {feature.row: feature for feature in features(results)}
    rows = sorted({*evenly(results.sizes["streamline"], MOST_LINES), *marked})
    colors = {feature.number: k for k, feature in enumerate(marked.values())}
    vapor = vapor_above_air(results)
    data = {
        "scene": _scene(scene),
        "vapor": None if vapor is None else round(PRESSURE / MPA * vapor),
        "ratio": float(results["aspect_ratio"]),
        "starts": [_start(results, k) for k in starts],
        "marked": colors,
        "lines": [_line(results, row, starts) for row in rows],
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


def _line(results: xr.Dataset, row: int, starts: list[int]) -> dict[str, Any]:
    """Return one streamline and the fibers on it."""
    keep = _points(results, row)
    path = {name: results[name].to_numpy()[row, keep] for name in ("time", "x", "y", "pressure")}
    velocity = [results[name].to_numpy()[row, keep] for name in "uv"]
    fibers = {
        name: results[name].to_numpy()[row][starts][:, keep]
        for name in ("angle", "lowest", "highest")
    }
    return {
        "n": int(results["streamline"][row]),
        "near": bool(results["near_singularity"][row]),
        "t": _whole(path["time"], TIME),
        "x": _whole(path["x"], LENGTH),
        "y": _whole(path["y"], LENGTH),
        "p": _whole(path["pressure"], PRESSURE),
        "d": _whole(np.arctan2(velocity[1], velocity[0]), ANGLE),
        "low": _whole(results["bound_lowest"].to_numpy()[row, keep], PRESSURE),
        "high": _whole(results["bound_highest"].to_numpy()[row, keep], PRESSURE),
        "zones": _whole(results["zone_time"].to_numpy()[row], TIME),
        "fibers": [
            {
                "a": _whole(fibers["angle"][k], ANGLE),
                "low": _whole(fibers["lowest"][k], PRESSURE),
                "high": _whole(fibers["highest"][k], PRESSURE),
            }
            for k in range(len(starts))
        ],
    }


def _points(results: xr.Dataset, row: int) -> list[int]:
    """Return the points to keep: evenly by what changes, and each fiber's deepest."""
    changing = [results[name].to_numpy()[row] for name in ("time", "x", "y", "pressure")]
    changing += [results[f"bound_{side}"].to_numpy()[row] for side in ("lowest", "highest")]
    way = np.zeros(len(changing[0]) - 1)
    for values in changing:
        step = np.abs(np.diff(values))
        way += step / max(float(step.sum()), np.finfo(float).tiny)
    total = np.r_[0.0, np.cumsum(way)]
    even = np.searchsorted(total, np.linspace(0.0, total[-1], MOST_POINTS))
    less = results["lowest"].to_numpy()[row]
    # Both are read from the page: less than the melt's own pressure, and less than the air's.
    deepest = [np.argmin(values, axis=-1) for values in (less, less + changing[3])]
    last = len(total) - 1
    return [int(k) for k in np.unique(np.r_[0, np.minimum(even, last), *deepest, last])]


def _scene(scene: Scene) -> dict[str, Any]:
    """Return what is drawn below the streamlines [mm]."""
    thick = METAL_THICKNESS * float(np.ptp(scene.sides["inlet"][:, 0]))
    return {
        "whole": _window(scene.whole),
        "exit": _window(scene.exit),
        "thick": round(thick, 2),
        "sides": {name: _plain(line) for name, line in scene.sides.items()},
    }


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
