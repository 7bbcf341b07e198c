"""Which streamlines of a bead are marked: for figures, and for what is solved on one of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["MOST_MARKED", "marked", "middle_marked"]

FEATURES, PAPER_COUNT = (4, 10, 18), 22
"""The paper's feature streamlines, and of how many."""

MOST_MARKED = 5
"""No more are marked than there are colours to tell them apart."""


def marked(
    numbers: NDArray[np.int_],
    fraction: NDArray[np.float64],
    asked: Sequence[int],
    *,
    given: bool = False,
) -> list[int]:
    """Return the places of the marked streamlines, those asked for that exist.

    If none does, or of a flow from elsewhere some do not, the paper's 4, 10 and 18 of 22, or those
    of another number of streamlines that share the flux most nearly as these do. Beyond five, the
    first five.

    Parameters
    ----------
    numbers : (n,) integer array
        Numbers of the streamlines.
    fraction : (n,) array
        Share of the flux upstream of each [-].
    asked : sequence of int
        Numbers that the study names.
    given : bool
        Whether the flow was not solved here.
    """
    known = numbers.tolist()
    rows = [known.index(number) for number in dict.fromkeys(asked) if number in known]
    if not rows or (given and len(rows) < len(asked)):
        shares = [(number - 0.5) / PAPER_COUNT for number in FEATURES]
        rows = [int(np.argmin(np.abs(fraction - share))) for share in shares]
    return sorted(list(dict.fromkeys(rows))[:MOST_MARKED])


def middle_marked(
    numbers: NDArray[np.int_], fraction: NDArray[np.float64], asked: Sequence[int]
) -> int:
    """Return the place of the marked streamline nearest to the middle of the flux."""
    rows = marked(numbers, fraction, asked)
    return min(rows, key=lambda row: abs(float(fraction[row]) - 0.5))
