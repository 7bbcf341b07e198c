"""What is stored of the verification ladder."""

from __future__ import annotations

from collections.abc import Mapping

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["COLUMNS", "QUANTITIES"]

COLUMNS: Mapping[str, str] = {
    "name": "the check in a few words",
    "subject": "what of fibermelt was checked",
    "what": "what is compared with what",
    "reference": "where the other side comes from",
    "because": "why the bound is what it is",
    "kind": "error below bound, or order within band",
    "value": "the number that was measured, in check_unit; NaN if the check could not be done",
    "lowest": "lowest number that passes, in check_unit",
    "highest": "highest number that passes, in check_unit",
    "unit": "unit of value, lowest and highest; empty for a pure number",
    "passed": "whether the number lies in between",
    "failure": "why there is no number; empty if there is one",
}
"""Columns of the table without a unit of their own, each a variable ``check_<column>``."""

# fmt: off
QUANTITIES = declared(
    *(Q(f"check_{column}", "check", "1", what) for column, what in COLUMNS.items()),
    Q("check_seconds", "check", "s", "time that the check took"),
    Q("check_ladder", "", "1", "how much of the ladder was climbed: brief, quick or full"),
    Q("check_software", "", "1", "versions of what computed, when it was climbed"),
)
# fmt: on
"""What this part stores, by name."""
