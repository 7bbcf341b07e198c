"""Every figure and its words at any size of nozzle: nothing overlaps, nothing is rounded away."""

from __future__ import annotations

import re
from functools import cache
from itertools import combinations

import pytest
import xarray as xr
from drawn_bead import rescaled, with_voids
from examples_drawn import examples
from figure_texts import shown
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from suspended_fibers import oriented

from fibermelt.report.kit.plates import Plate
from fibermelt.report.page.figures import FIGURES

pytestmark = [pytest.mark.verification, pytest.mark.slow]

CAPILLARY = 3e-3
"""Width of the capillary of the made-up bead [m]."""

PLATES = [
    p
    for p in FIGURES
    if p.needs.split()[0] in {"extreme", "orientation", "void_margin"}
    and not {"field_notes", "strand_cells"} & {*p.needs.split()}
]
"""The figures of the parts bead, orientation and voids."""

NOTHING = re.compile(r"(?<![\d.,])[-−+±]?0(\.0+)? (nm|µm|mm/s|mm|m/s|ms|s|1/s|Pa|kPa|MPa)\b")
"""A quantity of which rounding has left nothing: none of those told here is zero."""


@cache
def bead() -> xr.Dataset:
    return with_voids(oriented())


@pytest.mark.parametrize("plate", PLATES, ids=lambda plate: plate.name)
@given(
    width=st.floats(0.2e-3, 20e-3),
    slower=st.floats(0.05, 20.0),
    stiffer=st.floats(0.05, 20.0),
)
@example(width=0.2e-3, slower=0.05, stiffer=20.0)
@example(width=0.4e-3, slower=1.0, stiffer=1.0)
@example(width=7.6e-3, slower=2.0, stiffer=0.05)
@settings(examples(2), phases=[Phase.explicit, Phase.reuse, Phase.generate])
def test_figures_read_alike_at_every_scale(
    plate: Plate, width: float, slower: float, stiffer: float
) -> None:
    results = rescaled(bead(), width / CAPILLARY, slower, stiffer)
    figure = plate.draw(results)
    boxes = shown(figure)
    for name, box, _ in boxes:
        assert box.x0 >= 0, name
        assert box.y0 >= 0, name
        assert box.x1 <= figure.bbox.width, name
        assert box.y1 <= figure.bbox.height, name
        assert not NOTHING.search(name.replace("$", "")), name
    for (one, first, _), (other, second, _) in combinations(boxes, 2):
        assert not first.overlaps(second), f"{one!r} overlaps {other!r}"
    for axes in figure.axes:
        assert axes.has_data() or axes.get_legend(), "an empty axis"
    words = plate.words(results)
    for text in (words.caption, words.alt):
        assert not NOTHING.search(text), text
        assert "nan" not in text
