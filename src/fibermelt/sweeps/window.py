"""The process window of a sweep: where over two parameters its leading responses are low, and high.

A window is a grid over two numbers. What it is over is how far a nucleus grows (severity), as far
as the sweep has it, else the next of `LEADS`. A number that its stated error does not tell from
zero is none: no contour is drawn through it, and no sentence ranks it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fibermelt.sweeps.responses import LEADS, Response

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fibermelt.sweeps.table import SweepTable, Varied

    Array = NDArray[np.float64]

__all__ = ["Window", "window_advice", "window_of"]

MEASURES = 2
"""Responses side by side."""


@dataclass(frozen=True, eq=False)
class Window:
    """A grid over two numbers, and the responses over it.

    Parameters
    ----------
    across, up : Varied
        What varies along it, and upwards.
    cases : (up, across) ndarray
        Which case of the sweep stands where, both parameters in rising order.
    measures : tuple of Response
        What it is over.
    """

    across: Varied
    up: Varied
    cases: NDArray[np.intp]
    measures: tuple[Response, ...]

    def over(self, values: Array) -> Array:
        """Return what each case has where it stands, (up, across)."""
        found: Array = values[self.cases]
        return found


def window_of(table: SweepTable) -> Window | None:
    """Return the process window of a sweep; None if it is no grid over two numbers.

    Parameters
    ----------
    table : SweepTable
        The sweep. Parameters of a single value may stand beside the two.
    """
    if table.design != "grid":
        return None
    moving = [k for k, count in enumerate(table.shape) if count > 1]
    if len(moving) != 2 or any(table.axes[k].labels for k in moving):
        return None
    known = {one.name: one for one in table.responses if np.isfinite(one.values).any()}
    measures = tuple(known[name] for name in LEADS if name in known)[:MEASURES]
    if not measures:
        return None
    first, second = (table.axes[k] for k in moving)
    places = np.arange(len(table.status)).reshape([table.shape[k] for k in moving])
    rows, columns = (
        np.argsort(axis.values[line], kind="stable")
        for axis, line in ((first, places[:, 0]), (second, places[0]))
    )
    return Window(first, second, places[np.ix_(rows, columns)].T, measures)


def window_advice(table: SweepTable) -> str:
    """Return where the responses of a process window are lowest, and where they are not detected.

    Parameters
    ----------
    table : SweepTable
        The sweep; nothing is said of one without a window.
    """
    window = window_of(table)
    if window is None:
        return ""
    told = [sentence for one in window.measures if (sentence := _lowest(table, one))]
    return " ".join(told)


def _lowest(table: SweepTable, response: Response) -> str:
    """Return where a severity is least, or is not detected; nothing of what is no severity."""
    if not response.name.startswith("severity"):
        return ""
    known, none = np.isfinite(response.values), response.undetected
    # Nothing above zero needs no error to be none.
    none |= known & (response.values == 0.0)
    count = int(np.count_nonzero(known))
    if none.any():
        if none.sum() == count:
            return f"{response.title}: not detected in any case."
        first = table.point(int(np.flatnonzero(none)[0]))
        return (
            f"{response.title}: not detected in {np.count_nonzero(none)} of {count} cases, among "
            f"them {first}."
        )
    if not response.varies:
        return ""
    best = int(np.nanargmin(response.values))
    error = response.limit[best]
    margin = f" ± {error:.1g}" if error else ""
    return f"{response.title}: least, {response.values[best]:.3g}{margin}, at {table.point(best)}."
