"""Reading TOML: the one reader, and what is wrong with a text that is not TOML, in words."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

from fibermelt.errors import ConfigError, legible

__all__ = ["parse_toml", "read_toml", "syntax_fault", "unreadable"]

_LONGEST = 200

_PLACE = re.compile(r"\s*\(at (?:line (?P<line>\d+), column \d+|end of document)\)$")
_UNQUOTED = re.compile(
    r"\s*(?P<key>[\w\"'.-]+)\s*=\s*(?P<value>[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*[A-Za-z%°µμ][^#\"']*)"
)
_TWICE = re.compile(r"cannot declare \((?P<names>.*?),?\) twice", re.IGNORECASE)


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a file: of a study, of a material card.

    Parameters
    ----------
    path : Path
        The file, or a pipe.

    Raises
    ------
    ConfigError
        If it cannot be read, or is not TOML: the file, the place, and the way out.
    """
    shown = legible(str(path), _LONGEST)
    try:
        text = path.read_bytes().decode("utf-8")
    except OSError as error:
        msg = f"{shown}: cannot be read: {error.strerror}"
        raise ConfigError(msg) from error
    except UnicodeDecodeError as error:
        msg = f"{shown}: is not a TOML file: byte {error.start} is not UTF-8 text"
        raise ConfigError(msg) from error
    return parse_toml(text, shown)


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the tables of a text.

    Parameters
    ----------
    text : str
        What is to be read; a byte order mark in front, which some editors put there and TOML does
        not know, is no fault.
    where : str
        Where it is from, for messages.

    Raises
    ------
    ConfigError
        If it is not TOML.
    """
    try:
        return tomllib.loads(text.removeprefix("\ufeff"))
    except tomllib.TOMLDecodeError as error:
        msg = f"{where}: not TOML: {legible(syntax_fault(error, text), _LONGEST)}"
        raise ConfigError(msg) from None
    except (ValueError, RecursionError) as error:
        msg = f"{where}: {unreadable(error)}"
        raise ConfigError(msg) from None


def unreadable(error: Exception) -> str:
    """Return what Python refuses to read although TOML may have it."""
    if isinstance(error, RecursionError):
        return "is nested too deeply: a parameter is a number, a text or a list"
    return (
        f"holds a number that is not finite: it has more than {sys.get_int_max_str_digits()} digits"
    )


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
