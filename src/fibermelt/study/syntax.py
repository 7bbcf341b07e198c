"""What is wrong with a text that is not TOML, in words, with the way out where one is plain."""

from __future__ import annotations

import re

__all__ = ["syntax_fault"]

_PLACE = re.compile(r"\s*\(at (?:line (?P<line>\d+), column \d+|end of document)\)$")
_UNQUOTED = re.compile(
    r"\s*(?P<key>[\w\"'.-]+)\s*=\s*(?P<value>[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*[A-Za-z%°µμ][^#\"']*)"
)
_TWICE = re.compile(r"cannot declare \((?P<names>.*?),?\) twice", re.IGNORECASE)


def syntax_fault(error: Exception, text: str) -> str:
    """Return what a parser of TOML has to say, in the words of who writes a study.

    Parameters
    ----------
    error : Exception
        What the parser raised: what is wrong, and its place in brackets at the end.
    text : str
        What it was to read.

    Returns
    -------
    str
        What is wrong, the place, and the way out of the commonest mistakes: a table or a key that
        is there twice, a quantity without quotes, a quote that is missing.
    """
    said = str(error)
    place = _PLACE.search(said)
    where = place[0] if place else ""
    what = said.removesuffix(where)
    lines = text.rstrip().split("\n")
    last = len(lines)
    number = int(place["line"]) if place and place["line"] else last
    line = lines[min(number, last) - 1]
    if twice := _TWICE.search(what):
        table = ".".join(name.strip(" '\"") for name in twice["names"].split(","))
        return f"the table [{table}] is there twice: write all its keys under one{where}"
    if what == "Cannot overwrite a value":
        return f"a key is there twice: keep one of them{where}"
    if unquoted := _UNQUOTED.fullmatch(line.rstrip()):
        value = unquoted["value"].strip()
        what += f'; a quantity stands in quotes: {unquoted["key"]} = "{value}"'
    elif line.count('"') % 2:
        what += "; a quote is missing in this line"
    return f"{what[:1].lower()}{what[1:]}{where}"
