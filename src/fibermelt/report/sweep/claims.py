"""The claims of a sweep as a table: a row for each claim, a column for each case or group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.paper.claims.section import VERDICTS, counted
from fibermelt.report.kit.tables import Column, Table, number
from fibermelt.report.kit.templates import rendered
from fibermelt.sweeps.claims import SweptClaim, swept_claims
from fibermelt.sweeps.table import SweepTable

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["claims_matrix"]

MOST_COLUMNS = 16
"""Cases that have a column each; of more, a column stands for all cases of a value."""

UNANSWERED = "no answer"


@dataclass(frozen=True)
class _Column:
    """Some cases that stand in one column: the heads over it, and which they are."""

    group: str
    head: str
    cases: tuple[int, ...]

    @property
    def label(self) -> str:
        """What stands for both heads where there is no room for them."""
        return f"{self.group}, {self.head}" if self.group else self.head


def claims_matrix(collected: xr.Dataset, table: SweepTable) -> Markup:
    """Return which claims hold throughout a sweep and which depend on what; nothing without any.

    Parameters
    ----------
    collected : xarray.Dataset
        The collected sweep.
    table : SweepTable
        Its table.
    """
    found = swept_claims(collected, table)
    if not found:
        return Markup()
    columns = _columns(table)
    judged = [one for one in found if one.count("holds") + one.count("differs")]
    sections: dict[str, list[dict[str, Any]]] = {}
    for one in judged:
        sections.setdefault(one.claim.section, []).append(
            {
                "claim": one.claim,
                "finding": one.finding,
                "verdict": _known(one),
                "cells": [_cell(one, column) for column in columns],
            }
        )
    return rendered(
        "report/sweep/claims.html.j2",
        {
            **_opening(found),
            "done": table.status.count("done"),
            "every": len(table.status),
            "columns": columns,
            "groups": [
                (name, len(list(together)))
                for name, together in groupby(columns, key=lambda column: column.group)
            ],
            "sections": sections,
            "signs": VERDICTS,
            "unanswered": UNANSWERED,
            "unjudged": _unjudged([one for one in found if one not in judged]),
        },
    )


def _unjudged(found: Sequence[SweptClaim]) -> Table:
    """Return the claims that no case can judge, each with the reason."""
    columns = (Column("What the paper states", is_text=True), Column("Why not", is_text=True))
    rows = []
    for one in found:
        reasons = dict.fromkeys(each.reason for each in one.judgements if each is not None)
        rows.append((one.claim.statement, "; ".join(reasons) or UNANSWERED))
    return Table("Claims that this sweep cannot judge", columns, rows)


def _opening(found: Sequence[SweptClaim]) -> dict[str, Any]:
    """Return how many claims hold throughout, and what the others depend on."""
    depends: dict[str, list[str]] = {}
    for one in found:
        for name in one.depends:
            depends.setdefault(name, []).append(one.claim.id)
    findings = [one.finding for one in found]
    holding, differing = (findings.count(f"{word} throughout") for word in ("holds", "differs"))
    unknown = findings.count("cannot be judged") + findings.count("no case has an answer")
    return {
        "counted": counted(one.claim.statement for one in found),
        "holding": holding,
        "differing": differing,
        "depending": len(found) - holding - differing - unknown,
        "unknown": unknown,
        "depends": depends,
    }


def _columns(table: SweepTable) -> list[_Column]:
    """Return the columns: cases where they are few, else all cases of each value."""
    count = len(table.status)
    if table.is_sampled:
        return [_Column("", f"all {count} cases", tuple(range(count)))]
    if table.groups and count <= MOST_COLUMNS:
        own = _Column("", "the study itself", (0,))
        return [own] + [
            _Column(axis.title, axis.written(axis.values[case]), (case,))
            for axis, group in zip(table.axes, table.groups, strict=True)
            for case in group[1:]
        ]
    if len(table.axes) == 2 and not table.groups and count <= MOST_COLUMNS:
        first, second = table.axes
        return [
            _Column(
                f"{first.title} {first.written(first.values[case])}",
                f"{second.title} {second.written(second.values[case])}",
                (case,),
            )
            for case in range(count)
        ]
    groups = table.groups or (tuple(range(count)),) * len(table.axes)
    return [
        _Column(
            axis.title,
            axis.written(level),
            tuple(case for case in group if axis.values[case] == level),
        )
        for axis, group in zip(table.axes, groups, strict=True)
        for level in axis.levels
    ]


def _known(one: SweptClaim) -> str:
    """Return the verdict by which a finding is marked, empty for none."""
    if one.finding.endswith("throughout"):
        return one.finding.split(" ")[0]
    return "differs" if one.depends else ""


def _cell(one: SweptClaim, column: _Column) -> dict[str, Any]:
    """Return what some cases say of a claim: one verdict of all, or how many hold."""
    judged = [one.judgements[case] for case in column.cases]
    there = [each for each in judged if each is not None]
    verdicts = {each.verdict for each in there}
    value = there[0].value if len(there) == 1 else None
    return {
        "label": column.label,
        "verdict": verdicts.pop() if len(verdicts) == 1 else "",
        "holding": sum(each.verdict == "holds" for each in there),
        "count": len(there),
        "ours": "" if value is None else number(value, 3),
    }
