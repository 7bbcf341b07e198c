"""A study as TOML: the commented defaults, and the resolved copy beside the results."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence

from fibermelt.engine.parameters import Declaration, Section, Value, declarations, flatten

__all__ = ["as_toml", "defaults_toml", "resolved_toml", "toml_value"]

_WIDTH = 96
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}


def toml_value(value: object) -> str:
    """Return a value as TOML; a float with all the digits that it needs to be read back.

    Raises
    ------
    TypeError
        If TOML has no such value, as for None.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return '"' + "".join(_ESCAPES.get(character, character) for character in value) + '"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    msg = f"TOML has no value for {value!r}"
    raise TypeError(msg)


def defaults_toml(kind: type[Section]) -> str:
    """Return every parameter with its default, range, unit, meaning and source, as a study.

    Parameters
    ----------
    kind : type
        The class of studies.
    """
    lines = _comment(
        "Every parameter of a fibermelt study, with its default. A quantity is a text with a "
        'unit ("24 mm/s") or a bare number in SI. Delete what you do not change, or start from '
        'a shipped study with preset = "paper" as the first line.'
    )
    for declaration, head in _with_headings(declarations(kind)):
        lines += head
        lines += _comment(_described(declaration))
        name = declaration.key.rpartition(".")[2]
        if declaration.written is None:
            lines.append(f"# {name} = {toml_value(declaration.example)}")
        else:
            lines += _assignment(name, declaration.written)
    return "\n".join(lines) + "\n"


def resolved_toml(config: Section, preamble: str) -> str:
    """Return a resolved study in SI, that runs again to the same results.

    Parameters
    ----------
    config : Section
        The study.
    preamble : str
        What to say on top, as a comment.
    """
    values = flatten(config)
    lines = _comment(preamble)
    for declaration, head in _with_headings(declarations(type(config))):
        lines += head
        value = values[declaration.key]
        name = declaration.key.rpartition(".")[2]
        unit = f"  # {declaration.unit}" if declaration.unit else ""
        if value is None:
            lines.append(f"# {name}: not given")
        else:
            *first, last = _assignment(name, value)
            lines += [*first, last + unit]
    return "\n".join(lines) + "\n"


def as_toml(values: Mapping[str, Value]) -> str:
    """Return some parameters of a resolved study as TOML tables, those that are given.

    Parameters
    ----------
    values : mapping
        By key: ``{"flow.gap": 0.003, ...}``.
    """
    tables: dict[str, list[str]] = {}
    for key, value in values.items():
        table, _, name = key.rpartition(".")
        if value is not None:
            tables.setdefault(table, []).append(f"{name} = {toml_value(value)}")
    return "\n".join(line for name, lines in tables.items() for line in (f"[{name}]", *lines))


def _with_headings(
    every: Iterable[Declaration],
) -> Iterable[tuple[Declaration, list[str]]]:
    """Yield each declaration with the table's heading where a new table begins."""
    section = ""
    for declaration in every:
        parent = declaration.key.rpartition(".")[0]
        yield declaration, [] if parent == section else ["", f"[{parent}]"]
        section = parent


def _described(declaration: Declaration) -> str:
    """Return meaning, unit, range and source in one paragraph."""
    sentences = [declaration.doc.removesuffix(".")]
    if declaration.unit:
        sentences.append(f"Unit: {declaration.unit}")
    if declaration.range:
        sentences.append(f"{'Choices' if declaration.choices else 'Range'}: {declaration.range}")
    if declaration.written is None:
        sentences.append("May be left out")
    if declaration.source:
        sentences.append(f"Source: {declaration.source}")
    return ". ".join(sentences) + "."


def _comment(text: str) -> list[str]:
    return textwrap.wrap(
        text, _WIDTH, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False
    )


def _assignment(name: str, value: object) -> list[str]:
    """Return ``name = value``, a long list on several lines."""
    line = f"{name} = {toml_value(value)}"
    if len(line) <= _WIDTH or not isinstance(value, Sequence) or isinstance(value, str):
        return [line]
    lines, indent = [f"{name} = ["], "    "
    for item in map(toml_value, value):
        if lines[-1].startswith(indent) and len(lines[-1]) + len(item) + 2 <= _WIDTH:
            lines[-1] += f" {item},"
        else:
            lines.append(f"{indent}{item},")
    return [*lines, "]"]
