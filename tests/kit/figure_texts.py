"""The texts that a figure shows, for tests of their size and their place."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from fibermelt.report.kit.style import STYLE


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


def shown(figure: Figure) -> list[tuple[str, Bbox, float]]:
    """Return every text of a figure with the place that it takes and its size [points]."""
    canvas = FigureCanvasAgg(figure)
    with mpl.rc_context(STYLE):
        canvas.draw()
        return [
            (text.get_text(), text.get_window_extent(canvas.get_renderer()), text.get_fontsize())
            for text in texts(figure)
        ]
