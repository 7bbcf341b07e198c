"""The extremes of pressure on fibers by streamline (the paper's Fig. 18)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from fibermelt.parts.bead.figures.spread import draw_spread, extreme_of, spread_key, spread_limits
from fibermelt.parts.flow.figures.lines import against_paper, at_corners, initial_angles, regular
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MPA
from fibermelt.report.kit.style import FULL, Words, add_axes, key_above, letter, new_figure
from fibermelt.report.kit.tables import number, ranged

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["EXTREMES", "figure_extremes"]

EXTREMES = (
    ("lowest at Loc. 1", 1, "min"),
    ("lowest at Loc. 2", 2, "min"),
    ("highest at Loc. 1", 1, "max"),
    ("highest at Loc. 2", 2, "max"),
)
"""The paper's four panels: what they show, the location, the kind."""


def extremes_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    near = at_corners(
        results,
        "Diamonds, left out of lines and scales: streamlines",
        ", near a sharp corner, whose values depend on the mesh; what is off the scale is told "
        "as a number.",
    )
    value = MPA * extreme_of(results, "extreme", 2, "min", "initial_angle")
    width = np.where(regular(results), np.ptp(value, axis=1), -1.0)
    widest = int(np.argmax(width))
    at = int(results["streamline"][widest])
    beside = against_paper(
        results,
        "The paper's text has means of −0.5 MPa in (a), nearly uniform, and of −0.8 MPa at the "
        "upstream edge to −0.1 MPa at the other in (b); here they run over "
        f"{_range(results, 1, 'min')} and {_range(results, 2, 'min')}.",
    )
    return Words(
        caption=(
            f"Fig. 18 of the paper: extremes of the surface pressure less the melt's own, by "
            f"streamline, for fibers of {initial_angles(results)} (points; mean blue, median "
            "dashed), before the capillary (Loc. 1) and in the swell (Loc. 2). Wide band: "
            "the exact bounds over every direction, from the mildest to the worst. Narrow band: "
            f"quantiles of randomly entering fibers.{near}{_beyond(results)}{beside}"
        ),
        alt=(
            "Four charts by streamline. Away from sharp corners the mean over the initial "
            f"angles runs over {_range(results, 1, 'min')} for the lowest pressure at Loc. 1, "
            f"{_range(results, 2, 'min')} at Loc. 2, {_range(results, 1, 'max')} for the highest "
            f"at Loc. 1 and {_range(results, 2, 'max')} at Loc. 2. At Loc. 2 the initial angle "
            f"matters most on streamline {at}, where lowest pressures differ by "
            f"{number(np.ptp(value[widest]), 3)} MPa."
        ),
    )


@plate(
    "extremes",
    "Extremes of pressure by streamline",
    section="fibers",
    words=extremes_words,
    needs="extreme node_x",
    paper="Fig. 18",
)
def figure_extremes(results: xr.Dataset) -> Figure:
    """Draw lowest and highest surface pressure less the melt's own, at both locations."""
    figure = new_figure(FULL, 121)
    for k, (name, location, kind) in enumerate(EXTREMES):
        axes = add_axes(figure, 13 + 95 * (k % 2), 66 if k < 2 else 10, 80, 43)
        draw_spread(axes, results, location, kind)
        letter(axes, f"{'abcd'[k]}  {name}")
        if k < 2:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
        if k % 2:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel("less the melt's own [MPa]")
        if k == 0:
            key_above(axes, spread_key(results), 1.14, columns=6, between=1.1)
    return figure


def _range(results: xr.Dataset, location: int, kind: str) -> str:
    """Return between which numbers the mean lies on streamlines away from sharp corners."""
    value = MPA * extreme_of(results, "extreme", location, kind, "initial_angle")
    mean = value.mean(axis=1)[regular(results)]
    return f"{ranged(mean.min(), mean.max())} MPa"


def _beyond(results: xr.Dataset) -> str:
    """Return what is told of the bounds that lie beyond the scales, nothing if none does."""
    told = []
    for kind in ("min", "max"):
        bounds = MPA * results["extreme_bounds"].sel(kind=kind).to_numpy()
        farthest = float(bounds.flat[np.argmax(np.abs(bounds))])
        if abs(farthest) > max(abs(end) for end in spread_limits(results, kind)):
            told.append(number(farthest, 3))
    return f" Bounds beyond the scales reach {' and '.join(told)} MPa there." if told else ""
