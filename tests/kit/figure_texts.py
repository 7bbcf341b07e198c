"""The texts that a figure shows, for tests of their size and their place."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text


def _tick_labels(axes: Axes) -> list[Text]:
    """Tick labels that are drawn: matplotlib keeps those beyond the scale's ends as well."""
    labels = []
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        labels += [t.label1 for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
        labels.append(axis.label)
    return labels


def texts(figure: Figure) -> list[Text]:
    """Return every text that a figure shows."""
    found: list[Text] = []
    for axes in figure.axes:
        found += axes.texts
        if axes.axison:
            found += _tick_labels(axes)
        legend = axes.get_legend()
        if legend is not None:
            found += legend.get_texts()
    return [text for text in found if text.get_visible() and text.get_text().strip()]
