"""What a sampled sweep tells of its responses: what their variance is due to.

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
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fibermelt.sweeps.table import SweepTable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.sweeps.responses import Response

    Array = NDArray[np.float64]

__all__ = ["FEWEST_CASES", "Indices", "sobol_indices", "why_no_indices"]

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
    import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

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
    import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it
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
    import numpy as np  # noqa: PLC0415  lazy: see above
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
