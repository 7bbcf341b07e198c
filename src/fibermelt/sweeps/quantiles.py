"""Quantiles of a population: by number, and with every case weighed.

Of ``n`` values in rising order the ``k``-th stands in the middle of its share: at
``(S_k - w_k / 2) / S_n`` with the sum ``S_k`` of the weights ``w`` up to it, and quantiles between
two values are linear between them. Of equal weights these shares are ``(k - 1/2) / n``, Hazen's
rule, definition 5 of Hyndman and Fan, Am. Stat. 50, 1996, 361-365: the middles of the strata that a
Latin hypercube samples, so that its quantiles of a monotone response err by a stratum at most.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["LEVELS", "quantiles", "shares_below"]

LEVELS = (0.05, 0.5, 0.95)
"""Shares of the cases that lie below the quantiles that are told."""


def shares_below(values: Array, weights: Array | None = None) -> tuple[Array, Array]:
    """Return the values that are there in rising order, and the share at which each stands.

    Parameters
    ----------
    values : (cases,) ndarray
        A response, NaN where there is none.
    weights : (cases,) ndarray, optional
        What each case counts, above 0; all alike if left out.

    Returns
    -------
    values, shares : (n,) ndarray
        The values, and the middle of the share of each [-].
    """
    import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

    there = np.isfinite(values)
    found = values[there]
    order = np.argsort(found, kind="stable")
    counted = np.ones(len(found)) if weights is None else weights[there][order]
    below = np.cumsum(counted)
    # No case, no sum to divide by.
    return found[order], (below - counted / 2) / (below[-1] if below.size else 1.0)


def quantiles(
    values: Array, levels: Sequence[float] = LEVELS, weights: Array | None = None
) -> Array:
    """Return quantiles of a response over the cases that have it; NaN if none has.

    Parameters
    ----------
    values : (cases,) ndarray
        The response, NaN where there is none.
    levels : sequence of float
        Shares that lie below. What is nearer to 0 or 1 than half a case is the smallest or the
        largest value: nothing is extrapolated.
    weights : (cases,) ndarray, optional
        What each case counts, above 0; all alike if left out.
    """
    import numpy as np  # noqa: PLC0415  lazy: see above

    found, shares = shares_below(values, weights)
    if found.size == 0:
        return np.full(len(levels), np.nan)
    return np.interp(levels, shares, found)
