"""Which of a file's times is read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fibermelt.errors import ConfigError, legible_path

__all__ = ["chosen_time"]

TIME_TOLERANCE = 1e-6
"""Parts of a time by which the one named may miss it: files round."""

MOST_TOLD = 8
"""Times that a message lists."""


def chosen_time(path: Path, times: Sequence[float], named: float | None) -> float:
    """Return the time that is named, the last one if none is.

    Raises
    ------
    ConfigError
        If the file has no such time: those that it has.
    """
    if named is None:
        return times[-1]
    nearest = min(times, key=lambda time: abs(time - named))
    if abs(nearest - named) <= TIME_TOLERANCE * max(abs(named), abs(nearest)):
        return nearest
    shown = ", ".join(f"{time:g}" for time in times[:MOST_TOLD])
    more = f" and {len(times) - MOST_TOLD} more" if len(times) > MOST_TOLD else ""
    msg = (
        f"field.time_step = {named:g}: {legible_path(path)} has no such time; it has {shown}{more}"
    )
    raise ConfigError(msg)
