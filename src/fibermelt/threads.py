"""The finite elements are entered by one thread of a process at a time.

NGSolve has one task manager and one set of scratch heaps in a process, and lets other Python
threads run while it meshes, assembles and factorises. Two threads inside end in a crash, a matrix
that is called singular, or wrong numbers without a sign. So every function that enters it from
outside of `fibermelt.flow` and `fibermelt.fiber.cell` is `exclusive`: others wait for their turn.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import ParamSpec, TypeVar

__all__ = ["cores", "exclusive"]

P = ParamSpec("P")
R = TypeVar("R")

_INSIDE = RLock()
"""Held by the thread that is inside; it may enter again, as one entry uses another."""


def exclusive(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function that a thread enters only while no other is in any such function."""

    @wraps(function)
    def entered(*args: P.args, **kwargs: P.kwargs) -> R:
        with _INSIDE:
            return function(*args, **kwargs)

    return entered


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
