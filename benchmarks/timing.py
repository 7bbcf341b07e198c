"""How long an action takes, for ratios within one run."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["seconds"]


def seconds(action: Callable[[], object], repeats: int = 1) -> float:
    """Return the median wall time of ``action`` [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return sorted(times)[len(times) // 2]
