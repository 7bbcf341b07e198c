"""What the paper's claims are judged by: numbers, in SI, as functions of the results.

Streamlines that pass close by a singular corner are left out of what fibers see: it has no limit
there as the mesh is refined. The profile in the capillary and the bead downstream have all.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import spearmanr

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = [
    "CENTER",
    "LEFT",
    "RIGHT",
    "Measure",
    "NotStoredError",
    "needing",
    "off_center",
    "paper_line",
    "rank_correlation",
    "regular_lines",
]

LEFT, CENTER, RIGHT = 4, 10, 18
"""The paper's feature streamlines: near the left edge, the center, near the right edge."""

Measure = Callable[["xr.Dataset"], float]
"""From results to a number in SI; `NotStoredError` if they do not have it."""


class NotStoredError(LookupError):
    """The results do not have what a quantity is made of."""


def needing(known: dict[str, Measure], *variables: str, part: str) -> Callable[[Measure], Measure]:
    """Enter a quantity among those known, by its function's name, as claims call it.

    Parameters
    ----------
    known : dict
        The quantities of one subject.
    *variables : str
        What it reads.
    part : str
        Which part of a study has them: without them it is said to be missing.
    """

    def declared(compute: Measure) -> Measure:
        @wraps(compute)
        def checked(results: xr.Dataset) -> float:
            if any(name not in results for name in variables):
                msg = f'the study has no part "{part}"'
                raise NotStoredError(msg)
            return compute(results)

        known[compute.__name__] = checked
        return checked

    return declared


def regular_lines(results: xr.Dataset) -> NDArray[np.bool_]:
    """Return which streamlines pass no singular corner."""
    regular = ~results["near_singularity"].to_numpy().astype(bool)
    if np.count_nonzero(regular) < 3:
        msg = "fewer than three streamlines stay away from the singular corners"
        raise NotStoredError(msg)
    return np.asarray(regular)


def paper_line(results: xr.Dataset, number: int) -> int:
    """Return the place of a streamline of the paper."""
    numbers = results["streamline"].to_numpy().tolist()
    if len(numbers) != 22:
        msg = f"the paper's streamline {number} is one of 22; this study has {len(numbers)}"
        raise NotStoredError(msg)
    return int(numbers.index(number))


def off_center(results: xr.Dataset) -> Array:
    """Return how far each streamline is from the center one, as a share of the flux."""
    return np.asarray(np.abs(results["flux_fraction"].to_numpy() - 0.5))


def rank_correlation(first: Array, second: Array) -> float:
    """Return Spearman's rank correlation."""
    if not np.ptp(first) or not np.ptp(second):
        msg = "the same on all streamlines: there is no trend to judge"
        raise NotStoredError(msg)
    return float(spearmanr(first, second).statistic)
