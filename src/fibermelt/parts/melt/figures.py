"""The melt: its viscosity over the rates of deformation, and which of them this flow has."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np
from matplotlib.figure import Figure

from fibermelt.engine.results import table_of
from fibermelt.parts.bead.summary import melt_met
from fibermelt.parts.melt.config import Melt as MeltTable
from fibermelt.parts.melt.melt import melt_of
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import (
    BLUE,
    FULL,
    GREY,
    INK,
    Array,
    Words,
    add_axes,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import number
from fibermelt.units import PERCENT, ZERO_CELSIUS

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.melt.melt import Melt

__all__ = ["figure_melt"]

PER_DECADE = 8
"""Bars of a decade of rates."""


def _melt(results: xr.Dataset) -> Melt:
    return melt_of(table_of(results, "melt", MeltTable))


def _shares(results: xr.Dataset) -> tuple[Array, Array]:
    """Return edges of bars of rates [1/s] and the melt's time in each, mean by flux [%]."""
    time, rate = (
        results[name].transpose("streamline", "point").to_numpy() for name in ("time", "shear_rate")
    )
    spent = np.diff(time, axis=-1) / (time[:, -1] - time[:, 0])[:, None]
    middle = 0.5 * (rate[:, 1:] + rate[:, :-1])
    # below a thousandth of the usual rate a melt rests: how slow, is the mesh's
    slowest = 1e-3 * np.median(middle)
    low, high = np.floor(np.log10(slowest)), np.ceil(np.log10(middle.max()))
    edges = np.logspace(low, high, int(PER_DECADE * (high - low)) + 1)
    share, _ = np.histogram(np.maximum(middle, edges[0]), edges, weights=spent)
    return edges, PERCENT * share / len(time)


def melt_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    melt, met = _melt(results), melt_met(results)
    lowest, highest = (number(met[name], 3) for name in ("lowest_viscosity", "highest_rate"))
    if melt.rates is None:
        range_ = "Nobody says at which rates the law was measured."
    else:
        share = PERCENT * cast("float", met["outside_law"])
        slow, fast = (number(rate, 3) for rate in melt.rates)
        range_ = (
            f"The law was measured from {slow} to {fast} 1/s: {number(share, 2)} % of the melt's "
            "time, mean by flux, is spent at other rates, where it is extrapolated."
        )
    return Words(
        caption=(
            f"{melt.name} at {melt.temperature - ZERO_CELSIUS:.0f} °C: (a) viscosity against the "
            f"rate of deformation √(2 D:D), {melt.law.called}; (b) share of the time from inlet to "
            "outlet at each rate, mean by flux, in the first bar at that and slower. Away from "
            f"sharp corners the highest rate is {highest} 1/s and the lowest viscosity {lowest} "
            f"Pa s. {range_}"
        ),
        alt=(
            "A falling curve of the viscosity over the rate of deformation, above a histogram of "
            f"the rates that the melt meets, up to {highest} 1/s, where it has {lowest} Pa s."
        ),
    )


@plate("melt", "The melt", section="flow", words=melt_words, needs="law_rate", place=1)
def figure_melt(results: xr.Dataset) -> Figure:
    """Draw the viscosity's law, the rates at which it was measured, and those of this flow."""
    edges, share = _shares(results)
    figure = new_figure(FULL, 92)
    curve = add_axes(figure, 20, 46, 160, 40)
    bars = add_axes(figure, 20, 11, 160, 27)
    rate, viscosity = results["law_rate"].to_numpy(), results["law_viscosity"].to_numpy()
    shown = (rate >= edges[0] * (1 - 1e-9)) & (rate <= edges[-1] * (1 + 1e-9))
    curve.loglog(rate[shown], viscosity[shown], color=INK, linewidth=1.4)
    bars.stairs(share, edges, fill=True, color=BLUE, alpha=0.7)
    bars.set_xscale("log")
    known = _melt(results).rates
    for axes in (curve, bars):
        axes.set_xlim(edges[0], edges[-1])
        if known is not None:
            axes.axvspan(*known, color=GREY, alpha=0.2, linewidth=0, zorder=0)
    curve.set_ylabel("viscosity [Pa s]")
    curve.tick_params(labelbottom=False)
    bars.set_ylabel("share of its time [%]")
    bars.set_xlabel("rate of deformation [1/s]")
    measured = "; grey: the rates that were measured" if known is not None else ""
    letter(curve, f"a  the law of the melt{measured}")
    letter(bars, "b  rates that the melt meets here")
    return figure
