"""The claims of a sweep as a table: a row for each claim, a column for each case or group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from markupsafe import Markup

from fibermelt.paper.claims.judge import Claim
from fibermelt.report.kit.judged import VERDICTS, counted
from fibermelt.report.kit.tables import Column, number, width_class
from fibermelt.report.kit.tables import table as tables
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
    sections = dict.fromkeys(one.claim.section for one in judged)
    bodies = [
        Markup(
            '<tbody><tr><th scope="rowgroup" colspan="{}">Section {}</th></tr>\n{}</tbody>\n'
        ).format(
            len(columns) + 2,
            section,
            Markup().join(_row(one, columns) for one in judged if one.claim.section == section),
        )
        for section in sections
    ]
    others = _unjudged([one for one in found if one not in judged])
    if not judged:
        return _opening(found, table) + others
    matrix = Markup(
        '<div class="scroll" role="region" tabindex="0" aria-label="Claims over the sweep">\n'
        '<table class="matrix {}"><caption>✓ holds, ≠ differs, ? cannot be judged; below, what the '
        "case has for it, in the claim’s unit</caption>\n"
        "<thead>{}</thead>\n{}</table></div>\n"
    ).format(width_class(len(columns) + 2), _head(columns), Markup().join(bodies))
    return _opening(found, table) + matrix + others


def _unjudged(found: Sequence[SweptClaim]) -> Markup:
    """Return the claims that no case can judge, folded, each with the reason."""
    if not found:
        return Markup()
    columns = (Column("What the paper states", is_text=True), Column("Why not", is_text=True))
    rows = []
    for one in found:
        reasons = dict.fromkeys(each.reason for each in one.judgements if each is not None)
        rows.append((one.claim.statement, "; ".join(reasons) or UNANSWERED))
    return Markup("<details><summary>{} that no case can judge</summary>\n{}</details>\n").format(
        f"{len(found)} test{'s' if len(found) != 1 else ''}",
        tables("Claims that this sweep cannot judge", columns, rows),
    )


def _opening(found: Sequence[SweptClaim], table: SweepTable) -> Markup:
    """Return how many claims hold throughout, and what the others depend on."""
    names: dict[str, list[str]] = {}
    for one in found:
        for name in one.depends:
            names.setdefault(name, []).append(one.claim.id)
    findings = [one.finding for one in found]
    holding, differing = (findings.count(f"{word} throughout") for word in ("holds", "differs"))
    unknown = findings.count("cannot be judged") + findings.count("no case has an answer")
    words = Markup(
        "<p>{}, judged by code against the numbers of {} of {} cases: "
        "{} hold throughout, {} differ throughout, {} depend on what varied or on the case, {} "
        "cannot be judged. A claim depends on what turns its verdict when nothing else "
        "changes.</p>\n"
    ).format(
        counted(one.claim.statement for one in found),
        table.status.count("done"),
        len(table.status),
        holding,
        differing,
        len(found) - holding - differing - unknown,
        unknown,
    )
    if not names:
        return words
    items = Markup().join(
        Markup("<li>{}: {}</li>\n").format(
            name, Markup(", ").join(Markup("<code>{}</code>").format(one) for one in ids)
        )
        for name, ids in names.items()
    )
    return words + Markup("<ul>\n{}</ul>\n").format(items)


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


def _head(columns: Sequence[_Column]) -> Markup:
    grouped = Markup().join(
        Markup('<th scope="colgroup" colspan="{}">{}</th>').format(len(list(together)), group)
        if group
        else Markup('<td colspan="{}"></td>').format(len(list(together)))
        for group, together in groupby(columns, key=lambda column: column.group)
    )
    heads = Markup().join(Markup('<th scope="col">{}</th>').format(one.head) for one in columns)
    return Markup(
        '<tr><th scope="col" rowspan="2">What the paper states</th><th scope="col" rowspan="2">'
        "Over the sweep</th>{}</tr>\n<tr>{}</tr>"
    ).format(grouped, heads)


def _row(one: SweptClaim, columns: Sequence[_Column]) -> Markup:
    verdict = one.finding.split(" ")[0]
    finding = one.finding
    known = {"holds": "holds", "differs": "differs"}.get(verdict, "")
    if not finding.endswith("throughout"):
        known = "differs" if one.depends else ""
    cells = Markup().join(_cell(one, column) for column in columns)
    return Markup(
        '<tr><th scope="row">{} <span class="reason">{}</span><br><code class="key">{}</code></th>'
        '<td class="verdict finding" data-verdict="{}" data-label="Over the sweep">{}</td>{}</tr>\n'
    ).format(one.claim.statement, _meant(one.claim), one.claim.id, known, finding, cells)


def _meant(claim: Claim) -> str:
    """Return the number that the paper gives, where it gives one, and when the claim holds."""
    number = f"Paper: {claim.said}. " if claim.said else ""
    return f"{number}Passes if {claim.passes_if}."


def _cell(one: SweptClaim, column: _Column) -> Markup:
    """Return what some cases say of a claim: a sign for who sees it, a word for who hears it."""
    judged = [one.judgements[case] for case in column.cases]
    there = [each for each in judged if each is not None]
    if not there:
        return Markup(
            '<td data-label="{}"><span aria-hidden="true">–</span>'
            '<span class="heard">{}</span></td>'
        ).format(column.label, UNANSWERED)
    verdicts = {each.verdict for each in there}
    if len(verdicts) > 1:
        holding = sum(each.verdict == "holds" for each in there)
        return Markup('<td class="mixed" data-label="{}">{} of {} hold</td>').format(
            column.label, holding, len(there)
        )
    verdict = there[0].verdict
    value = there[0].value
    ours = "" if len(there) > 1 or value is None else number(value, 3)
    return Markup(
        '<td class="verdict" data-verdict="{0}" data-label="{3}">'
        '<span aria-hidden="true">{1}</span><span class="heard">{0}</span>{2}</td>'
    ).format(
        verdict,
        VERDICTS[verdict],
        Markup(' <span class="ours">{}</span>').format(ours) if ours else "",
        column.label,
    )
