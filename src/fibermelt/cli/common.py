"""What every command has: how it answers, how it says what is wrong, and its shared options."""

from __future__ import annotations

import errno
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fibermelt.engine.progress import silence
from fibermelt.errors import (
    ConfigError,
    ConvergenceError,
    FibermeltError,
    MeshError,
    StoreError,
    legible,
)

if TYPE_CHECKING:
    from fibermelt.engine.loading import Study

__all__ = [
    "INCOMPLETE",
    "INTERRUPTED",
    "ColdOption",
    "JsonOption",
    "OutOption",
    "OverOption",
    "SetOption",
    "StudyArgument",
    "WorkersOption",
    "columns",
    "complain",
    "given_folder",
    "named_folder",
    "read_study",
    "results_folder",
    "say",
    "told",
]

INCOMPLETE = 1
"""Exit code of what ran, but not all came out: a case or solve without answer, a failed check."""

MISTAKE = 2
"""Exit code of any other `FibermeltError`: a study or a folder that cannot be as it is."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it (128 + SIGINT)."""

SHIPPED = (
    "paper, pellet, filament, bead, sensitivity, interaction, thinning; sweeps: nozzle, window, "
    "bead-window, viscosity-speed, aspect-content, population, uncertain"
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

OverOption = Annotated[
    list[str] | None,
    typer.Option(
        "--over",
        metavar="KEY=VALUES",
        help='Have a parameter vary, such as --over flow.gap="3 mm, 4 mm", besides what the '
        "study's table [sweep] has; may be given several times.",
    ),
]
OutOption = Annotated[
    str | None,
    typer.Option(
        "--out", metavar="DIR", help="Results folder; results/NAME by default, NAME of the study."
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option(
        "--workers",
        metavar="N",
        help="Processes on this machine; as many as it has cores by default, 0 for this one only.",
    ),
]
ColdOption = Annotated[
    bool, typer.Option("--cold", help="Have no flow start from that of a neighbouring case.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]


def read_study(study: str, sets: Sequence[str] | None, over: Sequence[str] | None = None) -> Study:
    """Return a study as a command names it; tell what of it is allowed, and hardly meant."""
    from fibermelt.study.chain import CHAIN  # noqa: PLC0415  lazy: help needs none of it
    from fibermelt.study.loading import load_study  # noqa: PLC0415

    resolved = load_study(study, sets or [], over or [])
    for line in CHAIN.unread(resolved):
        complain(f"warning: {line}")
    return resolved


def results_folder(out: str | None, name: str) -> Path:
    """Return the results folder of a study: that of its name unless another one is named."""
    return Path("results", name) if out is None else named_folder(out)


def named_folder(out: str) -> Path:
    """Return a results folder; an empty name would stand for the one that we are in."""
    if not out.strip():
        msg = '--out "": is no name of a folder; write one, such as --out results/mine, or leave '
        msg += "--out away"
        raise StoreError(msg)
    return Path(out)


def given_folder(directory: str) -> Path:
    """Return the results folder that a command is told to look at."""
    if not directory.strip():
        msg = 'DIR "": is no name of a folder; write that of a results folder, such as results/mine'
        raise StoreError(msg)
    return Path(directory)


@contextmanager
def told() -> Iterator[None]:
    """Turn a `FibermeltError` into lines on standard error and an exit code."""
    try:
        yield
    except FibermeltError as error:
        # Only a study has several faults at once; a path may hold line breaks of its own.
        faults = str(error).split("\n") if isinstance(error, ConfigError) else [str(error)]
        for fault in faults:
            complain(f"error: {legible(fault, len(fault))}")
        ran = isinstance(error, ConvergenceError | MeshError)
        raise typer.Exit(INCOMPLETE if ran else MISTAKE) from None


def complain(text: str) -> None:
    """Print on standard error, as far as that can be: the exit code is told in any case."""
    try:
        typer.echo(text, err=True)
    except OSError:
        silence(sys.stderr)


def columns() -> int:
    """Return how many columns the terminal has that standard output is, or is to have."""
    from fibermelt.engine.wrapping import WIDTH  # noqa: PLC0415  lazy: help needs none of it

    return shutil.get_terminal_size((WIDTH, 0)).columns


def say(text: str, *, newline: bool = True) -> None:
    """Print on standard output, or say why that cannot be: a full disk behind it, say."""
    try:
        typer.echo(text, nl=newline)
    except OSError as error:
        if error.errno == errno.EPIPE:
            raise
        silence(sys.stdout)
        reason = (error.strerror or str(error)).lower()
        msg = f"standard output: cannot be written: {reason}"
        raise StoreError(msg) from error
