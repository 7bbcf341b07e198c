"""A number that a solver takes, declared once: its default, its unit, its bounds.

The solver's dataclass has the declaration; what refuses values, and a study's table, refer to it.
"""

from __future__ import annotations

import math
import operator
from dataclasses import Field, field, fields
from typing import Any

from fibermelt.errors import ConfigError, refuse_no_number

__all__ = ["BOUNDS", "HOLDS", "declaration", "declared", "refuse_beyond"]

BOUNDS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
"""The words for a bound, under the names that pydantic has for it."""

HOLDS = {"gt": operator.gt, "ge": operator.ge, "lt": operator.lt, "le": operator.le}


def declared(default: float | None, unit: str = "", **bounds: float) -> Any:
    """Declare a field of a dataclass.

    Parameters
    ----------
    default : float or None
        In SI. A whole number takes whole numbers only, None may be left out.
    unit : str
        Its SI unit; empty for a pure number.
    **bounds : float
        ``gt``, ``ge``, ``lt``, ``le`` [unit].
    """
    return field(default=default, metadata={"unit": unit, "bounds": bounds})


def declaration(kind: type, name: str) -> Field[Any]:
    """Return the field of a dataclass that was declared under a name."""
    return next(one for one in fields(kind) if one.name == name)


def refuse_beyond(table: str, value: Any) -> None:
    """Refuse what is no number, not finite, or out of the bounds that it was declared with.

    Parameters
    ----------
    table : str
        Of a study, for the message.
    value : dataclass
        Its declared fields are looked at, no others.

    Raises
    ------
    ConfigError
        The key, the value, the bound.
    """
    for one in fields(value):
        if "bounds" not in one.metadata:
            continue
        number, unit = getattr(value, one.name), one.metadata["unit"]
        if number is None and one.default is None:
            continue
        refuse_no_number(f"{table}.{one.name}", number)
        written = f"{table}.{one.name} = {number:g} {unit}".rstrip()
        if not math.isfinite(number):
            msg = f"{written}: must be finite"
            raise ConfigError(msg)
        if isinstance(one.default, int) and number != int(number):
            msg = f"{written}: must be a whole number"
            raise ConfigError(msg)
        for name, bound in one.metadata["bounds"].items():
            if not HOLDS[name](number, bound):
                msg = f"{written}: must be {BOUNDS[name]} {bound:g} {unit}".rstrip()
                raise ConfigError(msg)
