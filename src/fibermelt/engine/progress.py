"""Progress for a person: which stage, how far, what residual; on standard error only."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Protocol, TextIO

if TYPE_CHECKING:
    from rich.console import Console
    from rich.status import Status

__all__ = [
    "Observer",
    "PlainProgress",
    "Silent",
    "TerminalProgress",
    "duration",
    "observing",
    "silence",
]


def duration(seconds: float) -> str:
    """Return a time [s] in words, as well as anybody can foretell it."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


LOG_PAUSE, LOG_SHARE = 10.0, 0.02
"""Least time [s] between two lines of a log that tell how far the whole is, and as a share of the
time so far: a day's log has then some hundreds of them."""


def silence(stream: TextIO) -> None:
    """Have all that is written to a stream lead nowhere, also what it holds and could not write.

    Else that would fail once more, with a traceback or another exit code, as the process ends.
    """
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class Observer(Protocol):
    """Who is told how a run goes."""

    def step(self, stage: str, line: str) -> None:
        """Take note of a step of a stage."""

    def tick(self, stage: str, line: str) -> None:
        """Take note of how far the whole is, told again and again."""

    def done(self, stage: str, line: str) -> None:
        """Take note that a stage is finished, and how."""


class Silent:
    """Takes no note."""

    def step(self, stage: str, line: str) -> None:
        """Ignore it."""

    def tick(self, stage: str, line: str) -> None:
        """Ignore it."""

    def done(self, stage: str, line: str) -> None:
        """Ignore it."""


class PlainProgress:
    """One short line for each step, and now and then one of the whole: for logs and pipes.

    What cannot be written, as behind a full disk, is not told: the run goes on.

    Parameters
    ----------
    stream : text stream
        Where they go.
    clock : callable
        The time [s].
    """

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._clock = clock
        self._began = self._ticked = clock()
        self._last = ""

    def tick(self, stage: str, line: str) -> None:
        """Write the line, unless it says nothing new or comes too soon after the last one."""
        now = self._clock()
        pause = max(LOG_PAUSE, LOG_SHARE * (now - self._began))
        if line != self._last and now - self._ticked >= pause:
            self._last, self._ticked = line, now
            self.step(stage, line)

    def step(self, stage: str, line: str) -> None:
        """Write the line."""
        try:
            self._stream.write(f"{stage}: {line}\n")
            self._stream.flush()
        except OSError:
            silence(self._stream)

    done = step


class TerminalProgress:
    """One line that is written over while a stage works, and stays when it is done."""

    def __init__(self, console: Console, status: Status) -> None:
        self._console = console
        self._status = status

    def step(self, stage: str, line: str) -> None:
        """Show the line in place of the one before."""
        from rich.text import Text  # noqa: PLC0415  lazy: pipes never need it

        self._status.update(Text(f"{stage}: {line}"))

    tick = step

    def done(self, stage: str, line: str) -> None:
        """Leave the line on the screen."""
        self._console.print(f"{stage}: {line}", markup=False, highlight=False)


@contextmanager
def observing(stream: TextIO | None = None) -> Iterator[Observer]:
    """Yield the observer that suits where standard error goes: a terminal, or a file or pipe."""
    stream = sys.stderr if stream is None else stream
    if not stream.isatty():
        yield PlainProgress(stream)
        return
    from rich.console import Console  # noqa: PLC0415  lazy: pipes never need it

    console = Console(file=stream)
    with console.status("starting") as status:
        yield TerminalProgress(console, status)
