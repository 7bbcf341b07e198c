"""Commands that take results elsewhere: `fibermelt export`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, given_folder, say, told
from fibermelt.errors import ConfigError, legible_path

__all__ = ["export"]

EXPORT = "export"
"""What the exported folder is called in a results folder."""


def export(
    directory: Annotated[
        str, typer.Argument(metavar="DIR", help="Results folder of `fibermelt run`.")
    ],
    to: Annotated[
        str | None,
        typer.Option("--to", metavar="FOLDER", help="Where to; DIR/export by default."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Write the results of a run for other programs.

    Every variable in a CSV table, in SI, units in the head; streamlines with the pressures on their
    fibers as streamlines.vtp, for ParaView. What each column means is in export.json.
    """
    with told():
        if to is not None and not to.strip():
            msg = '--to "": is no name of a folder; write one, or leave --to away'
            raise ConfigError(msg)
        from fibermelt.report.export import LINES, export_run  # noqa: PLC0415  lazy, as in run

        folder = given_folder(directory)
        found = export_run(folder, Path(to) if to else folder / EXPORT)
        if as_json:
            say(json.dumps(found, indent=1))
            return
        counted = f"{sum(name != LINES for name in found['files'])} tables"
        lines = f" and {LINES}" if LINES in found["files"] else ""
        say(
            f"written         {counted}{lines}, {found['bytes'] / 1e6:.1f} MB\n"
            f"folder          {legible_path(Path(found['folder']))}"
        )
