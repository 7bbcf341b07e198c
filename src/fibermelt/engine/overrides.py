"""What a person sets: ``-s KEY=VALUE`` and ``--over KEY=VALUES``, and the same in Python.

Neither has an order that anybody would rely on: what is told twice is refused, and so is what
has no effect.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import Any

from fibermelt.engine.parameters import excerpt
from fibermelt.engine.syntax import unreadable
from fibermelt.errors import ConfigError, legible

__all__ = [
    "SETTINGS",
    "plain",
    "read_overrides",
    "read_tables",
    "read_varying",
    "refuse_without_effect",
    "varied",
]

SETTINGS = ("design", "samples", "seed", "weight")
"""Keys of a table ``[sweep]`` that are no parameters."""

DEEPEST_KEY = 10
"""Parts of an overriding key that are read; no parameter has more than two."""

Key = tuple[str, ...]
"""A key, in its parts."""


def read_overrides(overrides: Sequence[str]) -> dict[str, Any]:
    """Return the tables that ``flow.gap=3.5 mm`` and the like stand for, all together.

    Parameters
    ----------
    overrides : sequence of str
        As a person wrote them.

    Raises
    ------
    ConfigError
        If one is no key and value, or a key is given twice: both of its values.
    """
    tables, given = dict[str, Any](), dict[Key, object]()
    for override in overrides:
        table = _table(override)
        for key, value in _leaves(table):
            for other, before in given.items():
                # A table and a key in it are the same key twice as well.
                shared = min(len(key), len(other))
                if key[:shared] == other[:shared]:
                    msg = (
                        f"-s {_told(key[:shared])}: is given twice, as {excerpt(before)} and as "
                        f"{excerpt(value)}: name it once"
                    )
                    raise ConfigError(msg)
            given[key] = value
        _lay(table, tables)
    return tables


def _lay(table: Mapping[str, Any], onto: dict[str, Any]) -> None:
    """Put the keys of a table into another that has none of them."""
    for name, value in table.items():
        below = onto.setdefault(name, {} if isinstance(value, Mapping) else value)
        if isinstance(value, Mapping):
            _lay(value, below)


def read_tables(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables that a study's keys in Python stand for.

    Parameters
    ----------
    given : mapping
        Tables, ``{"flow": {"gap": "3.5 mm"}}``, or keys, ``{"flow.gap": "3.5 mm"}``, or both; a
        number is in SI. The keys inside ``"sweep"`` stay as they are.

    Raises
    ------
    ConfigError
        If a key is no text, or is given twice: both of its values.
    """
    tables: dict[str, Any] = {}
    for key, value in given.items():
        _set(tables, _parts(key), plain(value), ())
    return tables


def _parts(key: object) -> Key:
    path = tuple(part.strip() for part in key.split(".")) if isinstance(key, str) else ()
    if not path or not all(path) or len(path) > DEEPEST_KEY:
        msg = f'{excerpt(key)}: is no key of a study: write it as "flow.gap"'
        raise ConfigError(msg)
    return path


def _set(tables: dict[str, Any], path: Key, value: object, above: Key) -> None:
    """Put a value at a key into tables, a table's entries one by one."""
    name, *rest = path
    here = (*above, name)
    if rest or (isinstance(value, dict) and not (above and above[0] == "sweep")):
        inside = tables.setdefault(name, {})
        if isinstance(inside, dict):
            if rest:
                _set(inside, tuple(rest), value, here)
                return
            for key, one in value.items():  # type: ignore[attr-defined]  # a table, see above
                _set(inside, (key,) if here == ("sweep",) else _parts(key), one, here)
            return
    elif name not in tables:
        tables[name] = value
        return
    msg = (
        f"{_told(here)}: is given twice, as {excerpt(tables[name])} and as {excerpt(value)}: name "
        "it once"
    )
    raise ConfigError(msg)


def plain(value: object) -> object:
    """Return a value as TOML has it: what numpy made as Python's numbers, a path as text."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    if isinstance(value, PurePath):
        return str(value)
    # Numbers and arrays of numpy, and whatever else is like them; numpy itself is not needed here.
    as_list = getattr(value, "tolist", None)
    return as_list() if callable(as_list) else value


def _told(key: Key) -> str:
    return legible(".".join(key))


def _leaves(table: Mapping[str, Any], above: Key = ()) -> Iterator[tuple[Key, object]]:
    """Yield the keys in a table that are no tables themselves, with their values."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, (*above, name))
        else:
            yield (*above, name), value


def _table(override: str) -> dict[str, Any]:
    """Return the table that ``flow.gap=3.5 mm`` stands for."""
    key, equals, text = override.partition("=")
    path = [part.strip() for part in key.split(".")]
    if not equals or not all(path) or len(path) > DEEPEST_KEY:
        msg = f'-s {legible(override)}: write it as key=value, such as -s flow.gap="3.5 mm"'
        raise ConfigError(msg)
    nested: Any = _value(text.strip(), f"-s {legible(key.strip())}")
    for part in reversed(path):
        nested = {part: nested}
    table: dict[str, Any] = nested
    return table


def read_varying(over: Sequence[str]) -> dict[str, object]:
    """Return the entries of ``[sweep]`` that ``flow.gap=2.5 mm, 3 mm`` and the like stand for.

    Parameters
    ----------
    over : sequence of str
        As a person wrote them.

    Raises
    ------
    ConfigError
        If one is no key and values, or a key is given twice: both of its values.
    """
    entries: dict[str, object] = {}
    texts: dict[str, str] = {}
    for one in over:
        key, text, entry = _varying(one)
        if key in entries:
            msg = (
                f"--over {legible(key)}: is given twice, as {legible(texts[key])} and as "
                f"{legible(text)}: write all its values in one --over"
            )
            raise ConfigError(msg)
        entries[key], texts[key] = entry, text
    return entries


def _varying(over: str) -> tuple[str, str, object]:
    """Return the key of what varies, its values as written, and what they stand for."""
    key, equals, text = (part.strip() for part in over.partition("="))
    if not (key and equals and text):
        msg = (
            f'--over {legible(over)}: write it as key=values, such as --over flow.gap="3 mm, 4 mm"'
        )
        raise ConfigError(msg)
    where = f"--over {legible(key)}"
    if key.removeprefix("sweep.") in SETTINGS:
        name = key.removeprefix("sweep.")
        msg = f"{where}: is a setting and does not vary: write -s sweep.{name}={legible(text)}"
        raise ConfigError(msg)
    entry = _value(text, where)
    if isinstance(entry, list | Mapping):
        return key, text, entry
    return key, text, [_value(value.strip(), where) for value in text.split(",")]


def varied(sweep: Mapping[str, Any]) -> dict[str, str]:
    """Return the keys that a table ``[sweep]`` has, each with the name that it has there."""
    return {key.strip(): name for name in sweep for key in name.split(",")}


def refuse_without_effect(
    tables: Mapping[str, Any],
    sweep: Mapping[str, Any],
    over: Mapping[str, object],
    lent: Mapping[str, Collection[str]],
) -> None:
    """Refuse to set a parameter that varies: every case sets it to something else.

    A design that varies one parameter at a time has the study itself among its cases, so that
    there it has an effect.

    Parameters
    ----------
    tables : mapping
        What `read_overrides` made of ``-s``.
    sweep : mapping
        The table ``[sweep]``, with ``--over`` in it.
    over : mapping
        What `read_varying` made of ``--over``.
    lent : mapping
        Keys that follow from others which vary, and all that they follow from.

    Raises
    ------
    ConfigError
        If a parameter is set without effect: its key, its value and the way out.
    """
    if sweep.get("design") == "one-at-a-time":
        return
    varying = varied(sweep)
    varying |= {
        key: varying[one]
        for key, by in lent.items()
        if key not in varying
        for one in by
        if one in varying
    }
    for key, value in _leaves(tables):
        name = varying.get(".".join(key))
        if name is None:
            continue
        where = f"--over {legible(name)}" if name in over else "the table [sweep]"
        msg = (
            f"-s {_told(key)}={excerpt(value)}: has no effect, as {where} sets it in every "
            "case: leave one of them away"
        )
        raise ConfigError(msg)


def _value(text: str, where: str) -> object:
    """Return what TOML reads in ``text``, or else the text itself: shells eat quotes."""
    try:
        read = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    except (ValueError, RecursionError) as error:
        msg = f"{where}: {unreadable(error)}"
        raise ConfigError(msg) from None
    return read["value"] if set(read) == {"value"} else text
