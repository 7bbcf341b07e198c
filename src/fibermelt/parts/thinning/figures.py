"""What thinning does to a bead and its fibers, over the index of the power law."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fibermelt.parts.thinning.summary import summarize_thinning
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import (
    BAND,
    BLUE,
    FULL,
    GREY,
    INK,
    ORANGE,
    VERMILION,
    Words,
    add_axes,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import fixed
from fibermelt.units import MPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CAUSES", "MODELS", "figure_thinning", "megapascals", "models_of"]

ROOM = 1.1
"""Upper end of a scale over the largest value, for its mark."""

CAUSES = {
    "flow": ("the flow alone", BLUE),
    "fiber": ("the fiber's own melt alone", ORANGE),
    "both": ("both", VERMILION),
}
"""What thins: words and colours."""

MODELS: dict[str, tuple[str, Any, str]] = {
    "confined-ellipse": ("ellipse in its cell", "-", "o"),
    "spheroid": ("spheroid in its plane, unbounded", (0, (4, 1.5)), "D"),
}
"""The models: words, dashes and marks."""


def models_of(laws: list[dict[str, Any]]) -> list[str]:
    """Return the models of a fiber that were followed."""
    return [model for model in MODELS if model in laws[0]]


def _at(values: list[float | None]) -> list[float]:
    return [math.nan if value is None else value for value in values]


def thinning_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    laws = summarize_thinning(results)["thinning"]
    first, last = laws[0], laws[-1]
    used = int(results["effect_regular"].sum())
    told = "; ".join(
        f"{MODELS[model][0]} {megapascals(first[model]['both']['lowest'])} to "
        f"{megapascals(last[model]['both']['lowest'])} MPa"
        for model in models_of(laws)
    )
    return Words(
        caption=(
            "Power laws that have the same viscosity at one rate, index 1 the Newtonian melt. (a) "
            "Lowest pressure on a fiber in the swell (zone 2 to 3), absolute, mean over the "
            f"initial angles and over {used} of {results.sizes['streamline']} streamlines, those "
            "that pass no sharp corner in any of the flows: where the flow thins and the fiber "
            "is one in a Newtonian melt of the local viscosity, where the flow is the Newtonian "
            "one and the fiber's own melt thins, and where both do. (b) Largest pressure on a "
            "fiber over a turn in simple shear, over viscosity and rate. (c) Pressure at the inlet."
        ),
        alt=(
            "Three panels over the index of a power law, from 1 to "
            f"{last['index']:g}. Lowest pressures on fibers, absolute, as the melt thins: {told}. "
            "The pressure in simple shear falls, that at the inlet goes from "
            f"{megapascals(first['inlet_pressure'])} to {megapascals(last['inlet_pressure'])} MPa."
        ).replace("-", "−"),
    )


@plate(
    "thinning",
    "What thinning does",
    section="thinning",
    words=thinning_words,
    needs="effect_index",
    place=1,
)
def figure_thinning(results: xr.Dataset) -> Figure:
    """Draw pressures on fibers below the nozzle and in simple shear, and the inlet's, by index."""
    laws = summarize_thinning(results)["thinning"]
    figure = new_figure(FULL, 92)
    local = add_axes(figure, 16, 12, 78, 58)
    peak = add_axes(figure, 112, 46, 72, 24)
    flow = add_axes(figure, 112, 12, 72, 24)
    _local(local, laws)
    _peak(peak, laws)
    _flow(flow, laws)
    letter(local, "a  lowest on a fiber below the nozzle, mean")
    letter(peak, "b  largest pressure in simple shear over ηγ̇")
    letter(flow, "c  pressure at the inlet")
    models = models_of(laws)
    key = [Line2D([], [], color=color, label=f"thins: {name}") for name, color in CAUSES.values()]
    key += [
        Line2D([], [], color=INK, linestyle=dashes, marker=mark, markersize=3.5, label=name)
        for name, dashes, mark in (MODELS[model] for model in models)
    ]
    local.legend(
        handles=key, loc="lower left", bbox_to_anchor=(0.0, 1.1), ncols=3, columnspacing=1.4
    )
    return figure


def _axis(axes: Axes, laws: list[dict[str, Any]]) -> list[float]:
    """Label the axis of the index, the Newtonian melt on the left, and return the indices."""
    index = [law["index"] for law in laws]
    axes.set_xlim(1.0 + 0.02, index[-1] - 0.02)
    axes.grid(axis="y", color=BAND, linewidth=0.4)
    return index


def _local(axes: Axes, laws: list[dict[str, Any]]) -> None:
    index = _axis(axes, laws)
    for model in models_of(laws):
        _, dashes, mark = MODELS[model]
        for cause, (_, color) in CAUSES.items():
            lowest = MPA * np.array(_at([law[model][cause]["lowest"] for law in laws]))
            axes.plot(index, lowest, color=color, linestyle=dashes, marker=mark, markersize=3.5)
    axes.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
    axes.set_ylabel("absolute pressure [MPa]")
    axes.set_xlabel("index of the power law")


def _peak(axes: Axes, laws: list[dict[str, Any]]) -> None:
    index = _axis(axes, laws)
    for model in models_of(laws):
        _, dashes, mark = MODELS[model]
        peak = [law[model]["peak"] for law in laws]
        axes.plot(index, peak, color=INK, linestyle=dashes, marker=mark, markersize=3.5)
    axes.set_ylim(0.0, ROOM * max(law[model]["peak"] for model in models_of(laws) for law in laws))
    axes.tick_params(labelbottom=False)


def _flow(axes: Axes, laws: list[dict[str, Any]]) -> None:
    index = _axis(axes, laws)
    inlet = [MPA * law["inlet_pressure"] for law in laws]
    axes.plot(index, inlet, color=INK, marker="s", markersize=3.5)
    axes.set_ylim(0.0, ROOM * max(inlet))
    axes.set_ylabel("[MPa]")
    axes.set_xlabel("index of the power law")


def megapascals(value: float | None) -> str:
    """Return a pressure [Pa] in megapascals; that there is none, where there is none."""
    return "none" if value is None else fixed(MPA * value, 3)
