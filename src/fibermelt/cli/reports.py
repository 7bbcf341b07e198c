"""Commands for finished runs: `fibermelt report`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, say, told
from fibermelt.errors import legible

__all__ = ["report"]


def report(
    directory: Annotated[
        str, typer.Argument(metavar="DIR", help="A results folder that `fibermelt run` wrote.")
    ],
    as_json: JsonOption = False,
) -> None:
    """Write the report of a finished run: one HTML file that needs nothing else."""
    with told():
        from fibermelt.report.html import write_report  # noqa: PLC0415  lazy, as in run

        path = write_report(Path(directory))
        size = path.stat().st_size
        shown = legible(str(path), len(str(path)))
        say(json.dumps({"report": str(path), "bytes": size}) if as_json else shown)
