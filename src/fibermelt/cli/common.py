"""What every command has: how it answers, how it says what is wrong, and its shared options."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Annotated

import typer

from fibermelt.errors import ConfigError, FibermeltError, StoreError, legible

__all__ = ["INTERRUPTED", "JsonOption", "SetOption", "StudyArgument", "say", "told"]

MISTAKE = 2
"""Exit code of a `FibermeltError`: a study, a folder or a solve that cannot be as it is."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it (128 + SIGINT)."""

SHIPPED = (
    "paper, sensitivity, interaction; sweeps: nozzle, window, viscosity-speed, aspect-content, "
    "population"
)
"""The studies that come along, in words: a test holds them to the files that are there."""

StudyArgument = Annotated[
    str,
    typer.Argument(
        metavar="STUDY",
        help=f"A study: the path of a TOML file, or one that is shipped ({SHIPPED}).",
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        "-s",
        metavar="KEY=VALUE",
        help='Override a parameter, such as -s flow.gap="3.5 mm"; may be given several times. '
        "`fibermelt defaults` prints all there are.",
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]


@contextmanager
def told() -> Iterator[None]:
    """Turn a `FibermeltError` into lines on standard error and an exit code."""
    try:
        yield
    except FibermeltError as error:
        # Only a study has several faults at once; a path may hold line breaks of its own.
        faults = str(error).split("\n") if isinstance(error, ConfigError) else [str(error)]
        for fault in faults:
            typer.echo(f"error: {legible(fault, len(fault))}", err=True)
        raise typer.Exit(MISTAKE) from None


def say(text: str, *, newline: bool = True) -> None:
    """Print on standard output, or say why that cannot be: a full disk behind it, say."""
    try:
        typer.echo(text, nl=newline)
    except OSError as error:
        if error.errno == errno.EPIPE:
            raise
        # What is still buffered would fail once more, with a traceback, as the process ends.
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        reason = (error.strerror or str(error)).lower()
        msg = f"standard output: cannot be written: {reason}"
        raise StoreError(msg) from error
