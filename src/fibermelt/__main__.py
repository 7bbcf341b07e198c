"""The command line: ``fibermelt`` and ``python -m fibermelt``, however early Ctrl-C comes."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

__all__ = ["main"]

INTERRUPTED = 130
"""Exit code after Ctrl-C; that of `fibermelt.cli.common`, which may not be there yet."""


def main() -> None:
    """Run the command line; Ctrl-C ends it with `INTERRUPTED`, also while it is loaded."""
    hears = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if hears:
        signal.signal(signal.SIGINT, _leave)
    from fibermelt.cli import main as run  # noqa: PLC0415  takes long enough for Ctrl-C to come

    if hears:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        run()
    except KeyboardInterrupt:
        _end(INTERRUPTED)
    except SystemExit as ended:
        _end(ended.code)


def _leave(number: int, frame: FrameType | None) -> None:
    """Exit at once: nothing was begun, and an import may turn KeyboardInterrupt into its own."""
    os._exit(INTERRUPTED)


def _end(code: str | int | None) -> None:
    """Exit with a code, and not by the signal."""
    if code == INTERRUPTED:
        # Pressed once more, Ctrl-C would meet what Python does last, and end in a traceback.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Where Ctrl-C met an eval of a text, as dataclasses and named tuples have, Python notes to end
    # by the signal, whoever caught it; the next eval clears the note.
    eval("0")
    sys.exit(code)


if __name__ == "__main__":
    main()
