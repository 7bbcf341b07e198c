"""What can go wrong, as types: each message names the value, the bound and the way out."""

from __future__ import annotations

__all__ = [
    "ConfigError",
    "ConvergenceError",
    "FibermeltError",
    "HistoryError",
    "MeshError",
    "StoreError",
]


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
