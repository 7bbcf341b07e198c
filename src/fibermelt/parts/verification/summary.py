"""What summary.json says of the verification ladder, as a function of the results."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["summarize_verification", "verification_in_words"]

_TEXTS = ("name", "subject", "what", "reference", "because", "kind", "unit", "failure")
_NUMBERS = ("value", "lowest", "highest", "seconds")


def summarize_verification(results: xr.Dataset) -> dict[str, Any]:
    """Return what summary.json says of the checks.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.

    Returns
    -------
    dict
        ``{"verification": {"passed", "failed", "ladder", "software", "checks": [...]}}``; each
        check with the keys of `fibermelt verify --json`, its ``value`` None if there is none.
    """
    columns: dict[str, list[Any]] = {}
    for keys, kind in ((_TEXTS, str), (_NUMBERS, float), (("passed",), bool)):
        for key in keys:
            columns[key] = [kind(one) for one in results[f"check_{key}"].to_numpy()]
    checks = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    for check in checks:
        if not math.isfinite(check["value"]):
            check["value"] = None
    passed = sum(columns["passed"])
    return {
        "verification": {
            "passed": passed,
            "failed": len(checks) - passed,
            "ladder": str(results["check_ladder"].item()),
            "software": str(results["check_software"].item()),
            "checks": checks,
        }
    }


def verification_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what a summary says of the checks, for a person: one line, one more for failures."""
    found = summary["verification"]
    total = found["passed"] + found["failed"]
    lines = [f"verification    {found['passed']} of {total} checks pass ({found['ladder']} ladder)"]
    if found["failed"]:
        names = [check["name"] for check in found["checks"] if not check["passed"]]
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        lines.append(f"                FAILED: {names[0]}{more}; see fibermelt verify")
    return lines
