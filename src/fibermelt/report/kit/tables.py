"""Numbers as text, and rows as HTML tables that a screen reader can read."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from fibermelt import numerals
from fibermelt.numerals import places, rounded

__all__ = [
    "Column",
    "fixed",
    "folded",
    "meanings",
    "measured",
    "number",
    "percent",
    "printed",
    "ranged",
    "short",
    "sized",
    "table",
    "width_class",
]

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

MANY, MOST = 3, 8
"""Columns that fit across a phone and across a desktop's page: 6 em each beside the rows' names."""


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


def folded(title: str, content: Markup) -> Markup:
    """Return content that opens at its title; it is whole in print."""
    return Markup("<details><summary>{}</summary>\n{}</details>\n").format(title, content)


def measured(value: float, error: float) -> str:
    """Return a number with its error estimate, as `fibermelt.numerals.measured` writes it."""
    return "–" if math.isnan(value) else printed(numerals.measured(value, error))


def meanings(quantities: Iterable[tuple[str, str]]) -> Markup:
    """Return titles and what each is, folded; nothing if there are none.

    Parameters
    ----------
    quantities : iterable of (str, str)
        Title and meaning of each; one without a meaning is left out.
    """
    items = [Markup("<dt>{}</dt><dd>{}</dd>\n").format(*one) for one in quantities if one[1]]
    if not items:
        return Markup()
    return folded("What they are", Markup("<dl>\n{}</dl>").format(Markup().join(items)))


def table(caption: str, columns: Sequence[Column], rows: Iterable[Sequence[str]]) -> Markup:
    """Return rows as an HTML table that fits a screen: rows of many columns become lists of cells.

    Parameters
    ----------
    caption : str
        What the table tells.
    columns : sequence of Column
        Its columns; the first names the rows.
    rows : iterable of sequences of str
        Its cells; what is not `Markup` is escaped.

    Raises
    ------
    ValueError
        If a row has not as many cells as there are columns.
    """
    head = Markup().join(
        Markup('<th scope="col"{}>{}{}</th>').format(
            Markup() if first else _kind(column), column.title, _unit(column.unit)
        )
        for first, column in zip([True, *[False] * len(columns)], columns, strict=False)
    )
    body = Markup("\n").join(_row(columns, cells) for cells in rows)
    name = width_class(len(columns))
    return Markup(
        '<div class="scroll" role="region" tabindex="0" aria-label="{0}">\n'
        "<table{3}><caption><span>{0}</span></caption>\n<thead><tr>{1}</tr></thead>\n<tbody>\n{2}\n</tbody></table>"
        "\n</div>\n"
    ).format(caption, head, body, Markup(' class="{}"').format(name) if name else "")


def _row(columns: Sequence[Column], cells: Sequence[str]) -> Markup:
    if len(cells) != len(columns):
        msg = f"a table of {len(columns)} columns was given a row of {len(cells)} cells"
        raise ValueError(msg)
    first = Markup('<th scope="row" data-label="{}">{}</th>').format(_label(columns[0]), cells[0])
    rest = (
        Markup('<td{} data-label="{}">{}</td>').format(_kind(column), _label(column), cell)
        for column, cell in zip(columns[1:], cells[1:], strict=True)
    )
    return Markup("<tr>{}{}</tr>").format(first, Markup().join(rest))


def width_class(columns: int) -> str:
    """Return the page's class of a table of so many columns; its cells have ``data-label`` then."""
    return "most" if columns > MOST else "many" if columns > MANY else ""


def _label(column: Column) -> str:
    return f"{column.title} [{column.unit}]" if column.unit else column.title


def _kind(column: Column) -> Markup:
    return Markup() if column.is_text else Markup(' class="number"')


def _unit(unit: str) -> Markup:
    return Markup(' <span class="unit">[{}]</span>').format(unit) if unit else Markup()
