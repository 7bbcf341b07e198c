"""What the plane ellipse costs: ellipses against a spheroid, in shear and along streamlines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator

from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import (
    BAND,
    BLUE,
    COLUMN,
    GREY,
    INK,
    VERMILION,
    Words,
    add_axes,
    letter,
    new_figure,
)
from fibermelt.units import MPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_dimensions"]

LOOKS = {
    "confined-ellipse": (INK, "s"),
    "ellipse": (BLUE, "o"),
    "spheroid": (VERMILION, "D"),
}
"""Colour and mark of each model."""

QUIET = 0.02
"""The time scale spans where the deepest bound exceeds this part of its largest value."""

APART = 0.24
"""Distance between the models' marks, over that between the lines of panel c."""


def _names(results: xr.Dataset) -> dict[str, str]:
    cell = f", M = {float(results['dimension_domain_size']):g}"
    return {name: SHAPES[name].label + cell * SHAPES[name].has_cell for name in LOOKS}


def _middle(results: xr.Dataset) -> int:
    """Return the row of the feature streamline in the middle (the paper's 10)."""
    return results.sizes["feature"] // 2


def dimensions_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    table = results["peak_at_ratio"]
    share = (
        table.sel(dimension_model="spheroid") / table.sel(dimension_model="ellipse")
    ).to_numpy()
    ratios = results["ratio"].to_numpy()
    told = ", ".join(f"{s:.2f} at {r:g}" for s, r in zip(share, ratios, strict=True))
    here = results.isel(feature=_middle(results))
    lowest = {
        name: MPA * float(here["feature_extreme"].sel(dimension_model=name).min()) for name in LOOKS
    }
    number, angles = int(here["feature_streamline"]), results.sizes["planar_angle"]
    names = _names(results)
    return Words(
        caption=(
            "What the plane ellipse costs. (a) Highest pressure on a fiber over a turn in simple "
            f"shear; spheroid over unbounded ellipse: {told}. (b) Lowest pressure on the surface "
            f"along streamline {number}, less the streamline's own: over {angles} initial angles "
            "in the plane (continuous), over every orientation (dashed); grey: zones 1 to 3. "
            "(c) Lowest on the whole way, before the capillary (Loc. 1) and from the exit to the "
            "end of the swell (Loc. 2): mean (open) and lowest (filled) over the initial angles, "
            "and the bound over every orientation (bar), by streamline."
        ),
        alt=(
            "Three panels. In simple shear the pressure of the spheroid grows faster with the "
            f"aspect ratio than that of the ellipses. Along streamline {number} the lowest is "
            + ", ".join(f"{lowest[name]:.2f} MPa ({names[name]})" for name in LOOKS)
            + "."
        ),
    )


@plate(
    "dimensions",
    "Two dimensions against three",
    section="two-and-three",
    words=dimensions_words,
    needs="peak_pressure",
    place=1,
)
def figure_dimensions(results: xr.Dataset) -> Figure:
    """Draw peaks in shear, the lowest pressures on the way, and their minima, by model."""
    tall = 4.2 * results.sizes["location"] * results.sizes["feature"] + 4
    figure = new_figure(COLUMN, 123 + tall)
    peaks = add_axes(figure, 13, 73 + tall, 74, 34)
    along = add_axes(figure, 13, 25 + tall, 74, 34)
    minima = add_axes(figure, 24, 10, 63, tall)
    _peaks(peaks, results)
    _along(along, results)
    _minima(minima, results)
    number = int(results["feature_streamline"][_middle(results)])
    letter(peaks, "a  in simple shear")
    letter(along, f"b  along streamline {number}")
    letter(minima, "c  lowest on the way")
    names = _names(results)
    models = [
        Line2D([], [], color=color, marker=mark, markersize=3.5, label=names[name])
        for name, (color, mark) in LOOKS.items()
    ]
    peaks.legend(
        handles=models, loc="lower left", bbox_to_anchor=(0.0, 1.13), ncols=2, columnspacing=1.4
    )
    return figure


def _peaks(axes: Axes, results: xr.Dataset) -> None:
    """Draw the highest pressure in simple shear against the aspect ratio."""
    for name in results["unbounded_model"].to_numpy():
        color, _ = LOOKS[str(name)]
        curve = results["peak_pressure"].sel(unbounded_model=name).to_numpy()
        axes.plot(results["peak_ratio"].to_numpy(), curve, color=color, zorder=2)
    for name, (color, mark) in LOOKS.items():
        values = results["peak_at_ratio"].sel(dimension_model=name).to_numpy()
        joined = "-" if name == "confined-ellipse" else "none"
        axes.plot(
            results["ratio"].to_numpy(),
            values,
            color=color,
            marker=mark,
            markersize=3.5,
            linewidth=0.6,
            linestyle=joined,
            zorder=3,
        )
    axes.set_xlabel(r"aspect ratio $r_e$")
    axes.set_ylabel(r"peak $|p - p_\infty|\,/\,(\mu\dot\gamma)$")
    axes.set_xlim(0.0, None)
    axes.xaxis.set_major_locator(MultipleLocator(5.0))
    axes.set_ylim(0.0, None)
    axes.grid(axis="y", color=BAND, linewidth=0.4)


def _along(axes: Axes, results: xr.Dataset) -> None:
    """Draw bounds over every orientation, and the lowest over the angles in the plane."""
    here = results.isel(feature=_middle(results))
    time = here["feature_time"].to_numpy()
    for name, (color, _) in LOOKS.items():
        one = here.sel(dimension_model=name)
        bound, lowest = (MPA * one[f"feature_{n}"].to_numpy() for n in ("bound", "lowest"))
        axes.plot(time, bound, color=color, linewidth=0.6, linestyle=(0, (3, 1.5)), zorder=2)
        axes.plot(time, lowest, color=color, linewidth=1.1, zorder=3)
    deepest = here["feature_bound"].min(dim="dimension_model").to_numpy()
    loud = time[np.flatnonzero(deepest < QUIET * deepest.min())]
    margin = 0.04 * float(loud[-1] - loud[0])
    axes.set_xlim(max(0.0, loud[0] - margin), min(time[-1], loud[-1] + margin))
    for when in here["feature_zone_time"].to_numpy():
        axes.axvline(float(when), color=GREY, linewidth=0.6, zorder=1)
    axes.set_ylim(None, 0.0)
    axes.grid(axis="y", color=BAND, linewidth=0.4)
    axes.set_xlabel("time since the inlet [s]")
    axes.set_ylabel(r"lowest $p - p_\psi$ [MPa]")


def _minima(axes: Axes, results: xr.Dataset) -> None:
    """Draw for each streamline and location mean and lowest over the angles, and the bound."""
    ticks, labels = [], []
    for f, streamline in enumerate(results["feature_streamline"].to_numpy()):
        for k, location in enumerate(results["location"].to_numpy()):
            line = -float(results.sizes["location"] * f + k)
            ticks.append(line)
            labels.append(f"{streamline}, Loc. {location}" if location else f"{streamline}")
            for m, (name, (color, mark)) in enumerate(LOOKS.items()):
                one = results.isel(feature=f).sel(location=location, dimension_model=name)
                values = MPA * one["feature_extreme"].to_numpy()
                bound = MPA * float(one["feature_extreme_bound"])
                y = line + APART * (1 - m)
                axes.plot([values.mean(), bound], [y, y], color=color, linewidth=0.5, zorder=2)
                axes.plot(bound, y, "|", color=color, markersize=4, zorder=3)
                axes.plot(values.min(), y, mark, color=color, markersize=3.5, zorder=4)
                axes.plot(values.mean(), y, mark, mfc="white", mec=color, markersize=3.5, zorder=4)
    axes.set_yticks(ticks, labels)
    axes.set_ylim(min(ticks) - 0.6, 0.6)
    axes.set_xlim(None, -0.02 * axes.get_xlim()[0])
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="x", color=BAND, linewidth=0.4)
    axes.set_xlabel(r"lowest $p - p_\psi$ [MPa]")
