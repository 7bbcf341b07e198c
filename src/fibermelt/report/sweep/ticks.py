"""Numbers along the axes of a sweep's charts, each whole: none is to be added to another."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter

from fibermelt.report.tables import short

__all__ = ["plain_numbers"]

SMALLEST, LARGEST = 1e-3, 1e6
"""Of the largest number of an axis: beyond, each is written with a power of its own."""


class _Plain(ScalarFormatter):
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


def plain_numbers(axes: Axes) -> None:
    """Have both axes of a chart tell whole numbers, without an offset beside them."""
    axes.xaxis.set_major_formatter(_Plain())
    axes.yaxis.set_major_formatter(_Plain())
