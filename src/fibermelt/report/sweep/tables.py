"""Sections of a sweep's page in words and tables: what varied, its cases, its responses."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from fibermelt.report.kit.tables import Column, Table, number
from fibermelt.report.kit.templates import rendered
from fibermelt.report.page.what_was_run import what_was_run
from fibermelt.report.sweep.sampled import weighing_told
from fibermelt.sweeps.analysis import LEVELS, quantiles
from fibermelt.sweeps.axes import distribution_told
from fibermelt.sweeps.design import SETTINGS
from fibermelt.sweeps.table import DIGITS, SweepTable, Varied
from fibermelt.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr

    from fibermelt.sweeps.responses import Response

__all__ = ["cases_told", "responses_told", "varied_told"]

DESIGNS = {
    "grid": "every combination",
    "one-at-a-time": "one parameter at a time, and the study itself",
    "latin-hypercube": "samples of a Latin hypercube",
    "sobol": "samples of a Sobol sequence",
    "saltelli": "samples of Saltelli's scheme",
}

VARIED = tuple(Column(title, is_text=True) for title in ("Parameter", "Unit", "Values"))

LONGEST_LIST = 8
"""Values of a parameter that are written out; of more, the first, the last and how many."""

MOST_FAILED, MOST_CASES = 50, 200
"""Failed cases and cases in all that are listed one by one: sweep.nc has every one."""


def varied_told(collected: xr.Dataset, found: SweepTable) -> Markup:
    """Return what varied, and the study that it varied from.

    Parameters
    ----------
    collected : xarray.Dataset
        The collected sweep.
    found : SweepTable
        Its table.
    """
    asked: dict[str, Any] = json.loads(collected.attrs["sweep"])
    entries = [entry for name, entry in asked.items() if name not in SETTINGS]
    count = len(found.status)
    return rendered(
        "report/sweep/varied.html.j2",
        {
            "size": " × ".join(map(str, found.shape)) if len(found.shape) > 1 else str(count),
            "plural": "s" if count != 1 else "",
            "design": DESIGNS.get(found.design, found.design) + _drawn(asked),
            "columns": VARIED,
            "axes": [
                (axis, _values(axis, entry))
                for axis, entry in zip(found.axes, entries, strict=True)
            ],
            "melt": _melt(collected),
            "base": what_was_run(collected),
        },
    )


def _melt(collected: xr.Dataset) -> dict[str, Any]:
    """Return of which melt the voids are, as no critical moisture says it; nothing without them."""
    names = ("void_material_name", "void_material", "void_temperature")
    if not set(names) <= set(map(str, collected.data_vars)):
        return {}
    titles, keys, kelvin = (collected[name].to_numpy().ravel() for name in names)
    # A case without an answer has neither a name nor a temperature.
    there = np.flatnonzero(np.isfinite(kelvin))
    if not there.size:
        return {}
    celsius = kelvin[there] - ZERO_CELSIUS
    ends = dict.fromkeys(f"{value:.{DIGITS}g}" for value in (celsius.min(), celsius.max()))
    return {
        "cards": list(dict.fromkeys((str(titles[case]), str(keys[case])) for case in there)),
        "celsius": " to ".join(ends),
    }


def _drawn(asked: dict[str, Any]) -> str:
    """Return the seed of samples."""
    return f", seed {asked.get('seed', 0)}" if "samples" in asked else ""


def _values(axis: Varied, entry: object) -> str:
    """Return the values of a parameter, or what they are samples of, as the study has it."""
    if told := distribution_told(axis.keys[0], entry):
        return told
    if len(axis.keys) > 1 and isinstance(entry, list):
        texts = [" with ".join(map(str, together)) for together in entry]
    else:
        texts = list(axis.labels) or [f"{level:.{DIGITS}g}" for level in axis.levels]
    if len(texts) <= LONGEST_LIST:
        return ", ".join(texts).replace("-", "−") if not axis.labels else ", ".join(texts)
    return f"{texts[0]} to {texts[-1]}, {len(texts)} values"


def cases_told(found: SweepTable) -> Markup:
    """Return what became of the cases, and why some failed.

    Parameters
    ----------
    found : SweepTable
        The sweep.
    """
    failed = [case for case, status in enumerate(found.status) if status == "failed"]
    columns = (
        Column("Case", is_text=True),
        Column("What it was", is_text=True),
        Column("Why it failed", is_text=True),
    )
    rows = [(str(case + 1), found.point(case), found.reason[case]) for case in failed[:MOST_FAILED]]
    return rendered(
        "report/sweep/cases.html.j2",
        {
            "count": {name: found.status.count(name) for name in ("done", "failed", "pending")},
            "every": len(found.status),
            "failed": Table("Cases without an answer", columns, rows),
            "more": len(failed) - MOST_FAILED,
        },
    )


def responses_told(found: SweepTable) -> Markup:
    """Return the range or the quantiles of the responses, and the responses of each case.

    Parameters
    ----------
    found : SweepTable
        The sweep; nothing if it has no responses.
    """
    there = [one for one in found.responses if np.isfinite(one.values).any()]
    if not there:
        return Markup()
    columns = (
        Column("Case", is_text=True),
        *(Column(one.title, one.unit) for one in there),
    )
    shown = range(len(found.status) if len(found.status) <= MOST_CASES else 0)
    rows = [
        (
            f"{case + 1}. {found.point(case)}",
            *(number(float(one.values[case])) for one in there),
        )
        for case in shown
    ]
    weighed = [] if found.weighing is None else [_spread(found, there, found.weighing)]
    return rendered(
        "report/sweep/responses.html.j2",
        {
            "spreads": [_spread(found, there), *weighed],
            "meanings": [(one.title, one.meaning) for one in there],
            "each": Table("Responses of each case", columns, rows),
        },
    )


def _spread(found: SweepTable, there: Sequence[Response], weighing: Varied | None = None) -> Table:
    """Return the range or the quantiles of the responses, of samples also with cases weighed."""
    levels: tuple[float, ...] = LEVELS if found.is_sampled else (0.0, 1.0)
    heads = ("5 %", "median", "95 %") if found.is_sampled else ("lowest", "highest")
    caption = f"{'Quantiles' if found.is_sampled else 'Range'} of the responses over the cases"
    if weighing is not None:
        caption = f"{caption}, {weighing_told(weighing)}"
    elif found.weighing is not None:
        caption += ", each counted once: by number"
    columns = (
        Column("Response", is_text=True),
        Column("Unit", is_text=True),
        *(Column(head) for head in heads),
        Column("Cases"),
    )
    weights = None if weighing is None else weighing.values
    rows = [
        (
            one.title,
            one.unit or "–",
            *(number(float(value)) for value in quantiles(one.values, levels, weights)),
            str(np.count_nonzero(np.isfinite(one.values))),
        )
        for one in there
    ]
    return Table(caption, columns, rows)
