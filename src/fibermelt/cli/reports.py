"""Commands for finished runs: `fibermelt report`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, given_folder, say, told
from fibermelt.errors import legible_path

__all__ = ["report"]


def report(
    directory: Annotated[
        str,
        typer.Argument(
            metavar="DIR", help="Results folder of `fibermelt run` or `fibermelt sweep`."
        ),
    ],
    as_json: JsonOption = False,
) -> None:
    """Write the report of a run or a sweep.

    It is DIR/report.html, one file that needs no other; every finished run has one already.
    """
    with told():
        from fibermelt.engine.outputs import has_run  # noqa: PLC0415
        from fibermelt.report.page.page import write_report  # noqa: PLC0415  lazy, as in run
        from fibermelt.report.sweep.page import write_sweep_report  # noqa: PLC0415
        from fibermelt.sweeps.store import CaseStore  # noqa: PLC0415

        folder = given_folder(directory)
        is_sweep = (folder / "sweep.json").exists()
        # A sweep that lost sweep.json is told how to get it back.
        is_run = has_run(folder) or not CaseStore(folder).is_begun()
        path = write_report(folder) if is_run else write_sweep_report(folder).path
        answer: dict[str, str | int] = {"report": str(path), "bytes": path.stat().st_size}
        lines = [legible_path(path)]
        if is_sweep and is_run:
            # A run into the folder of a sweep has the name report.html for itself.
            beside = write_sweep_report(folder).path
            answer["sweep_report"] = str(beside)
            lines.append(legible_path(beside))
        say(json.dumps(answer) if as_json else "\n".join(lines))
