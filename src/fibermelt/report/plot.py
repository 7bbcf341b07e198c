"""Figures of results in Python: each function draws one and returns its axes.

Figures are the page's, made known to pyplot: a notebook shows them, ``matplotlib.pyplot.show()``
does elsewhere, and ``axes[0].figure.savefig("bead.pdf")`` writes one.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from fibermelt.errors import ConfigError, legible
from fibermelt.parts.bead.figures.spread import draw_spread
from fibermelt.report.page.figures import FIGURES

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "along",
    "extremes",
    "figure",
    "history",
    "maps",
    "names",
    "orientation",
    "overview",
    "positions",
    "profiles",
    "spread",
    "streamlines",
    "voids",
]


def names(results: xr.Dataset) -> list[str]:
    """Return the names of all figures that results are enough for."""
    return [plate.name for plate in FIGURES if plate.is_of(results)]


def figure(results: xr.Dataset, name: str) -> tuple[Axes, ...]:
    """Draw a figure of the page and return its axes.

    Parameters
    ----------
    results : xarray.Dataset
        Results of a run.
    name : str
        One of `names`.

    Raises
    ------
    ConfigError
        If there is no such figure, or the results are not enough for it.
    """
    plate = next((one for one in FIGURES if one.name == name), None)
    if plate is None:
        known = ", ".join(one.name for one in FIGURES)
        msg = f'plot: there is no figure "{legible(str(name))}"; there are: {known}'
        raise ConfigError(msg)
    if not plate.is_of(results):
        missing = next(needed for needed in plate.needs.split() if needed not in results)
        msg = (
            f'plot: the figure "{name}" needs the variable {missing}, which these results have '
            "not: run the study with the part that gives it (study.parts)"
        )
        raise ConfigError(msg)
    drawn = plate.draw(results)
    # pyplot takes a figure that is there for the new one that it asks for, and gives it a canvas.
    plt.figure(FigureClass=lambda **_: drawn, dpi=drawn.dpi)  # type: ignore[arg-type]
    return tuple(drawn.axes)


def overview(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw the bead at a glance: the lowest pressure on fibers, over the bead and by streamline."""
    return figure(results, "overview")


def streamlines(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw the streamlines, as the paper's Fig. 2b."""
    return figure(results, "streamlines")


def maps(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw speed, rate of deformation and pressure over the melt."""
    return figure(results, "maps")


def history(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw the pressure on a fiber along a streamline, as the paper's Fig. 16."""
    return figure(results, "history")


def profiles(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw pressure and orientation over time, as the paper's Fig. 17."""
    return figure(results, "profiles")


def extremes(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw the extremes of pressure by streamline, as the paper's Fig. 18."""
    return figure(results, "extremes")


def positions(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw where the extremes lie, as the paper's Fig. 19."""
    return figure(results, "positions")


def orientation(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw the orientation tensor over the bead, of a study with the part "orientation"."""
    return figure(results, "orientation")


def voids(results: xr.Dataset) -> tuple[Axes, ...]:
    """Draw where voids can start, of a study with the part "voids"."""
    return figure(results, "voids")


def spread(
    results: xr.Dataset, location: int = 1, kind: str = "min", axes: Axes | None = None
) -> Axes:
    """Draw one extreme of the pressure by streamline, over all initial angles.

    Parameters
    ----------
    results : xarray.Dataset
        Results of a run with fibers.
    location : {0, 1, 2}
        The whole way, before the capillary, or from the exit to the end of the swell.
    kind : {"min", "max"}
        The lowest or the highest pressure, less the melt's own.
    axes : Axes, optional
        Where to draw it; new ones by default.

    Raises
    ------
    ConfigError
        If there is no such extreme.
    """
    if "extreme" not in results:
        msg = "plot.spread: these results have no extremes of pressure: run the part bead"
        raise ConfigError(msg)
    known = results["location"].to_numpy().tolist()
    if location not in known or kind not in {"min", "max"}:
        msg = (
            f'plot.spread: location = {location}, kind = "{kind}": must be one of '
            f'{", ".join(map(str, known))}, and "min" or "max"'
        )
        raise ConfigError(msg)
    axes = _axes(axes)
    draw_spread(axes, results, location, kind)
    axes.set_ylabel("less the melt's own [MPa]")
    return axes


def along(
    results: xr.Dataset,
    variable: str = "bound_lowest",
    streamlines: Iterable[int] | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a variable along streamlines over time.

    Parameters
    ----------
    results : xarray.Dataset
        Results of a run.
    variable : str
        What is known at the points of streamlines, such as ``"pressure"`` or ``"shear_rate"``.
    streamlines : iterable of int, optional
        Their numbers; all by default.
    axes : Axes, optional
        Where to draw it; new ones by default.

    Raises
    ------
    ConfigError
        If there is no such variable or streamline.
    """
    known = [
        str(name)
        for name, one in results.data_vars.items()
        if set(one.dims) == {"streamline", "point"} and name != "time"
    ]
    if variable not in known:
        msg = f'plot.along: variable = "{variable}": must be one of {", ".join(known) or "none"}'
        raise ConfigError(msg)
    numbers = results["streamline"].to_numpy().tolist()
    chosen = numbers if streamlines is None else list(streamlines)
    if unknown := [number for number in chosen if number not in numbers]:
        msg = f"plot.along: streamline {unknown[0]}: must be from {numbers[0]} to {numbers[-1]}"
        raise ConfigError(msg)
    axes = _axes(axes)
    about = results[variable].attrs
    for number in chosen:
        line = results.sel(streamline=number)
        axes.plot(line["time"], line[variable], label=f"streamline {number}")
    axes.set_xlabel("time since the inlet [s]")
    axes.set_ylabel(f"{about['long_name']} [{about['units']}]")
    if np.size(chosen) <= 10:
        axes.legend()
    return axes


def _axes(axes: Axes | None) -> Axes:
    """Return axes to draw in: those given, or new ones that pyplot knows."""
    return plt.subplots(layout="constrained")[1] if axes is None else axes
