"""The section on the paper's claims, judged by code."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["VERDICTS", "claims", "counted", "tally"]

VERDICTS = {"holds": "✓", "differs": "≠", "cannot be judged": "?"}
"""Signs of the verdicts, so that no colour is needed to tell them apart."""

CHAPTERS = {
    "2.1": "Section 2.1, the deposition flow",
    "2.2": "Section 2.2, the motion of a fiber",
    "2.3": "Section 2.3, one fiber in simple shear",
    "2.4": "Section 2.4, suspensions that are not dilute",
    "2.5": "Section 2.5, the size of the cell",
    "3": "Section 3, fibers in the bead",
    "4": "Section 4, conclusions",
}
"""Sections of the paper, by what a claim's place starts with."""

COLUMNS = tuple(
    Column(title, is_text=True)
    for title in ("What the paper says", "Tested here", "Passes if", "Ours", "Verdict")
)

Claims = Sequence[Mapping[str, Any]]


def tally(listed: Claims) -> str:
    """Return how many claims got which verdict, in words."""
    count = Counter(str(claim["verdict"]) for claim in listed)
    return ", ".join(f"{verdict} {count[verdict]}" for verdict in VERDICTS if count[verdict])


def counted(statements: Iterable[str]) -> str:
    """Return how many tests there are of how many statements of the paper, by their statements."""
    count = Counter(statements)
    tests, several = count.total(), len(count)
    return (
        f"{tests} test{'s' if tests != 1 else ''} of "
        f"{several} statement{'s' if several != 1 else ''} of the paper"
    )


@section("claims", "The paper's claims", place=90, needs="claims")
def claims(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the claims with their verdicts, by section of the paper."""
    del results
    listed = summary["claims"]
    groups: dict[str, list[Mapping[str, Any]]] = {}
    for claim in listed:
        told = {key: _told(claim.get(key)) for key in ("measure", "passes_if", "ours")}
        groups.setdefault(_chapter(claim), []).append({**claim, **told})
    return {
        "counted": counted(claim["statement"] for claim in listed),
        "tally": tally(listed),
        "columns": COLUMNS,
        "groups": groups,
        "signs": VERDICTS,
        "counts": _counts(groups, listed),
        "verdicts": Counter(str(claim["verdict"]) for claim in listed),
    }


def _chapter(claim: Mapping[str, Any]) -> str:
    """Return which part of the paper a claim belongs to: the first that its place names."""
    place = str(claim.get("section") or "Claims")
    first = re.match(r"\d+(\.\d+)?", place)
    return CHAPTERS.get(first[0], place) if first else place


def _counts(groups: Mapping[str, Claims], listed: Claims) -> Table:
    """Return the verdicts by section, as numbers."""
    heads = [Column(f"{sign} {verdict}") for verdict, sign in VERDICTS.items()]
    rows = []
    for name, group in [*groups.items(), ("In all", listed)]:
        count = Counter(str(claim["verdict"]) for claim in group)
        rows.append((name, *(str(count[verdict]) for verdict in VERDICTS), str(len(group))))
    return Table("Verdicts", (Column("Of the paper", is_text=True), *heads, Column("Claims")), rows)


def _told(value: object) -> str:
    """Return what a claim holds: a text as it is, numbers with the digits that are read."""
    if value is None or value == "":
        return "–"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{value:.4g}".replace("-", "−")
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_told, value))
    return str(value)
