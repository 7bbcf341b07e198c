"""Words for a person, in lines that are no longer than they can be read."""

from __future__ import annotations

import re
from collections.abc import Iterable

__all__ = ["WIDTH", "hanging", "unbroken", "wrapped"]

WIDTH = 100
"""Columns of a line where no terminal says how many it has: in a file or a pipe."""

LEAST_WIDTH = 60
"""Columns that lines are given at least: beside a label, less would be a column of words."""

_KEPT = "\u00a0"
"""Stands for a blank at which no line is broken; texts of others have it escaped."""

_LABEL = re.compile("(?:[^ ]+(?: [^ ]+)*)? {2,}|")
"""What text hangs from: a label and the blanks after it, or blanks under one, or nothing."""


_UNIT = r"(?:%|(?:degC?|rad|[kM]?Pa|[mn]?m|1/s|K|s|[kM]B)\b)"
_TOGETHER = re.compile(rf" (?==)|(?<==) |(?<=\d) (?={_UNIT})|(?<=Pa) (?=s\b)")
"""Blanks at which no line is broken whoever wrote it: around an equals sign, before a unit."""


def unbroken(text: str) -> str:
    """Return a text that `wrapped` leaves in one piece: a path, a command, a number and its unit.

    Parameters
    ----------
    text : str
        The text; it is itself again once it was wrapped.
    """
    return text.replace(" ", _KEPT)


def hanging(head: str, text: str, width: int) -> str:
    """Return a text after its head, broken at blanks, with what follows under the text.

    Parameters
    ----------
    head : str
        What stands before it, blanks included.
    text : str
        The text.
    width : int
        Columns that a line may have; `LEAST_WIDTH` if that is more.
    """
    import textwrap  # noqa: PLC0415  only here

    broken = textwrap.fill(
        _TOGETHER.sub(_KEPT, text),
        max(width, LEAST_WIDTH),
        initial_indent=head,
        subsequent_indent=" " * len(head),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return broken.replace(_KEPT, " ")


def wrapped(lines: Iterable[str], width: int) -> str:
    """Return lines, the text of each hanging from its label where it is too long.

    The rows of a table, that have several blanks in their text, stay as they are.

    Parameters
    ----------
    lines : iterable of str
        The lines.
    width : int
        As in `hanging`.
    """
    told = []
    for line in lines:
        label = _LABEL.match(line)
        head = label.group() if label else ""
        text = line[len(head) :]
        is_row = "  " in text or not text
        told.append(line.replace(_KEPT, " ") if is_row else hanging(head, text, width))
    return "\n".join(told)
