"""What can go wrong, as types: each message names the value, the bound and the way out."""

from __future__ import annotations

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
]

LONGEST = 60
"""Characters of a key, a value or a unit that a message repeats: enough to know it again."""

LONGEST_PATH = 4096
"""Characters of a path that a message repeats: as many as Linux allows."""


class FibermeltError(Exception):
    """Anything a user can cause or cure; the command line prints it on one line, exit code 2."""


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
