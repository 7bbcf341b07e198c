"""What a key of a sweep cannot stand for, and what is said then."""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from fibermelt.engine.messages import unknown_key
from fibermelt.engine.parameters import Declaration, excerpt
from fibermelt.errors import ConfigError, legible
from fibermelt.sweeps.settings import SETTINGS
from fibermelt.units import parse

__all__ = ["refuse_range", "refuse_repeated", "refuse_unknown", "refuse_unquoted"]

SAME_DIGITS = 12
"""Digits to which two values are the same: units bring roundings of some 1e-16 of a value."""


def refuse_unknown(key: str, known: Mapping[str, Declaration]) -> NoReturn:
    """Refuse a key that there is not, and tell the nearest parameter, or setting of a sweep.

    Parameters
    ----------
    key : str
        The key.
    known : mapping
        The parameters that there are.

    Raises
    ------
    ConfigError
        Always.
    """
    bare = key.removeprefix("sweep.")
    if near := get_close_matches(bare, SETTINGS, n=1):
        msg = (
            f"sweep.{legible(key)}: unknown key; did you mean {near[0]}? In the table [sweep] it "
            f"stands without quotes, on the command line it is -s sweep.{near[0]}=..."
        )
        raise ConfigError(msg)
    msg = f"sweep.{unknown_key(bare, known)}"
    raise ConfigError(msg)


def refuse_unquoted(key: str, entry: object, known: Mapping[str, Declaration]) -> None:
    """Refuse ``flow.gap = ...`` in the table ``[sweep]``, which TOML takes for a table in a table.

    Parameters
    ----------
    key : str
        The key as TOML has it: the part before the first point.
    entry : object
        What it stands for.
    known : mapping
        The parameters that there are.

    Raises
    ------
    ConfigError
        If it is a table that holds a parameter: the key, as it is to be written.
    """
    inside = entry if isinstance(entry, Mapping) else {}
    meant = next((name for last in inside if (name := f"{key}.{last}") in known), None)
    if meant is not None:
        msg = f'sweep.{meant}: a key of [sweep] stands in quotes: write "{meant}" = ...'
        raise ConfigError(msg)


def refuse_range(shown: str, entry: Mapping[str, Any], about: Declaration) -> None:
    """Refuse a range or a distribution of what is no number that may have any value.

    Parameters
    ----------
    shown : str
        The key, for messages.
    entry : mapping
        The range or the distribution.
    about : Declaration
        The parameter.

    Raises
    ------
    ConfigError
        If it is a list, a word or a whole number: the key, the value and the way out.
    """
    if about.is_list:
        kind, example = "a list", "[[...], [...]]"
    elif about.choices:
        kind, example = "a word", json.dumps(about.choices[:2])
    elif isinstance(about.default, int):
        kind, example = "a whole number", f"[{about.default}, {2 * about.default}]"
    else:
        return
    told = ", ".join(f"{name} = {excerpt(value)}" for name, value in entry.items())
    msg = (
        f"{shown} = {{ {told} }}: {kind} has no range and is not sampled: give a list of "
        f'its values, such as {example}, with design = "grid" or "one-at-a-time"'
    )
    raise ConfigError(msg)


def refuse_repeated(shown: str, values: Sequence[tuple[Any, ...]], units: Sequence[str]) -> None:
    """Refuse a value that is named twice: each would be a case, and count twice in every mean.

    Parameters
    ----------
    shown : str
        The key, for messages.
    values : sequence of tuple
        What the keys are given together, as written.
    units : sequence of str
        SI units of the keys.

    Raises
    ------
    ConfigError
        If two are the same: the key, the values and the way out.
    """
    seen: dict[Hashable, tuple[Any, ...]] = {}
    for together in values:
        meant = tuple(_meant(value, unit) for value, unit in zip(together, units, strict=True))
        if meant in seen:
            first, second = (_written(one) for one in (seen[meant], together))
            what = f"{second} is there twice"
            if first != second:
                what = f"{first} and {second} are the same value"
            msg = f"{shown}: {what}: name it once"
            raise ConfigError(msg)
        seen[meant] = together


def _meant(value: object, unit: str) -> Hashable:
    """Return what is the same for values that mean the same; a wrong one stands for itself."""
    if isinstance(value, list):
        return tuple(_meant(item, unit) for item in value)
    try:
        # Adding 0 makes one zero of two.
        return f"{parse(value, unit) + 0.0:.{SAME_DIGITS}g}"
    except ConfigError:
        return repr(value)


def _written(together: Sequence[Any]) -> str:
    return ", ".join(excerpt(value) for value in together)
