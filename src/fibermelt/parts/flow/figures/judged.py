"""What pictures hold pressures against, and which of the melt no verdict is given on.

Red has one meaning in a report: below the vapor pressure of the moisture in the melt, where a
bubble can grow. A study without moisture judges nothing: its pressures stand above the
atmosphere's, on a scale without red, with a line where the two are equal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Normalize
from matplotlib.patches import Patch, PathPatch
from matplotlib.tri import TriAnalyzer, Triangulation
from numpy.typing import NDArray

from fibermelt.parts.flow.figures.carpet import Carpet
from fibermelt.report.kit.drawing import paint
from fibermelt.report.kit.scene import MPA
from fibermelt.report.kit.style import (
    INK,
    JUDGED,
    SEQUENTIAL,
    UNJUDGED,
    Array,
    color_bar,
    key_above,
    round_up,
)
from fibermelt.voids.constants import ATMOSPHERE

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Against", "colors_said", "held_against", "key_of_unjudged", "vapor_above_air"]

FLAT = 0.01
"""Radius of the circle within a triangle over that around it, below which the triangle is flat."""

HALF = 0.5
"""Of what is woven between 1 on streamlines left out and 0 on the others: half of the way."""


def vapor_above_air(results: xr.Dataset) -> float | None:
    """Return the vapor pressure of the melt's moisture above the air's [MPa], None without any."""
    if "void_vapor_pressure" not in results:
        return None
    return MPA * (float(results["void_vapor_pressure"]) - ATMOSPHERE)


@dataclass(frozen=True)
class Against:
    """What pressures of a picture are held against.

    Parameters
    ----------
    zero : float
        What is taken off pressures above the air's [MPa]: the vapor's, or nothing.
    norm : Normalize
        Scale of what is left.
    colors : str
        Its colours.
    label : str
        What it is of, for a colour bar.
    """

    zero: float
    norm: Normalize
    colors: str
    label: str

    def paint(self, axes: Axes, carpet: Carpet, own: Array, left_out: NDArray[np.bool_]) -> None:
        """Paint pressures between streamlines, hatched around those that are left out.

        Parameters
        ----------
        axes : Axes
            Where; the melt is hatched there already.
        carpet : Carpet
            What is painted between the first and the last streamline.
        own : (streamline, point) array
            Pressures above the air's [MPa].
        left_out : (streamline,) array
            Which streamlines are left out: half of the way to the next one goes with them.
        """
        if left_out.all():
            return
        values = carpet.values(own) - self.zero
        share = carpet.values(np.repeat(left_out[:, None], own.shape[1], axis=1).astype(float))
        whole = carpet.triangles
        # Flat triangles between points of one line fold over one another: no area is made of them.
        flat = TriAnalyzer(whole).get_flat_tri_mask(FLAT)
        out = share[whole.triangles] > HALF
        hidden = out.all(axis=1) | (flat & out.any(axis=1))
        shown = Triangulation(whole.x, whole.y, whole.triangles, mask=hidden)
        paint(axes, shown, values, self.norm, self.colors)
        look = {"linewidths": 0.7, "zorder": 1.2}
        seen = values[shown.get_masked_triangles()]
        if seen.min() < 0.0 < seen.max():
            axes.tricontour(shown, values, levels=[0.0], colors=INK, **look)
        if left_out.any():
            full = Triangulation(whole.x, whole.y, whole.triangles, mask=flat)
            area = axes.tricontourf(full, share, levels=[HALF, 2.0])
            for path in area.get_paths():
                axes.add_artist(PathPatch(path, **UNJUDGED, zorder=1.5))
            area.remove()
            # What is painted is in whole dots, and shows along the rim of what covers it.
            lines = (of[: carpet.when.size].reshape(carpet.when.shape) for of in (whole.x, whole.y))
            for left, *line in zip(left_out[carpet.rows], *lines, strict=True):
                if left:
                    axes.plot(*line, color=UNJUDGED["facecolor"], linewidth=1.0, zorder=1.4)

    def bar(self, axes: Axes) -> Colorbar:
        """Draw the colour bar."""
        return color_bar(ScalarMappable(self.norm, self.colors), axes, self.label, extend="both")


def colors_said(results: xr.Dataset, *, line: bool = True) -> str:
    """Return what the colours of a picture, and the line between them, say in its caption."""
    if vapor_above_air(results) is None:
        told, equal = "not judged, as the study has no moisture", "the atmosphere's"
    else:
        told = "red: below the vapor pressure of the melt's moisture, where a bubble can grow"
        equal = "the vapor's"
    return f"{told}; line: equal to {equal}" if line else told


def held_against(results: xr.Dataset, own: Array, what: str) -> Against:
    """Return what pressures are held against: the vapor's where the study has moisture.

    Parameters
    ----------
    results : xarray.Dataset
        The results.
    own : array
        Pressures above the air's that the scale has to hold [MPa].
    what : str
        What they are of, such as "lowest pressure on a fiber".
    """
    vapor = vapor_above_air(results)
    if vapor is not None:
        most = round_up(float(np.abs(own - vapor).max()))
        return Against(
            vapor, Normalize(-most, most), JUDGED, f"{what} less the vapor pressure [MPa]"
        )
    low, high = min(float(own.min()), 0.0), max(float(own.max()), 0.0)
    norm = Normalize(low and -round_up(-low), high and round_up(high))
    return Against(0.0, norm, SEQUENTIAL, f"{what} [MPa], atmosphere = 0")


def key_of_unjudged(axes: Axes, results: xr.Dataset) -> None:
    """Write over a colour bar what hatched melt is."""
    near = bool(results["near_singularity"].to_numpy().any())
    corners = "near sharp corners, and " if near else ""
    patch = Patch(**UNJUDGED, label=f"left out: {corners}beyond the outermost streamlines")
    key_above(axes, [patch], 1.5, columns=1, between=1.0)
