"""Numbers along axes: each whole, none to be added to another, and as many as have room."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from fibermelt.report.kit.tables import short

__all__ = ["LABEL", "Plain", "Roomy", "plain_numbers"]

SMALLEST, LARGEST = 1e-3, 1e6
"""Of the largest number of an axis: beyond, each is written with a power of its own."""

LABEL = 7.0
"""Size of the numbers [points]."""

DIGIT, BETWEEN = 0.64, 0.8
"""Width of a digit of DejaVu Sans, and what stays free between two numbers, in ems."""

MOST = 9
"""Steps along an axis at most, as matplotlib has."""


class Plain(ScalarFormatter):
    """Writes whole numbers, where matplotlib's own puts what they share over the next chart."""

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(b=False)

    def format_ticks(self, values: list[float]) -> list[str]:
        """Return the texts of the ticks."""
        largest = max(map(abs, values), default=0.0)
        if largest and not SMALLEST <= largest < LARGEST:
            return [short(value, 3) for value in values]
        return super().format_ticks(values)


class Roomy(MaxNLocator):
    """Sets ticks along x in round steps, so few that their numbers do not run together.

    Parameters
    ----------
    most : int
        Steps at most.
    beyond : float
        How far a number may reach beyond the ends of the axis [points].
    """

    def __init__(self, most: int = MOST, beyond: float = np.inf) -> None:
        super().__init__(nbins=most, steps=[1, 2, 2.5, 5, 10])
        self.most, self.beyond = most, beyond

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the places of the ticks."""
        for steps in range(self.most, 0, -1):
            self.set_params(nbins=steps)
            found = np.asarray(super().tick_values(vmin, vmax))
            if not isinstance(self.axis, Axis) or found.size < 2:
                return found
            box, low, high = self.axis.axes.get_window_extent(), *sorted((vmin, vmax))
            points = 72.0 * box.width / self.axis.axes.figure.dpi / (high - low)
            shown = [float(place) for place in found if low <= place <= high]
            texts = self.axis.get_major_formatter().format_ticks(shown)
            wide = DIGIT * LABEL * max(map(len, texts), default=0)
            if points * float(found[1] - found[0]) >= wide + BETWEEN * LABEL:
                break
        inset = max(0.0, 0.5 * wide - self.beyond) / points
        return found[(found >= low + inset) & (found <= high - inset)] if inset else found


def plain_numbers(axes: Axes) -> None:
    """Have both axes of a chart tell whole numbers, without an offset beside them."""
    axes.xaxis.set_major_formatter(Plain())
    axes.yaxis.set_major_formatter(Plain())
