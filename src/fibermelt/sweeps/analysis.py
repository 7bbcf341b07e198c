"""What a sweep tells of a response: main effects, quantiles, and what its variance is due to.

Sobol's indices (Sobol, Math. Comput. Simul. 55, 2001, 271-280): the first-order index of a
parameter, ``S_i = Var(E[y | x_i]) / Var(y)``, is the share of a response's variance that goes when
the parameter is known; the total index, ``T_i = E[Var(y | x_~i)] / Var(y)``, is what stays when all
others are. Which of them can be estimated depends on the design:

- ``saltelli``: both, by the estimators of Saltelli et al., Comput. Phys. Commun. 181, 2010,
  259-270, from blocks of cases that differ in one parameter each.
- ``latin-hypercube`` and ``sobol`` (a plain Sobol sequence, which is no Saltelli design): the first
  only, by RBD-FAST for given samples (Plischke, Reliab. Eng. Syst. Saf. 95, 2010, 354-360) with
  the bias correction of Tissot and Prieur, ibid. 107, 2012, 205-213. No total index.
- a grid and one at a time: neither.

The estimators are SALib's; the margins are half 95 % intervals from its bootstrap.

Quantiles are by number, or with every case weighed: of ``n`` values in rising order the ``k``-th
stands in the middle of its share, at ``(S_k - w_k / 2) / S_n`` with the sum ``S_k`` of the weights
``w`` up to it; between two values they are linear. Of equal weights these shares are
``(k - 1/2) / n``, Hazen's rule, definition 5 of Hyndman and Fan, Am. Stat. 50, 1996, 361-365: the
middles of the strata that a Latin hypercube samples, so that its quantiles of a monotone response
err by a stratum at most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fibermelt.sweeps.responses import Response
    from fibermelt.sweeps.table import SweepTable, Varied

    Array = NDArray[np.float64]

__all__ = [
    "FEWEST_CASES",
    "LEVELS",
    "Indices",
    "effect",
    "quantiles",
    "shares_below",
    "sobol_indices",
    "why_no_effect",
    "why_no_indices",
]

LEVELS = (0.05, 0.5, 0.95)
"""Shares of the cases that lie below the quantiles that are told."""

HARMONICS = 10
"""Harmonics of RBD-FAST: the number of its authors and of SALib."""

FEWEST_CASES = 64
"""Cases for RBD-FAST: its bootstrap takes half of them, of which 2 x 10 are due to noise."""

FEWEST_BLOCKS = 16
"""Whole blocks of a Saltelli design below which the margins themselves are not to be trusted."""

RESAMPLES, SEED = 200, 1
"""Of the bootstrap: margins to 5 %; a seed that is not 0, which SALib takes for none."""


@dataclass(frozen=True, eq=False)
class Indices:
    """What the variance of a response is due to.

    Parameters
    ----------
    method : str
        ``"saltelli"`` or ``"rbd-fast"``.
    cases : int
        How many cases they are from.
    first, first_margin : (axes,) ndarray
        First-order index of what varied, and half its 95 % interval.
    total, total_margin : (axes,) ndarray or None
        Total index, likewise; None where the design gives none.
    """

    method: str
    cases: int
    first: Array
    first_margin: Array
    total: Array | None = None
    total_margin: Array | None = None


def sobol_indices(table: SweepTable, response: Response) -> Indices | None:
    """Return Sobol's indices of a response; None where the sweep cannot give them.

    Parameters
    ----------
    table : SweepTable
        The sweep. A grid and a design one at a time give none, nor do too few cases.
    response : Response
        One of its responses; one that does not vary has none.
    """
    if not response.varies or why_no_indices(table, response):
        return None
    if table.design == "saltelli":
        return _saltelli(table, response.values)
    return _given_data(table, response.values) if table.is_sampled else None


def why_no_indices(table: SweepTable, response: Response) -> str:
    """Return why samples are too few for the indices of a response; empty if they are not.

    Parameters
    ----------
    table : SweepTable
        The sweep; of a grid and of one at a time there is nothing to say.
    response : Response
        One of its responses.
    """
    if table.design == "saltelli":
        blocks = _blocks(table, response.values)
        whole = int(np.count_nonzero(np.isfinite(blocks).all(axis=1)))
        if whole >= FEWEST_BLOCKS:
            return ""
        many, each = len(blocks), blocks.shape[1]
        more = "take more samples" if many < FEWEST_BLOCKS else RETRY
        return (
            f"no Sobol indices, which need {FEWEST_BLOCKS} blocks of {each} cases that all have "
            f"an answer: {whole} of {many} are such; {more}"
        )
    there = int(np.count_nonzero(np.isfinite(response.values)))
    if not table.is_sampled or there >= FEWEST_CASES:
        return ""
    more = "take more samples" if len(response.values) < FEWEST_CASES else RETRY
    return (
        f"no Sobol indices, which need {FEWEST_CASES} cases with an answer: {there} of "
        f"{len(response.values)} have one; {more}"
    )


RETRY = "finish the sweep, see why cases failed, or take more samples"
"""What helps where there are samples enough, but not answers."""


def _blocks(table: SweepTable, values: Array) -> Array:
    """Return the cases of a Saltelli design by blocks that differ in one parameter each."""
    return values.reshape(-1, len(table.axes) + 2)


def _saltelli(table: SweepTable, values: Array) -> Indices | None:
    """Return first and total indices from the blocks of which every case has an answer."""
    from SALib.analyze import sobol  # noqa: PLC0415  lazy: 0.8 s

    blocks = _blocks(table, values)
    whole = blocks[np.isfinite(blocks).all(axis=1)]
    if not np.ptp(whole):
        return None
    found = sobol.analyze(
        _problem(table),
        whole.ravel(),
        calc_second_order=False,
        num_resamples=RESAMPLES,
        seed=SEED,
    )
    first, margin, total, total_margin = (
        np.asarray(found[name], dtype=float) for name in ("S1", "S1_conf", "ST", "ST_conf")
    )
    return Indices("saltelli", whole.size, first, margin, total, total_margin)


def _given_data(table: SweepTable, values: Array) -> Indices:
    """Return first-order indices from samples of whatever design."""
    from SALib.analyze import rbd_fast  # noqa: PLC0415  0.8 s

    there = np.isfinite(values)
    found = rbd_fast.analyze(
        _problem(table),
        np.stack([axis.values[there] for axis in table.axes], axis=1),
        values[there],
        M=HARMONICS,
        num_resamples=RESAMPLES,
        seed=SEED,
    )
    first, margin = (np.asarray(found[name], dtype=float) for name in ("S1", "S1_conf"))
    return Indices("rbd-fast", int(np.count_nonzero(there)), first, margin)


def _problem(table: SweepTable) -> dict[str, object]:
    """Return what varied as SALib names it."""
    return {
        "num_vars": len(table.axes),
        "names": [axis.keys[0] for axis in table.axes],
        "bounds": [[0.0, 1.0]] * len(table.axes),
    }


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
    count = known.sum(axis=0)
    if count.max(initial=0) < min(2, len(known)):
        return np.zeros(len(known), dtype=bool)
    sets = np.unique(known[:, count == count.max()], axis=1).T
    return np.asarray(max(sets, key=lambda one: np.count_nonzero(known[one].all(axis=0))))


def why_no_effect(table: SweepTable) -> str:
    """Return why a grid has no main effect of a parameter, and what gives it one.

    Parameters
    ----------
    table : SweepTable
        A grid, or one at a time, with cases that have no answer: of others there is an effect.
    """
    missing = f" ({table.missing})" if table.missing else ""
    keys = [key for axis in table.axes for key in axis.keys]
    together = ", ".join(keys[:2]) if len(keys) > 1 else "flow.inlet_speed, flow.bed_speed"
    return (
        "no two cases that have an answer are alike in all else that varies, so that what differs "
        f"besides may be what moves it{missing}. See why cases have none; take ranges of which "
        "every combination has an answer (a factorial); or, where only some combinations can be "
        f'printed, vary what belongs together as one parameter, as in "{together}" = [...]'
    )


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
    found, shares = shares_below(values, weights)
    if found.size == 0:
        return np.full(len(levels), np.nan)
    return np.interp(levels, shares, found)
