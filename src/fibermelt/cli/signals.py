"""What surrounds a command: signals to end it, and streams that are not there.

Batch systems, `kill` and terminals send signals where a person presses Ctrl-C; daemons start what
they start with its standard streams closed.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["Ended", "ended_in_order", "stand_in_for_closed"]

OUTPUTS = (1, 2)
"""Standard output and standard error, as the operating system numbers them."""


STREAMS = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))
"""Standard streams in the order of the operating system's numbers, and how they are opened."""


def stand_in_for_closed() -> None:
    """Have standard streams that are closed lead nowhere, as the command line writes to them.

    Their numbers are taken as well: the next file that is opened would have one, and what a library
    or a process that is started prints would go into it.
    """
    for number, (name, mode) in enumerate(STREAMS):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115


class Ended(KeyboardInterrupt):
    """A signal to end.

    Parameters
    ----------
    number : int
        The signal's number.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.code = 128 + number
        """Exit code, as shells have it."""


@contextmanager
def ended_in_order() -> Iterator[None]:
    """Have SIGTERM and SIGHUP end what is inside as Ctrl-C does, with all that it started.

    A second one changes nothing. What is ignored stays so: nohup has a sweep outlive its terminal.

    Raises
    ------
    Ended
        When one of them comes.
    """
    terminals = [number for number in OUTPUTS if os.isatty(number)]
    has_come = False

    def end(number: int, frame: FrameType | None) -> None:
        nonlocal has_come
        _let_go(terminals)
        if not has_come:
            has_come = True
            raise Ended(number)

    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    numbers = [getattr(signal, name) for name in names]
    before = {number: signal.getsignal(number) for number in numbers}
    heard = [number for number in numbers if before[number] is not signal.SIG_IGN]
    for number in heard:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in heard:
            signal.signal(number, before[number])


def _let_go(terminals: list[int]) -> None:
    """Send what is still printed nowhere if its terminal was closed: each line would fail."""
    for number in terminals:
        if not os.isatty(number):
            os.dup2(os.open(os.devnull, os.O_WRONLY), number)
