"""What can go wrong, as types: each message names the value, the bound and the way out."""

from __future__ import annotations

from numbers import Integral, Real
from pathlib import PurePath

__all__ = [
    "ConfigError",
    "ConvergenceError",
    "DamagedError",
    "FibermeltError",
    "HistoryError",
    "MeshError",
    "StoreError",
    "legible",
    "legible_path",
    "refuse_no_count",
    "refuse_no_number",
    "refuse_other",
]

LONGEST = 60
"""Characters of a key, a value or a unit that a message repeats: enough to know it again."""

LONGEST_PATH = 4096
"""Characters of a path that a message repeats: as many as Linux allows."""


class FibermeltError(Exception):
    """Anything a user can cause or cure; the command line prints it on one line."""


class ConfigError(FibermeltError):
    """A study that cannot be run as written: unknown key, wrong unit, value out of its range."""


class MeshError(FibermeltError):
    """A geometry that cannot be meshed, or a mesh that is not what was asked for."""


class ConvergenceError(FibermeltError):
    """A solve that has no answer, or was stopped before it: says where and what to try."""


class HistoryError(FibermeltError):
    """A flow history that no material point can have: times that go back, gradients with trace."""


class StoreError(FibermeltError):
    """A results folder that cannot be read or written: damaged, foreign, read-only or full."""


class DamagedError(StoreError):
    """A file of a results folder that is not what was written."""


def refuse_no_number(name: str, value: object) -> None:
    """Refuse what is not one number: a text with a unit, a list, nothing.

    Parameters
    ----------
    name : str
        What the message calls it.
    value : object
        What was given.

    Raises
    ------
    ConfigError
        If it is no real number: the name, the value and what is expected.
    """
    # numpy counts durations among the whole numbers, Python truth values
    kind = getattr(getattr(value, "dtype", None), "kind", "f")
    if isinstance(value, bool) or not isinstance(value, Real) or kind not in "iuf":
        msg = (
            f"{name} = {legible(repr(value))}: must be one number, in SI; "
            "units are read in studies and on the command line only"
        )
        raise ConfigError(msg)


def refuse_no_count(name: str, value: object, least: int = 1, why: str = "") -> None:
    """Refuse what is not a whole number, or too small a one.

    Parameters
    ----------
    name : str
        What the message calls it.
    value : object
        What was given.
    least : int
        The smallest that is taken.
    why : str
        What needs so many, for the message.

    Raises
    ------
    ConfigError
        If it is no such number: a float is none, even if it is whole.
    """
    kind = getattr(getattr(value, "dtype", None), "kind", "i")
    is_other = isinstance(value, bool) or not isinstance(value, Integral) or kind not in "iu"
    if is_other or int(value) < least:  # type: ignore[call-overload]
        msg = f"{name} = {legible(repr(value))}: must be a whole number of at least {least}"
        raise ConfigError(msg + (f"; {why}" if why else ""))


def refuse_other(name: str, value: object, expected: type | tuple[type, ...]) -> None:
    """Refuse a value of another type than the one that is worked with.

    Parameters
    ----------
    name : str
        What the message calls it.
    value : object
        What was given.
    expected : type or tuple of types
        What it must be.

    Raises
    ------
    ConfigError
        If it is something else; where what is expected lies in it, that is told.
    """
    if isinstance(value, expected):
        return
    holds = isinstance(getattr(value, "response", None), expected)
    way = ": give its .response" if holds else ""
    kinds = expected if isinstance(expected, tuple) else (expected,)
    wanted = " or ".join(kind.__name__ for kind in kinds)
    msg = f"{name} is of the type {type(value).__name__}, must be {wanted}{way}"
    raise ConfigError(msg)


def legible(text: str, longest: int = LONGEST) -> str:
    """Return what somebody wrote so that it fits into a message of one line.

    Parameters
    ----------
    text : str
        A key, a value, a unit or a path.
    longest : int
        Characters that are kept; what is longer is cut and ends in three dots.

    Returns
    -------
    str
        The text with line breaks, control and other characters that do not print escaped.
    """
    cut = text if len(text) <= longest else f"{text[: longest - 3]}..."
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in cut
    )


def legible_path(path: PurePath) -> str:
    """Return a path for a message of one line: whole, since it is what a person goes to."""
    return legible(str(path), LONGEST_PATH)
