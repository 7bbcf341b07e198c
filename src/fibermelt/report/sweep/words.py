"""What the report of a sweep tells in words and tables: what varied, its cases, its responses."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from fibermelt.report.kit.tables import Column, meanings, number, table
from fibermelt.report.page.account import account
from fibermelt.report.sweep.weighing import weighing_told
from fibermelt.sweeps.descriptions import distribution_told
from fibermelt.sweeps.design import SETTINGS
from fibermelt.sweeps.quantiles import LEVELS, quantiles
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
    columns = (
        Column("Parameter", is_text=True),
        Column("Unit", is_text=True),
        Column("Values", is_text=True),
    )
    rows = []
    for axis, entry in zip(found.axes, entries, strict=True):
        keys = Markup(", ").join(
            Markup('<code class="key">{}</code>').format(key) for key in axis.keys
        )
        name = Markup("{} {}").format(axis.title.capitalize(), keys)
        rows.append((name, axis.unit or "–", _values(axis, entry)))
    count = len(found.status)
    size = " × ".join(map(str, found.shape)) if len(found.shape) > 1 else str(count)
    head = Markup("<p>{} case{}: {}{}.</p>\n").format(
        size, "s" if count != 1 else "", DESIGNS.get(found.design, found.design), _drawn(asked)
    )
    base = Markup(
        "<details><summary>The study that it varies from</summary>\n{}</details>\n"
    ).format(account(collected, {}))
    return head + table("What varied", columns, rows) + _melt_told(collected) + base


def _melt_told(collected: xr.Dataset) -> Markup:
    """Return of which melt the voids are, as no critical moisture says it; nothing without them."""
    names = ("void_material_name", "void_material", "void_temperature")
    if not set(names) <= set(map(str, collected.data_vars)):
        return Markup()
    titles, keys, kelvin = (collected[name].to_numpy().ravel() for name in names)
    # A case without an answer has neither a name nor a temperature.
    there = np.flatnonzero(np.isfinite(kelvin))
    if not there.size:
        return Markup()
    melts = dict.fromkeys((str(titles[case]), str(keys[case])) for case in there)
    told = [
        Markup('{} (<code class="key">melt.material</code> = {})').format(*melt) for melt in melts
    ]
    celsius = kelvin[there] - ZERO_CELSIUS
    ends = dict.fromkeys(f"{value:.{DIGITS}g}" for value in (celsius.min(), celsius.max()))
    return Markup("<p>Voids are those of {} at {}\N{NO-BREAK SPACE}°C.</p>\n").format(
        Markup(" or ").join(told), " to ".join(ends)
    )


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
    count = {name: found.status.count(name) for name in ("done", "failed", "pending")}
    cases = "cases have" if len(found.status) != 1 else "case has"
    words = f"{count['done']} of {len(found.status)} {cases} an answer"
    if count["failed"]:
        words += f", {count['failed']} failed"
    if count["pending"]:
        words += f", {count['pending']} are still to be computed (fibermelt resume goes on)"
    head = Markup("<p>{}.</p>\n").format(words)
    failed = [case for case, status in enumerate(found.status) if status == "failed"]
    if not failed:
        return head
    columns = (
        Column("Case", is_text=True),
        Column("What it was", is_text=True),
        Column("Why it failed", is_text=True),
    )
    rows = [(str(case + 1), found.point(case), found.reason[case]) for case in failed[:MOST_FAILED]]
    more = len(failed) - MOST_FAILED
    rest = (
        Markup("<p>And {} more: fibermelt status tells of all.</p>\n").format(more)
        if more > 0
        else ""
    )
    return head + table("Cases without an answer", columns, rows) + rest


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
    whole = _spread_told(found, there)
    if found.weighing is not None:
        whole += _spread_told(found, there, found.weighing)
    whole += meanings((one.title, one.meaning) for one in there)
    if len(found.status) > MOST_CASES:
        return whole + Markup(
            "<p>The numbers of each case: fibermelt collect writes them into sweep.nc.</p>\n"
        )
    columns = (
        Column("Case", is_text=True),
        *(Column(one.title, one.unit) for one in there),
    )
    rows = [
        (
            Markup("{}. {}").format(case + 1, found.point(case)),
            *(number(float(one.values[case])) for one in there),
        )
        for case in range(len(found.status))
    ]
    each = table("Responses of each case", columns, rows)
    return whole + Markup("<details><summary>Case by case</summary>\n{}</details>\n").format(each)


def _spread_told(
    found: SweepTable, there: Sequence[Response], weighing: Varied | None = None
) -> Markup:
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
    return table(caption, columns, rows)
