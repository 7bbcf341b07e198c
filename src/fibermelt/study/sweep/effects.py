"""Main effects: how a response of a grid, or of one parameter at a time, follows a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.study.sweep.responses import Response
    from fibermelt.study.sweep.table import SweepTable, Varied

    Array = NDArray[np.float64]

__all__ = ["effect"]


def effect(table: SweepTable, response: Response, axis: Varied) -> tuple[Array, Array]:
    """Return the main effect of a parameter: values of it, and mean, least and largest response.

    Of a grid the mean is over all other parameters: over those combinations of them of which every
    value of this one has an answer, so that failed cases do not pass for an effect; if there are
    none, over what is there. One at a time there is one case for each value.

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
        Mean, least and largest response; NaN where no case has an answer.
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
    whole = np.isfinite(rows).all(axis=0)
    rows = rows[:, whole] if whole.any() else rows
    at = np.moveaxis(axis.values.reshape(table.shape), place, 0).reshape(len(grid), -1)[:, 0]
    order = np.argsort(at, kind="stable")
    found = np.full((3, len(rows)), np.nan)
    for row, values in enumerate(rows[order]):
        there = values[np.isfinite(values)]
        if there.size:
            found[:, row] = there.mean(), there.min(), there.max()
    return at[order], found
