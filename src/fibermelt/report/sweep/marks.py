"""How the figures of a sweep show what became of a case, and what its error hides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D

from fibermelt.report.kit.style import INK, PALE, key_mark, round_up
from fibermelt.report.kit.tables import number, short

if TYPE_CHECKING:
    from fibermelt.sweeps.responses import Response
    from fibermelt.sweeps.table import SweepTable

__all__ = ["MARKS", "SIZE", "UNDETECTED", "became", "case_mark", "told"]

MARKS = {
    "done": ("o", INK, "computed"),
    "none": ("s", "white", "computed, without this number"),
    "failed": ("X", "white", "failed"),
    "pending": ("o", "white", "not finished"),
}
"""How a case is marked by what became of it: marker, face, and what it says."""

SIZE = 4.5
"""Of the marks [points]."""

UNDETECTED: dict[str, Any] = {
    "facecolor": PALE,
    "edgecolor": INK,
    "hatch": "....",
    "linewidth": 0,
}
"""What its error does not tell from zero."""


def became(table: SweepTable, response: Response, case: int) -> str:
    """Return what became of a case, as `MARKS` has it."""
    status = table.status[case]
    return "none" if status == "done" and not np.isfinite(response.values[case]) else status


def case_mark(name: str) -> Line2D:
    """Return the entry of a key for cases of which one thing became."""
    marker, face, said = MARKS[name]
    return key_mark(marker, said, INK, SIZE, face=face, edge=INK)


def told(response: Response, case: int) -> str:
    """Return the number of a case; of one that is not detected, below what."""
    if response.undetected[case]:
        return f"< {short(round_up(float(response.limit[case])))}"
    return number(float(response.values[case]), 3)
