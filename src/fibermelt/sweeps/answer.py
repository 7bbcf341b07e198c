"""What a sweep comes to, in a few sentences: how far its main response goes, and what moves it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fibermelt.sweeps.analysis import (
    effect,
    quantiles,
    sobol_indices,
    why_no_effect,
    why_no_indices,
)
from fibermelt.sweeps.responses import LEADS
from fibermelt.sweeps.table import SweepTable, sweep_table
from fibermelt.sweeps.window import window_advice

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.sweeps.responses import Response

    Array = NDArray[np.float64]

__all__ = ["answer_sweep"]

TOLD = 3
"""Parameters whose effects are told: the strongest."""

SHARED = 0.05
"""Share of the cases at the median from which on words tell of it: those of one block are fewer."""


def answer_sweep(collected: xr.Dataset) -> tuple[str, ...]:
    """Return what a sweep comes to, one sentence after the other.

    Of a grid and of one parameter at a time the main effects on the response that it is about;
    of samples its quantiles, and the shares of its variance as far as the design gives them.

    Parameters
    ----------
    collected : xarray.Dataset
        As `fibermelt.sweeps.collect.collect_sweep` returns it, finished or not.

    Raises
    ------
    StoreError
        If it does not say what varied.
    """
    table = sweep_table(collected)
    done = table.status.count("done")
    if not done:
        return ("No case has an answer yet.",)
    varying = {one.name: one for one in table.varying}
    if not varying:
        if done == 1:
            return ("One case has an answer: there is nothing to compare it with.",)
        same = ", ".join(one.title[0].lower() + one.title[1:] for one in table.responses)
        return (f"The same in all {done} cases that have an answer: {same or 'all numbers'}.",)
    lead = next((varying[name] for name in LEADS if name in varying), None)
    lead = lead or next(iter(varying.values()))
    told = [_range(table, lead)]
    told.append(_spread(table, lead) if table.is_sampled else _effects(table, lead))
    told.append(window_advice(table))
    return tuple(sentence for sentence in told if sentence)


def _range(table: SweepTable, lead: Response) -> str:
    """Return the lowest and the highest response, and where they are."""
    ends = (int(np.nanargmin(lead.values)), int(np.nanargmax(lead.values)))
    low, high = (f"{_found(lead, end)} ({table.point(end)})" for end in ends)
    count = int(np.count_nonzero(np.isfinite(lead.values)))
    without = len(table.status) - count
    rest = f"; {without} of {len(table.status)} cases have none" if without else ""
    return f"{lead.title}: from {low} to {high}{rest}."


def _effects(table: SweepTable, lead: Response) -> str:
    """Return how far the response goes with each parameter, the strongest first."""
    found, untold, hidden = [], [], []
    for axis in table.axes:
        levels, (mean, _, _) = effect(table, lead, axis)
        there = np.isfinite(mean)
        if np.count_nonzero(there) > 1:
            first, last = np.flatnonzero(there)[[0, -1]]
            ends = (float(mean[first]), float(mean[last]))
            over = f"{axis.written(levels[first])} to {axis.written(levels[last])}"
            span = float(np.ptp(mean[there]))
            if span <= 2.0 * float(lead.limit.max()):
                hidden.append(axis.title)
                continue
            told = f"{axis.title} from {over}: {_number(lead, ends[0])} to {_number(lead, ends[1])}"
            found.append((span, told))
        elif len(levels) > 1:
            untold.append(axis.title)
    no_effect = (
        f"What {_listed(untold)} alone would do cannot be told: {why_no_effect(table)}."
        if untold
        else ""
    )
    if hidden:
        by = _listed(hidden)
        no_effect = f"By {by} it changes by less than its numerical error. {no_effect}".rstrip()
    if not found or (len(found) == 1 and _is_told(table, lead)):
        return no_effect
    found.sort(key=lambda one: -one[0])
    told = "; ".join(told for _, told in found[:TOLD])
    more = f"; {len(found) - TOLD} more move it less" if len(found) > TOLD else ""
    mean = "mean over the others, " if len(table.axes) > 1 and not table.groups else ""
    order = f"What moves it, {mean}the strongest first: " if len(found) > 1 else "With "
    return f"{order}{told}{more}. {no_effect}".rstrip()


def _listed(names: list[str]) -> str:
    """Return names as a sentence has them."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _is_told(table: SweepTable, lead: Response) -> bool:
    """Tell whether the range of a response has said how it follows the only parameter."""
    ends = {int(np.nanargmin(lead.values)), int(np.nanargmax(lead.values))}
    if len(table.axes) > 1 or (table.groups and 0 in ends):
        return False
    at = table.axes[0].values[np.isfinite(lead.values)]
    return {float(table.axes[0].values[end]) for end in ends} == {float(at.min()), float(at.max())}


def _spread(table: SweepTable, lead: Response) -> str:
    """Return the quantiles of the response, and what its variance is due to."""
    low, _, high = (_number(lead, float(value)) for value in quantiles(lead.values))
    told = f"{_half(lead, 'of the cases lie')}, nine tenths between {low} and {high}"
    if table.weighing is not None:
        half = _half(lead, "lies", table.weighing.values)
        told += f"; weighed by {table.weighing.title}, {half[0].lower()}{half[1:]}"
    # Of one parameter alone its share is all of the variance.
    if len(table.axes) == 1:
        return f"{told}."
    indices = sobol_indices(table, lead)
    if indices is None:
        reason = why_no_indices(table, lead)
        return f"{told}; {reason}." if reason else f"{told}."
    shares = indices.first if indices.total is None else indices.total
    margins = indices.first_margin if indices.total_margin is None else indices.total_margin
    most = int(np.argmax(shares))
    kind = "first-order" if indices.total is None else "total"
    share = f"{kind} Sobol index {shares[most]:.2f} ± {margins[most]:.2f}"
    return f"{told}; {table.axes[most].title} accounts for most of that ({share})."


def _half(lead: Response, lie: str, weights: Array | None = None) -> str:
    """Return where the median is; of what many cases share their part, as none lie below it.

    Parameters
    ----------
    lead : Response
        The response.
    lie : str
        What half of the cases do.
    weights : (cases,) ndarray, optional
        What each case counts; all alike if left out.
    """
    there = np.isfinite(lead.values)
    values = lead.values[there]
    counted = np.ones(len(values)) if weights is None else weights[there]
    middle = float(quantiles(lead.values, (0.5,), weights)[0])
    same = np.abs(values - middle) <= lead.same * np.max(np.abs(values))
    share = float(counted[same].sum() / counted.sum())
    if np.count_nonzero(same) < 2 or share < SHARED:
        return f"Half {lie} below {_number(lead, middle)}"
    if not same[[np.argmin(values), np.argmax(values)]].any():
        return f"Half {lie} at or below {_number(lead, middle)}"
    end = "lowest" if same[np.argmin(values)] else "highest"
    return f"{100 * share:.3g} % {lie} at {_number(lead, middle)}, the {end} value"


def _found(lead: Response, case: int) -> str:
    """Return the response of a case, unless its error does not tell it from zero."""
    return "none detected" if lead.undetected[case] else _number(lead, lead.values[case])


def _number(lead: Response, value: float) -> str:
    text = f"{value:.3g} {lead.unit}".rstrip()
    return text.replace("-", "−")
