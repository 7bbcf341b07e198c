"""How fast and how wet: print speeds and moistures that go together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from fibermelt.engine.results import table_of
from fibermelt.parts.flow.config import Flow
from fibermelt.parts.flow.given import is_given
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    PINK,
    Words,
    add_axes,
    new_figure,
)
from fibermelt.report.kit.tables import number, short
from fibermelt.units import MM, PERCENT

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_limits"]

COLORS = (BLUE, ORANGE, PINK)
"""Of the curves: such as tell in a dark scheme, too."""


def _speeds(results: xr.Dataset) -> tuple[float, str]:
    """Return what a factor on all speeds is drawn by, and what the axis is called."""
    if is_given(results):
        return 1.0, "factor on all speeds of the flow"
    bed = MM * table_of(results, "flow", Flow).bed_speed
    return bed, "print speed [mm/s], inlet and bed together"


def limits_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    moisture = results["void_limit_moisture"].to_numpy()
    here = np.array([np.interp(1.0, results["void_limit_speed"], one) for one in moisture])
    wider = [short(float(one)) for one in results["void_limit_wider"]]
    told = ", ".join(
        f"{name} times at {number(PERCENT * at, 2)} %" if at > 0.0 else f"{name} times at none"
        for name, at in zip(wider, here, strict=True)
        if np.isfinite(at)
    )
    return Words(
        caption=(
            f"Print speed and moisture that let a nucleus on a fiber become {wider[0]}, {wider[1]} "
            f"and {wider[2]} times as wide, on average, up to the end of the swell, as long as "
            "moisture lasts; the circle is this study. Below a curve it grows less. By scaling of "
            "the flow, without another one: nozzle, gap and the ratio of the speeds stay."
        ),
        alt=(
            "Curves of moisture against print speed that fall from the moisture at which the melt "
            f"boils at rest. At this study's speed a nucleus becomes {told}."
        ),
    )


@plate(
    "limits",
    "How fast, how dry",
    section="risk",
    words=limits_words,
    needs="void_limit_moisture",
    place=2,
)
def figure_limits(results: xr.Dataset) -> Figure:
    """Draw the moistures over the speeds."""
    figure = new_figure(190.0, 78.0)
    axes = add_axes(figure, 16, 13, 120, 60)
    unit, name = _speeds(results)
    speed = unit * results["void_limit_speed"].to_numpy()
    moisture = PERCENT * results["void_limit_moisture"].to_numpy()
    wider = results["void_limit_wider"].to_numpy()
    for color, factor, curve in zip(COLORS, wider, moisture, strict=True):
        axes.plot(speed, curve, color=color, label=f"{short(float(factor))} times as wide")
    axes.axhline(
        PERCENT * float(results["void_boiling_moisture"]),
        color=GREY,
        linewidth=0.9,
        linestyle=(0, (4, 2)),
        label="boils at rest",
    )
    axes.plot(unit, PERCENT * float(results["void_moisture"]), "o", color=INK, fillstyle="none",
              label="this study")  # fmt: skip
    axes.set_xlim(speed[0], speed[-1])
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(name)
    axes.set_ylabel("moisture [%]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    return figure
