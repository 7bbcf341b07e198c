"""Numbers as text, and the tables that they stand in."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from fibermelt import numerals
from fibermelt.numerals import places, rounded

__all__ = [
    "QUANTITY",
    "Column",
    "Table",
    "fixed",
    "measured",
    "number",
    "percent",
    "printed",
    "ranged",
    "short",
    "sized",
]

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    title : str
        What stands in it.
    unit : str
        Unit of its numbers; empty for words and pure numbers.
    is_text : bool
        Whether it holds words, set to the left, rather than numbers.
    """

    title: str
    unit: str = ""
    is_text: bool = False

    @property
    def label(self) -> str:
        """Return its title with its unit, for where it has no head."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title


QUANTITY = (Column("Quantity", is_text=True), Column("Value"), Column("Unit", is_text=True))
"""Columns of a list of quantities, each with a unit of its own."""


def number(value: float | None, digits: int = 4) -> str:
    """Return a number with so many significant digits; a dash where there is none.

    Parameters
    ----------
    value : float or None
        The number; None and NaN stand for what does not exist.
    digits : int
        Significant digits.
    """
    return "–" if value is None or math.isnan(value) else printed(numerals.number(value, digits))


def printed(text: str) -> str:
    """Return a number's digits as print has them: a minus, and a power of ten raised."""
    raised = re.sub(r"e([+-]\d+)", lambda e: f" × 10{str(int(e[1])).translate(_RAISED)}", text)
    return raised.replace("inf", "∞").replace("-", "−")


UNITS = r"[mµn]?m|[mc]?m/s|m?s|M?Pa|Pa s|%|°C|°|K|mm[³^]\S*"
"""What stands behind a number in a sentence."""


def unbroken(text: str) -> str:
    """Return a sentence, or markup, whose numbers stay on one line with their units."""
    return type(text)(re.sub(rf"(?<=\d) (?=(?:{UNITS})(?!\w))", "\u00a0", text))


def sized(value: float | None, size: float, digits: int = 3) -> str:
    """Return a number with the decimals that a size asks for; a dash where there is none.

    Parameters
    ----------
    value : float or None
        The number; None and NaN stand for what does not exist.
    size : float
        Magnitude of what it is told of, in the same unit.
    digits : int
        Significant digits of a number of that size.
    """
    if value is None or math.isnan(value):
        return "–"
    return printed(rounded(value, size, digits))


def ranged(low: float, high: float, digits: int = 3, between: str = "to") -> str:
    """Return two ends with the same decimals, as many as tell them apart.

    Parameters
    ----------
    low, high : float
        The ends, in the same unit.
    digits : int
        Significant digits of the larger; up to two more where the ends lie close.
    between : str
        The word between them.
    """
    size = max(abs(low), abs(high))
    if low != high:
        digits = max(digits, min(digits + 2, digits + places(high - low, 2) - places(size, digits)))
    return f"{sized(low, size, digits)} {between} {sized(high, size, digits)}"


def short(value: float, digits: int = 6) -> str:
    """Return a number with at most so many significant digits, and no zeros behind them."""
    return f"{value:.{digits}g}".replace("-", "−")


def fixed(value: float | None, places: int) -> str:
    """Return a number with so many decimals; a dash where there is none."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:.{places}f}"
    return (text.lstrip("-") if float(text) == 0 else text).replace("-", "−")


def percent(share: float | None, places: int = 2) -> str:
    """Return a share in percent, without the sign; a dash where there is none."""
    return fixed(None if share is None else 100.0 * share, places)


def measured(value: float, error: float) -> str:
    """Return a number with its error estimate, as `fibermelt.numerals.measured` writes it."""
    return "–" if math.isnan(value) else printed(numerals.measured(value, error))


@dataclass(frozen=True)
class Table:
    """Rows under a caption; the macro ``table`` writes it so that it fits a screen.

    Parameters
    ----------
    caption : str
        What the table tells.
    columns : sequence of Column
        Its columns; the first names the rows.
    rows : sequence of sequences of str
        Its cells; what is not `Markup` is escaped.
    scrolls : bool
        Whether it stays a table where it is wider than the screen, to be read down its columns;
        by default rows of many columns become lists.

    Raises
    ------
    ValueError
        If a row has not as many cells as there are columns.
    """

    caption: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[str]]
    scrolls: bool = False

    def __post_init__(self) -> None:
        """Refuse a row that is too short or too long."""
        for cells in self.rows:
            if len(cells) != len(self.columns):
                msg = (
                    f"a table of {len(self.columns)} columns was given a row of {len(cells)} cells"
                )
                raise ValueError(msg)

    def cells(self, row: Sequence[str]) -> Iterable[tuple[Column, str]]:
        """Return the cells of a row with their columns."""
        return zip(self.columns, row, strict=True)
