"""Sections of what was judged by code: the paper's claims, and the checks of the ladder."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.report.kit.tables import Column, number, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["claims", "counted", "tally", "verification"]

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

COLUMNS = (
    Column("What the paper says", is_text=True),
    Column("Tested here", is_text=True),
    Column("Passes if", is_text=True),
    Column("Ours", is_text=True),
    Column("Verdict", is_text=True),
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


def claims(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the claims with their verdicts, by section of the paper; nothing if there are none."""
    del results
    listed = summary.get("claims") or []
    if not listed:
        return Markup()
    groups: dict[str, list[Mapping[str, Any]]] = {}
    for claim in listed:
        groups.setdefault(_chapter(claim), []).append(claim)
    head = Markup("<p>{}, judged by code against the stored numbers. Verdicts: {}.</p>\n").format(
        counted(claim["statement"] for claim in listed), tally(listed)
    )
    tables = [table(name, COLUMNS, map(_claim, group)) for name, group in groups.items()]
    return head + _counts(groups, listed) + _filter(listed) + Markup().join(tables)


def _chapter(claim: Mapping[str, Any]) -> str:
    """Return which part of the paper a claim belongs to: the first that its place names."""
    place = str(claim.get("section") or "Claims")
    first = re.match(r"\d+(\.\d+)?", place)
    return CHAPTERS.get(first[0], place) if first else place


def _counts(groups: Mapping[str, Claims], listed: Claims) -> Markup:
    """Return the verdicts by section, as numbers."""
    heads = [Column(f"{sign} {verdict}") for verdict, sign in VERDICTS.items()]
    rows = []
    for name, group in [*groups.items(), ("In all", listed)]:
        count = Counter(str(claim["verdict"]) for claim in group)
        rows.append((name, *(str(count[verdict]) for verdict in VERDICTS), str(len(group))))
    columns = (Column("Of the paper", is_text=True), *heads, Column("Claims"))
    return Markup('<div class="tally">{}</div>\n').format(table("Verdicts", columns, rows))


def _filter(listed: Claims) -> Markup:
    """Return the choice of which verdicts are shown; it works without a script."""
    count = Counter(str(claim["verdict"]) for claim in listed)
    options = [("all", "all", len(listed))]
    options += [
        (verdict.split(maxsplit=1)[0], f"{sign} {verdict}", count[verdict])
        for verdict, sign in VERDICTS.items()
        if count[verdict]
    ]
    one = Markup(
        '<label for="show-{0}"><input type="radio" name="verdict" id="show-{0}"{3}> {1} ({2})'
        "</label>\n"
    )
    labels = Markup().join(
        one.format(name, words, many, Markup(' checked=""') if name == "all" else "")
        for name, words, many in options
    )
    return Markup('<fieldset class="filter"><legend>Show</legend>\n{}</fieldset>\n').format(labels)


def _claim(claim: Mapping[str, Any]) -> tuple[Markup, str, str, str, Markup]:
    verdict = str(claim["verdict"])
    label = Markup('<span class="verdict" data-verdict="{0}">{1} {0}</span>').format(
        verdict, VERDICTS.get(verdict, "")
    )
    if reason := claim.get("reason"):
        label += Markup('<br><span class="reason">{}</span>').format(reason)
    place = str(claim.get("section") or "")
    statement = Markup('{}<br><span class="key">{}<code class="key">{}</code></span>').format(
        claim["statement"], f"{place} · " if place else "", claim["id"]
    )
    tested, passes_if, ours = (_told(claim.get(key)) for key in ("measure", "passes_if", "ours"))
    return statement, tested, passes_if, ours, label


def _told(value: object) -> str:
    """Return what a claim holds: a text as it is, numbers with the digits that are read."""
    if value is None or value == "":
        return "–"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{value:.4g}".replace("-", "−")
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_told, value))
    return str(value)


CHECKED = ("name", "subject", "what", "reference", "value", "lowest", "highest", "unit", "passed")
"""What is read of each check, by the names of its variables without ``check_``."""


def verification(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the checks that the study's own machine climbed, by subject, with their bounds."""
    del summary
    columns = [results[f"check_{name}"].to_numpy().tolist() for name in CHECKED]
    names = list(CHECKED)
    if "check_failure" in results:
        names.append("failure")
        columns.append(results["check_failure"].to_numpy().tolist())
    checks = [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
    passed = sum(bool(check["passed"]) for check in checks)
    words = Markup(
        "<p>Exact solutions, observed orders of convergence, and independent paths against one "
        "another, measured where the study was run{}: {} of {} checks pass.</p>\n"
    ).format(_software(results), passed, len(checks))
    subjects = dict.fromkeys(str(check["subject"]) for check in checks)
    heads = (
        Column("Check", is_text=True),
        Column("Measured"),
        Column("Required", is_text=True),
        Column("", is_text=True),
    )
    tables = [
        table(
            subject.capitalize(),
            heads,
            [_check(check) for check in checks if str(check["subject"]) == subject],
        )
        for subject in subjects
    ]
    return words + Markup().join(tables)


def _software(results: xr.Dataset) -> str:
    """Return what computed when the checks were made, where that is stored."""
    return f", with {results['check_software'].item()}" if "check_software" in results else ""


def _check(check: Mapping[str, Any]) -> tuple[Markup, str, str, Markup]:
    unit = str(check["unit"])
    after = f" {unit}" if unit else ""
    low, high = float(check["lowest"]), float(check["highest"])
    band = f"{number(low, 3)} to {number(high, 3)}" if low > 0 else f"at most {number(high, 3)}"
    value = float(check["value"])
    name = Markup('{}<br><span class="reason">{} {}</span>').format(
        check["name"], check["what"], f"({check['reference']})" if check["reference"] else ""
    )
    if failure := check.get("failure"):
        name += Markup('<br><span class="reason">Not measured: {}</span>').format(failure)
    good = bool(check["passed"])
    verdict = Markup('<span class="verdict" data-verdict="{}">{}</span>').format(
        "holds" if good else "differs", "✓ pass" if good else "✗ fail"
    )
    shown = "–" if math.isnan(value) else f"{number(value, 3)}{after}"
    return name, shown, f"{band}{after}", verdict
