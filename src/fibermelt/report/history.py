"""The pressure that fibers make on their surfaces on the way along a streamline (Fig. 16)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fibermelt.report.lines import ZONES, Feature, features, initial_angles
from fibermelt.report.style import (
    FULL,
    GREY,
    HIGH,
    INK,
    LOW,
    Array,
    Words,
    add_axes,
    new_figure,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_history", "history_words"]

MPA = 1e-6
"""Megapascals in a pascal."""

EDGE = 0.05
"""Part of the time scale near its ends where a centred name would stand out of the figure."""

MARKS = ("o", "v")
"""Marks of the extremes at Loc. 1 and Loc. 2."""

QUIET = 0.02
"""The time scale begins where the bounds first reach this part of their largest value."""


def _feature(results: xr.Dataset) -> Feature:
    """Return the marked streamline nearest to the middle of the flux (the paper's 10)."""
    fraction = results["flux_fraction"].to_numpy()
    return min(features(results), key=lambda f: abs(fraction[f.row] - 0.5))


@styled
def figure_history(results: xr.Dataset) -> Figure:
    """Draw lowest and highest surface pressure over time on the paper's streamline 10."""
    feature = _feature(results)
    row = feature.row
    figure = new_figure(FULL, 112)
    axes = add_axes(figure, 13, 9, 174, 82)
    _bands(axes, results, row)
    _fibers(axes, results, row)
    axes.axhline(0.0, color=INK, linewidth=0.6, zorder=1.5)
    _window(axes, results, row)
    _zones(axes, results, row)
    _locations(axes, results, row)
    axes.set_xlabel("time since the inlet [s]")
    axes.set_ylabel("pressure above the atmosphere's [MPa]")
    axes.annotate(
        f"streamline {feature.number}",
        (0.0, 0.0),
        xycoords="axes fraction",
        xytext=(5, 5),
        textcoords="offset points",
        color=feature.color,
        fontweight="bold",
    )
    axes.legend(
        handles=_key(results),
        loc="lower left",
        bbox_to_anchor=(0.0, 1.09),
        ncols=3,
        columnspacing=2.0,
    )
    return figure


def _line(results: xr.Dataset, name: str, row: int) -> Array:
    values: Array = MPA * results[name].to_numpy()[row]
    return values


def _bands(axes: Axes, results: xr.Dataset, row: int) -> None:
    """Draw the streamline's pressure, the bounds over every orientation and the quantiles."""
    time = results["time"].to_numpy()[row]
    own = _line(results, "pressure", row)
    for side, color in (("lowest", LOW), ("highest", HIGH)):
        bound = own + _line(results, f"bound_{side}", row)
        spread = own[:, None] + _line(results, f"quantile_{side}", row)
        axes.fill_between(time, own, bound, color=color, alpha=0.10, linewidth=0, zorder=1)
        axes.plot(time, bound, color=color, linewidth=0.5, linestyle=(0, (4, 2)), zorder=1.2)
        axes.fill_between(
            time, spread[:, 0], spread[:, -1], color=color, alpha=0.28, linewidth=0, zorder=1.3
        )
    axes.plot(time, own, color=INK, linewidth=1.4, zorder=3)


def _fibers(axes: Axes, results: xr.Dataset, row: int) -> None:
    """Draw one line for each initial angle."""
    time, own = results["time"].to_numpy()[row], _line(results, "pressure", row)
    for side, color in (("lowest", LOW), ("highest", HIGH)):
        for fiber in _line(results, side, row):
            axes.plot(time, own + fiber, color=color, linewidth=0.55, zorder=2)


def _window(axes: Axes, results: xr.Dataset, row: int) -> None:
    """Set the scales: from where something happens to where nothing does, zones included."""
    time, own = results["time"].to_numpy()[row], _line(results, "pressure", row)
    low = own + _line(results, "bound_lowest", row)
    high = own + _line(results, "bound_highest", row)
    zones = results["zone_time"].to_numpy()[row]
    loud = time[np.flatnonzero(high - low > QUIET * float((high - low).max()))]
    first, last = min(loud[0], zones[0]), max(loud[-1], zones[-1])
    margin = 0.03 * float(last - first)
    axes.set_xlim(max(0.0, first - margin), min(time[-1], last + margin))
    room = 0.05 * float(high.max() - low.min())
    axes.set_ylim(low.min() - room, high.max() + room)


def _zones(axes: Axes, results: xr.Dataset, row: int) -> None:
    """Mark the zones, and the middle of the capillary between Loc. 1 and Loc. 2."""
    first, last = axes.get_xlim()
    for zone, when in enumerate(results["zone_time"].to_numpy()[row]):
        place = (when - first) / (last - first)
        axes.axvline(when, color=GREY, linewidth=0.6, linestyle=(0, (2.5, 1.5)), zorder=0.9)
        axes.annotate(
            f"zone {zone + 1}\n{ZONES[zone]}",
            (when, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 1),
            textcoords="offset points",
            ha="left" if place < EDGE else "right" if place > 1.0 - EDGE else "center",
            va="bottom",
            fontsize=6.5,
        )


def _locations(axes: Axes, results: xr.Dataset, row: int) -> None:
    """Mark the extremes of each fiber at Loc. 1 and Loc. 2, and name the deepest."""
    for kind, color in (("min", LOW), ("max", HIGH)):
        found = results.isel(streamline=row).sel(kind=kind)
        when = found["extreme_time"].transpose("initial_angle", "location").to_numpy()
        value = MPA * found["extreme_pressure"].transpose("initial_angle", "location").to_numpy()
        for k in range(when.shape[1]):
            axes.plot(
                when[:, k],
                value[:, k],
                linestyle="none",
                marker=MARKS[k],
                markersize=4,
                markerfacecolor="white",
                markeredgecolor=color,
                markeredgewidth=0.8,
                zorder=4,
            )


def _key(results: xr.Dataset) -> list[Line2D | Patch]:
    """Return what lines, bands and marks mean."""
    level = results["quantile"].to_numpy()
    share = f"{100 * level[0]:.0f} to {100 * level[-1]:.0f} %"
    fibers = f"on fibers of {initial_angles(results)}"
    found = [
        Line2D([], [], linestyle="none", marker=mark, color=GREY, mfc="white", label=label)
        for mark, label in zip(
            MARKS,
            (
                "extremes at Loc. 1, above mid-capillary",
                "extremes at Loc. 2, below mid-capillary",
            ),
            strict=True,
        )
    ]
    return [
        Line2D([], [], color=INK, linewidth=1.4, label="melt's own pressure"),
        Line2D([], [], color=LOW, linewidth=0.8, label=f"lowest {fibers}"),
        Line2D([], [], color=HIGH, linewidth=0.8, label=f"highest {fibers}"),
        Patch(facecolor=GREY, alpha=0.25, label="bound over every orientation"),
        Patch(facecolor=GREY, alpha=0.6, label=f"{share} of isotropic fibers"),
        *found,
    ]


def history_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_history`."""
    feature = _feature(results)
    time, own = (results[n].to_numpy()[feature.row] for n in ("time", "pressure"))
    lowest = MPA * (own + results["lowest"].to_numpy()[feature.row])
    bound = MPA * (own + results["bound_lowest"].to_numpy()[feature.row])
    angle, at = np.unravel_index(np.argmin(lowest), lowest.shape)
    start = np.degrees(results["initial_angle"].to_numpy()[angle])
    return Words(
        caption=(
            f"Pressure on fibers along streamline {feature.number}, against the atmosphere: the "
            "melt's own, and lowest and highest on the surface of fibers of all initial angles. "
            "Light bands, dashed at their ends: bounds over every orientation, reached by the "
            "worst one there and then. Dark bands: quantiles of an isotropic start. Marks: each "
            "fiber's extremes against the melt's own pressure above the middle of the capillary "
            "(Loc. 1) and below it (Loc. 2). The time scale leaves out the quiet ends."
        ),
        alt=(
            f"Curves over time on streamline {feature.number}. The melt's own pressure falls from "
            f"{MPA * own[0]:.2f} MPa to {round(MPA * own[-1], 2) + 0.0:.2f} MPa. "
            "Pressures on the fibers spread around it, most before the capillary's entrance and "
            "behind the nozzle's exit. The "
            f"lowest is {lowest.min():.2f} MPa at {time[at]:.3f} s, on the fiber that entered at "
            f"{start:.0f} degrees; no orientation gives less than {bound.min():.2f} MPa."
        ),
    )
