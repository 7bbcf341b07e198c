"""Main effects: how a response of a grid, or of one parameter at a time, follows a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.sweeps.responses import Response
    from fibermelt.sweeps.table import SweepTable, Varied

    Array = NDArray[np.float64]

__all__ = ["effect"]


def effect(table: SweepTable, response: Response, axis: Varied) -> tuple[Array, Array]:
    """Return the main effect of a parameter: values of it, and mean, least and largest response.

    Of a grid the mean is over all other parameters: over those combinations of them of which every
    value of this one has an answer, so that failed cases do not pass for an effect. If there are
    none, it is over those that the most values of this one share, and of these values alone. Where
    no two cases that have an answer differ in this parameter alone, there is no effect to be told.
    One at a time there is one case for each value.

    Parameters
    ----------
    table : SweepTable
        A grid, or one at a time.
    response, axis : Response, Varied
        One of its responses, and of what varied.

    Returns
    -------
    levels : (n,) ndarray
        Values of the parameter, in rising order.
    found : (3, n) ndarray
        Mean, least and largest response; NaN for a value without one to compare.
    """
    import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

    place = table.axes.index(axis)
    if table.groups:
        chosen = list(table.groups[place])
        order = np.argsort(axis.values[chosen], kind="stable")
        values = response.values[chosen][order]
        return axis.values[chosen][order], np.stack([values] * 3)
    grid = np.moveaxis(response.values.reshape(table.shape), place, 0)
    rows = grid.reshape(len(grid), -1)
    shared = _shared(np.isfinite(rows))
    rows = rows[:, np.isfinite(rows[shared]).all(axis=0)]
    at = np.moveaxis(axis.values.reshape(table.shape), place, 0).reshape(len(grid), -1)[:, 0]
    order = np.argsort(at, kind="stable")
    found = np.full((3, len(rows)), np.nan)
    for row in np.flatnonzero(shared[order]):
        values = rows[order[row]]
        found[:, row] = values.mean(), values.min(), values.max()
    return at[order], found


def _shared(known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which values can be compared: the most that have an answer with all else the same.

    Parameters
    ----------
    known : (n, m) array of bool
        Which cases have an answer, by value and by combination of all else.

    Returns
    -------
    (n,) array of bool
        None of them if there are not two to compare; of several such sets the one that the most
        combinations have.
    """
    import numpy as np  # noqa: PLC0415  lazy: see above

    count = known.sum(axis=0)
    if count.max(initial=0) < min(2, len(known)):
        return np.zeros(len(known), dtype=bool)
    sets = np.unique(known[:, count == count.max()], axis=1).T
    return np.asarray(max(sets, key=lambda one: np.count_nonzero(known[one].all(axis=0))))
