"""What is wrong with a study, in words: one line for each fault, with the way out."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fibermelt.declared import BOUNDS
from fibermelt.engine.parameters import Declaration, Section, declarations, excerpt
from fibermelt.engine.toml import toml_value
from fibermelt.errors import legible
from fibermelt.units import celsius_meant

__all__ = ["explain", "unknown_key"]

_RANGE_FAULTS = {
    "greater_than": "gt",
    "greater_than_equal": "ge",
    "less_than": "lt",
    "less_than_equal": "le",
}
_TYPES = {"int_": "a whole number", "bool_": "true or false"}


def explain(
    error: ValidationError,
    tables: Mapping[str, Any],
    kind: type[Section],
    follows: Mapping[str, tuple[str, ...]] | None = None,
) -> str:
    """Return one line for each fault of a study.

    Parameters
    ----------
    error : ValidationError
        What the validation found.
    tables : mapping
        The study as it was written: its values appear in the messages as the person wrote them.
    kind : type
        What it should have been.
    follows : mapping, optional
        Keys that the study does not say itself, and those that they follow from.
    """
    known = {declaration.key: declaration for declaration in declarations(kind)}
    # What may be a number or a word is at fault twice, and so is a list by each of its items.
    lines = (_line(fault, tables, known) for fault in error.errors())
    return "\n".join(dict.fromkeys(_traced(line, tables, follows or {}) for line in lines))


def _traced(line: str, tables: Mapping[str, Any], follows: Mapping[str, tuple[str, ...]]) -> str:
    """Return a line that says of each key that nobody wrote where it comes from."""
    for key, by in follows.items():
        if re.search(rf"(?<![\w.]){re.escape(key)}(?![\w.])", line):
            said = " and ".join(f"{one} = {_written(one.split('.'), tables)}" for one in by)
            line += f"; {key} follows from {said}"
    return line


def _line(fault: ErrorDetails, tables: Mapping[str, Any], known: Mapping[str, Declaration]) -> str:
    location = [part for part in fault["loc"] if isinstance(part, str)]
    # Behind the key pydantic names the member of a union: voids.moisture.float.
    while len(location) > 1 and ".".join(location[:-1]) in known:
        location.pop()
    key = ".".join(location)
    if fault["type"] == "extra_forbidden":
        if key in known:
            table, _, name = key.rpartition(".")
            return f'"{key}": is one key in quotes: write {name} under [{table}], or {key} without'
        return unknown_key(key, known)
    if key not in known:
        if fault["type"] == "value_error":
            return str(fault["ctx"]["error"])
        return f"{key} = {_written(location, tables)}: is a table of parameters: write [{key}]"
    return f"{key} = {_written(location, tables)}: {_fault(fault, known[key])}"


def _fault(fault: ErrorDetails, declaration: Declaration) -> str:
    """Return what is wrong with the value of a known key, its bound and how to write it."""
    kind = fault["type"]
    example = f", such as {toml_value(declaration.example)}" if declaration.example else ""
    if kind in _RANGE_FAULTS:
        name, bounds = _RANGE_FAULTS[kind], dict(declaration.bounds)
        if name == "ge" and fault["input"] <= bounds.get("gt", -math.inf):
            name = "gt"
        bound = f"must be {BOUNDS[name]} {bounds[name]:g} {declaration.unit}".rstrip()
        bound += f" ({declaration.hints[name]})" if name in declaration.hints else ""
        return bound + celsius_meant(fault["input"], declaration.unit)
    if kind == "value_error":
        said = str(fault["ctx"]["error"])
        # Who is told how to write this very value needs no example of another.
        wanted = f"; expected {declaration.unit}{example}" if declaration.unit else ""
        return said if "degrees Celsius" in said else f"{said}{wanted}"
    if kind == "literal_error" and declaration.choices:
        each = "each must be " if declaration.is_list else "must be "
        return each + declaration.range.removeprefix("each ")
    if kind.startswith("tuple_"):
        return f"must be a list, such as [{toml_value(declaration.example)}]"
    wanted = next(
        (words for start, words in _TYPES.items() if kind.startswith(start)), "one number"
    )
    return f"must be {wanted}{', ' if declaration.range else ''}{declaration.range}{example}"


def unknown_key(key: str, known: Mapping[str, Declaration]) -> str:
    """Return the nearest valid key to one that is not: by the whole path, or by its last part."""
    sections = {name.rpartition(".")[0] for name in known}
    by_leaf = {name.rpartition(".")[2]: name for name in known}
    leaf = key.rpartition(".")[2]
    siblings = [name for name in known if name.rpartition(".")[0] == key.rpartition(".")[0]]
    near = (
        [by_leaf[leaf]]
        if leaf in by_leaf
        else get_close_matches(key, siblings, n=1)
        or get_close_matches(key, [*known, *sections], n=1)
        or [by_leaf[name] for name in get_close_matches(leaf, by_leaf, n=1)]
    )
    if near:
        guess = f"[{near[0]}]" if near[0] in sections else near[0]
        return f"{legible(key)}: unknown key; did you mean {guess}?"
    return f"{legible(key)}: unknown key; `fibermelt defaults` prints every key there is"


def _written(location: list[str], tables: Mapping[str, Any]) -> str:
    """Return a value as the person wrote it."""
    value: Any = tables
    for part in location:
        value = value[part]
    try:
        text = toml_value(value)
    except (TypeError, ValueError, RecursionError):
        return "{...}" if isinstance(value, Mapping) else excerpt(value)
    return legible(text)
