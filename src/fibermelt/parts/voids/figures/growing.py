"""How nuclei at the tips of fibers grow in time, along a few streamlines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from fibermelt.parts.flow.figures.lines import line_word
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import BLUE, GREY, INK, ORANGE, PINK, Words, add_axes, new_figure
from fibermelt.report.kit.tables import number
from fibermelt.units import MS, UM

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

__all__ = ["figure_growing"]

COLORS = (BLUE, ORANGE, PINK)
"""Of the streamlines: such as tell in a dark scheme, too."""


def _drawn(results: xr.Dataset) -> NDArray[np.intp]:
    """Return which streamlines are drawn: the largest, the middle and the smallest bubble's.

    At the end of the swell, mean over the initial angles; of those that pass no sharp corner.
    """
    radius = results["void_radius"].sel(void_station="swell").mean("initial_angle").to_numpy()
    kept = np.flatnonzero((results["near_singularity"].to_numpy() == 0) & np.isfinite(radius))
    order = kept[np.argsort(-radius[kept], kind="stable")]
    chosen = dict.fromkeys(order[[0, order.size // 2, -1]]) if order.size else ()
    return np.array(list(chosen), dtype=np.intp)


def growing_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    drawn = _drawn(results)
    word = line_word(results)
    names = ", ".join(str(int(results["streamline"][k])) for k in drawn)
    swell = results["void_radius"].sel(void_station="swell").to_numpy()
    told = "; ".join(
        f"{number(UM * float(np.median(swell[k])), 2)} µm on {int(results['streamline'][k])}"
        for k in drawn
    )
    return Words(
        caption=(
            f"Radius of a nucleus at a fiber’s tip in time, on {word}s {names}: the largest, "
            "middle and smallest at the end of the swell of those past no sharp corner. A line is "
            "the median of the initial angles, a band all of them; the square is the end of the "
            "swell, after which the pressure is the air’s. The nucleus cannot shrink below its "
            "crevice, dotted; what feeds it is the moisture of its share of the melt."
        ),
        alt=(
            "Curves of radius over time on a logarithmic axis. The median at the end of the swell: "
            f"{told or 'none, as all pass a sharp corner'}."
        ),
    )


@plate(
    "growing",
    "How a bubble grows",
    section="risk",
    words=growing_words,
    needs="void_radius_along",
    place=3,
)
def figure_growing(results: xr.Dataset) -> Figure:
    """Draw radii over time."""
    figure = new_figure(190.0, 78.0)
    axes = add_axes(figure, 16, 13, 120, 60)
    time = results["void_radius_time"].transpose("streamline", "initial_angle", "void_step")
    radius = results["void_radius_along"].transpose("streamline", "initial_angle", "void_step")
    swell = (radius.sizes["void_step"] - 1) // 2
    first = UM * float(radius[0, 0, 0])
    for color, k in zip(COLORS, _drawn(results), strict=False):
        # The steps of each angle are its own: all on those of the first.
        t = time[k].to_numpy()
        grown = np.array(
            [np.interp(t[0], own, np.log(one)) for own, one in zip(t, radius[k], strict=True)]
        )
        low, middle, high = UM * np.exp(np.quantile(grown, (0.0, 0.5, 1.0), axis=0))
        axes.fill_between(MS * t[0], low, high, color=color, alpha=0.2, linewidth=0.0)
        label = f"{line_word(results)} {int(results['streamline'][k])}"
        axes.plot(MS * t[0], middle, color=color, label=label)
        axes.plot(MS * t[0, swell], middle[swell], "s", color=color, markersize=4.0)
    axes.axhline(first, color=GREY, linewidth=0.9, linestyle=(0, (1, 2)), label="its crevice")
    axes.plot([], [], "s", color=INK, markersize=4.0, label="end of the swell")
    axes.set_yscale("log")
    axes.set_xlabel("time from the inlet [ms]")
    axes.set_ylabel("radius [µm]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    return figure
