"""The ladder for a person, and for other programs: a table in text, and plain values for JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from fibermelt.software import versions_of
from fibermelt.verify.ladder import Check, as_dataset_rows

__all__ = ["as_answer", "in_words", "versions"]

COMPUTES = ("fibermelt", "ngsolve", "numpy", "scipy")
"""Packages that make the numbers: what a report of a failure has to name."""


def as_answer(checks: Sequence[Check]) -> dict[str, Any]:
    """Return the checks as `fibermelt verify --json` prints them.

    Parameters
    ----------
    checks : sequence of Check
        What `climb` returned.

    Returns
    -------
    dict
        ``checks``, one mapping each with the keys of `as_dataset_rows` (``value`` is None where
        there is none); ``passed`` and ``failed``, how many; ``software``, versions by name.
    """
    columns = as_dataset_rows(checks)
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    for row in rows:
        if not math.isfinite(row["value"]):
            row["value"] = None
    passed = sum(columns["passed"])
    return {
        "checks": rows,
        "passed": passed,
        "failed": len(checks) - passed,
        "software": versions(),
    }


def in_words(checks: Sequence[Check]) -> str:
    """Return the checks as a table, those that failed once more with what they compare, a total.

    Parameters as in `as_answer`.
    """
    rows = [("", "check", "measured", "required", "s")]
    rows += [
        (
            "pass" if check.passed else "FAIL",
            f"{check.subject}  {check.name}",
            _measured(check),
            _required(check),
            f"{check.seconds:.2f}",
        )
        for check in checks
    ]
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    lines = [
        f"{row[0]:<{widths[0]}}  {row[1]:<{widths[1]}}  {row[2]:>{widths[2]}}  "
        f"{row[3]:<{widths[3]}}  {row[4]:>{widths[4]}}"
        for row in rows
    ]
    failed = [check for check in checks if not check.passed]
    for check in failed:
        lines += ["", f"FAIL  {check.subject}  {check.name}", f"      {check.what}"]
        lines += [f"      {check.failure or f'the bound: {check.because}'}"]
        lines += [f"      reference: {check.reference}"]
    software = ", ".join(f"{name} {number}" for name, number in versions().items())
    seconds = sum(check.seconds for check in checks)
    total = f"{len(checks) - len(failed)} of {len(checks)} checks pass in {seconds:.1f} s"
    return "\n".join([*lines, "", f"{total} ({software})"])


def _measured(check: Check) -> str:
    """Return the number: an order with two decimals, an error with two digits."""
    if not math.isfinite(check.value):
        return "-"
    if check.kind == "order within band":
        return f"{check.value:.2f}"
    return f"{check.value:.1e} {check.unit}".rstrip()


def _required(check: Check) -> str:
    """Return the band."""
    if check.kind == "order within band":
        return f"{check.lowest:g} to {check.highest:g}"
    return f"at most {check.highest:g} {check.unit}".rstrip()


def versions() -> dict[str, str]:
    """Return the versions of what computes, by name."""
    return versions_of(COMPUTES)
