"""The command line: thin, and a person's mistake never ends in a traceback.

Exit codes: 0 done; 2 what the user can cause or cure, with one line for each fault on standard
error; 130 interrupted.
"""

from __future__ import annotations

import errno
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fibermelt.errors import ConfigError, FibermeltError, StoreError, legible

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["app", "main"]

MISTAKE = 2
"""Exit code of a `FibermeltError`: a study, a folder or a solve that cannot be as it is."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it (128 + SIGINT)."""

app = typer.Typer(
    help="Where a short-fiber polymer bead will void.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

StudyArgument = Annotated[
    str, typer.Argument(help="A study: the path of a TOML file, or a shipped one such as `paper`.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        "-s",
        metavar="KEY=VALUE",
        help='Override a parameter, such as -s flow.gap="3.5 mm"; may be given several times.',
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]


def main() -> None:
    """Run the command line."""
    app()


@contextmanager
def _told() -> Iterator[None]:
    """Turn a `FibermeltError` into lines on standard error and an exit code."""
    try:
        yield
    except FibermeltError as error:
        # Only a study has several faults at once; a path may hold line breaks of its own.
        faults = str(error).split("\n") if isinstance(error, ConfigError) else [str(error)]
        for fault in faults:
            typer.echo(f"error: {legible(fault, len(fault))}", err=True)
        raise typer.Exit(MISTAKE) from None


def _print(text: str, *, newline: bool = True) -> None:
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


def _print_version(asked: bool) -> None:
    """Print the version and stop, where `--version` asks for it."""
    if asked:
        version()
        raise typer.Exit


@app.callback()
def options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Take what is said before a command."""


@app.command()
def run(
    study: StudyArgument,
    out: Annotated[
        str | None,
        typer.Option("--out", metavar="DIR", help="Results folder; results/<study> by default."),
    ] = None,
    sets: SetOption = None,
    as_json: JsonOption = False,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Compute everything again, whatever is stored.")
    ] = False,
) -> None:
    """Run a study into a results folder; what is stored there already is reused."""
    with _told():
        from fibermelt.study.chain import CHAIN  # noqa: PLC0415  lazy: help needs none of it
        from fibermelt.study.loading import load_study, replaces_another  # noqa: PLC0415
        from fibermelt.study.parts import in_words  # noqa: PLC0415
        from fibermelt.study.progress import observing  # noqa: PLC0415
        from fibermelt.study.runner import run_study  # noqa: PLC0415

        resolved = load_study(study, sets or [])
        folder = _folder(out, resolved.name)
        if out is None and sets and replaces_another(folder, resolved.config):
            shown = legible(str(folder), len(str(folder)))
            typer.echo(
                f"note: {shown} shows a run of other parameters, which this one replaces; "
                "name another folder with --out to keep both",
                err=True,
            )
        try:
            with observing() as observer:
                summary = run_study(
                    resolved, folder, CHAIN, draw=_draw, fresh=fresh, observer=observer
                )
        except KeyboardInterrupt:
            typer.echo(
                "interrupted: finished stages are kept, the same command goes on from them",
                err=True,
            )
            raise typer.Exit(INTERRUPTED) from None
        words = in_words(summary, CHAIN, resolved, folder)
        _print(json.dumps(summary, indent=1) if as_json else words)


def _folder(out: str | None, name: str) -> Path:
    """Return the results folder; an empty name would stand for the one that we are in."""
    if out is not None and not out.strip():
        msg = '--out "": is no name of a folder; write one, such as --out results/mine, or leave '
        msg += "--out away"
        raise StoreError(msg)
    return Path("results", name) if out is None else Path(out)


def _draw(results: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the figures: wired here, since the study does not know the report."""
    from fibermelt.report.figures import draw_figures  # noqa: PLC0415  lazy, as in run

    return draw_figures(results, folder)


@app.command()
def report(
    directory: Annotated[
        str, typer.Argument(metavar="DIR", help="A results folder that `fibermelt run` wrote.")
    ],
    as_json: JsonOption = False,
) -> None:
    """Write the report of a finished run: one HTML file that needs nothing else."""
    with _told():
        from fibermelt.report.html import write_report  # noqa: PLC0415  lazy, as in run

        path = write_report(Path(directory))
        size = path.stat().st_size
        shown = legible(str(path), len(str(path)))
        _print(json.dumps({"report": str(path), "bytes": size}) if as_json else shown)


@app.command()
def validate(study: StudyArgument, sets: SetOption = None, as_json: JsonOption = False) -> None:
    """Check a study without running it, and say what is wrong with it."""
    with _told():
        from fibermelt.study.loading import load_study  # noqa: PLC0415  lazy, as in run
        from fibermelt.study.parameters import flatten  # noqa: PLC0415

        resolved = load_study(study, sets or [])
        if as_json:
            _print(json.dumps(flatten(resolved.config), indent=1))
        else:
            _print(f"{legible(study, len(study))}: a valid study ({resolved.origin})")


@app.command()
def defaults(as_json: JsonOption = False) -> None:
    """Print every parameter with its default, range, unit, meaning and source, as TOML."""
    with _told():
        from fibermelt.study.config import Config  # noqa: PLC0415  lazy, as in run
        from fibermelt.study.parameters import declarations  # noqa: PLC0415
        from fibermelt.study.toml import defaults_toml  # noqa: PLC0415

        if not as_json:
            _print(defaults_toml(), newline=False)
            return
        listed = {
            item.key: {
                "default": item.default,
                "unit": item.unit,
                "range": item.range,
                "meaning": item.doc,
                "source": item.source,
            }
            for item in declarations(Config)
        }
        _print(json.dumps(listed, indent=1))


@app.command()
def orbit(
    aspect_ratio: Annotated[
        str, typer.Option(metavar="R", help="Length over width of the fiber, at least 1.")
    ],
    shear_rate: Annotated[
        str, typer.Option(metavar="RATE", help='Shear rate, such as 1 or "1 1/s".')
    ],
    viscosity: Annotated[
        str, typer.Option(metavar="MU", help='Viscosity of the melt, such as 817 or "817 Pa s".')
    ],
    model: Annotated[
        str,
        typer.Option(metavar="MODEL", help="confined-ellipse, ellipse or spheroid."),
    ] = "confined-ellipse",
    domain_size: Annotated[
        str,
        typer.Option(metavar="M", help="The cell's radius is M / 2 half-lengths; only confined."),
    ] = "4",
    angle: Annotated[
        str, typer.Option(metavar="DEG", help="Angle from the flow at the start, in degrees.")
    ] = "0",
    path: Annotated[
        str,
        typer.Option(metavar="PATH", help="superposition, or newton: the paper's own algorithm."),
    ] = "superposition",
    as_json: JsonOption = False,
) -> None:
    """Turn one fiber once in simple shear: its period, and the pressure extremes on it."""
    with _told():
        from fibermelt.study.orbit import (  # noqa: PLC0415  lazy, as in run
            OrbitStudy,
            orbit_in_words,
            read_quantity,
            run_orbit,
        )

        answer = run_orbit(
            OrbitStudy(
                aspect_ratio=read_quantity("--aspect-ratio", aspect_ratio, ""),
                shear_rate=read_quantity("--shear-rate", shear_rate, "1/s"),
                viscosity=read_quantity("--viscosity", viscosity, "Pa s"),
                model=model,
                domain_size=read_quantity("--domain-size", domain_size, ""),
                angle=read_quantity("--angle", angle, "rad", bare="deg"),
                path=path,
            )
        )
        _print(json.dumps(answer, indent=1) if as_json else orbit_in_words(answer))


@app.command()
def version(as_json: JsonOption = False) -> None:
    """Print the version."""
    with _told():
        from importlib.metadata import version as installed  # noqa: PLC0415  only here

        number = installed("fibermelt")
        _print(json.dumps({"fibermelt": number}) if as_json else f"fibermelt {number}")
