"""`fibermelt version`, and `fibermelt --version`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, say, told

__all__ = ["options", "version"]


def _print_version(asked: bool) -> None:
    """Print the version and stop, where `--version` asks for it."""
    if asked:
        version()
        raise typer.Exit


def options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Take what is said before a command."""


def version(as_json: JsonOption = False) -> None:
    """Print the version of fibermelt."""
    with told():
        from importlib.metadata import version as installed  # noqa: PLC0415  only here

        number = installed("fibermelt")
        say(json.dumps({"fibermelt": number}) if as_json else f"fibermelt {number}")
