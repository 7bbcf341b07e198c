"""The section on the checks of the ladder that the study's own machine climbed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["verification"]

CHECKED = ("name", "subject", "what", "reference", "value", "lowest", "highest", "unit", "passed")
"""What is read of each check, by the names of its variables without ``check_``."""

COLUMNS = (
    Column("Check", is_text=True),
    Column("Measured"),
    Column("Required", is_text=True),
    Column("", is_text=True),
)


@section("verification", "Verification", place=110, needs="check_name")
def verification(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the checks by subject, with their bounds."""
    del summary
    names = [*CHECKED, *(["failure"] if "check_failure" in results else [])]
    columns = [results[f"check_{name}"].to_numpy().tolist() for name in names]
    subjects: dict[str, list[dict[str, Any]]] = {}
    for row in zip(*columns, strict=True):
        check = dict(zip(names, row, strict=True))
        told = {"measured": _measured(check), "required": _required(check)}
        subjects.setdefault(str(check["subject"]), []).append({"failure": "", **check, **told})
    every = [check for group in subjects.values() for check in group]
    return {
        "columns": COLUMNS,
        "subjects": subjects,
        "passed": sum(bool(check["passed"]) for check in every),
        "count": len(every),
        "software": results["check_software"].item() if "check_software" in results else "",
    }


def _after(check: Mapping[str, Any]) -> str:
    return f" {check['unit']}" if check["unit"] else ""


def _measured(check: Mapping[str, Any]) -> str:
    value = float(check["value"])
    return "–" if math.isnan(value) else f"{number(value, 3)}{_after(check)}"


def _required(check: Mapping[str, Any]) -> str:
    low, high = float(check["lowest"]), float(check["highest"])
    band = f"{number(low, 3)} to {number(high, 3)}" if low > 0 else f"at most {number(high, 3)}"
    return band + _after(check)
