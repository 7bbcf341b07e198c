"""Commands for studies: `fibermelt run`, `validate` and `defaults`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import (
    INTERRUPTED,
    JsonOption,
    OutOption,
    OverOption,
    SetOption,
    StudyArgument,
    columns,
    complain,
    read_study,
    results_folder,
    say,
    told,
)
from fibermelt.errors import ConfigError, legible, legible_path

__all__ = ["defaults", "run", "validate"]


def run(
    study: StudyArgument,
    out: OutOption = None,
    sets: SetOption = None,
    as_json: JsonOption = False,
    fresh: Annotated[
        bool,
        typer.Option(
            "--fresh", help="Compute everything again, and replace what is stored and on show."
        ),
    ] = False,
) -> None:
    """Run a study into a results folder.

    What is stored there already is reused, so that an interrupted run goes on where it was.
    Progress goes to standard error, the numbers to standard output.
    """
    with told():
        from fibermelt.engine.parts import in_words  # noqa: PLC0415
        from fibermelt.engine.progress import observing  # noqa: PLC0415
        from fibermelt.engine.runner import run_study  # noqa: PLC0415
        from fibermelt.report.page import draw, render  # noqa: PLC0415  lazy: help needs none
        from fibermelt.study.chain import CHAIN  # noqa: PLC0415
        from fibermelt.study.loading import replaces_another  # noqa: PLC0415

        resolved = read_study(study, sets)
        if resolved.sweep is not None:
            msg = (
                f"{legible(study, len(study))}: has a table [sweep], and so is many studies: use "
                "fibermelt sweep, or fibermelt plan to see its cases"
            )
            raise ConfigError(msg)
        folder = results_folder(out, resolved.name)
        if out is None and sets and replaces_another(folder, resolved.config):
            complain(
                f"note: {legible_path(folder)} shows a run of other parameters, which this one "
                "replaces; name another folder with --out to keep both"
            )
        try:
            with observing() as observer:
                summary = run_study(
                    resolved,
                    folder,
                    CHAIN,
                    draw=draw,
                    report=render,
                    fresh=fresh,
                    observer=observer,
                )
        except KeyboardInterrupt:
            complain("interrupted: finished stages are kept, the same command goes on from them")
            raise typer.Exit(INTERRUPTED) from None
        words = in_words(summary, CHAIN, resolved, folder, columns())
        say(json.dumps(summary, indent=1) if as_json else words)


def validate(
    study: StudyArgument,
    sets: SetOption = None,
    over: OverOption = None,
    as_json: JsonOption = False,
) -> None:
    """Check a study without running it.

    Every fault is told on a line of its own; of a sweep every case is looked at. With --json: all
    parameters as resolved, in SI.
    """
    with told():
        from fibermelt.engine.parameters import flatten  # noqa: PLC0415
        from fibermelt.engine.wrapping import unbroken, wrapped  # noqa: PLC0415
        from fibermelt.sweeps.design import read_sweep  # noqa: PLC0415

        resolved = read_study(study, sets, over)
        swept = None if resolved.sweep is None else read_sweep(resolved)
        # Drawn one by one: a case that is no valid study ends this with its reason.
        count = sum(1 for _ in swept.stream()) if swept else 1
        if as_json:
            cases = {} if swept is None else {"cases": count}
            say(json.dumps({**flatten(resolved.config), **cases}, indent=1))
            return
        what = "study" if swept is None else f"sweep of {_counted(count)} over {swept.told()}"
        shown = unbroken(legible(study, len(study)))
        lines = [f"{shown}: a valid {what} ({resolved.origin})"]
        lines += [f"note            {note}" for note in resolved.config.notes()]
        say(wrapped(lines, columns()))


def _counted(cases: int) -> str:
    return f"{cases} case{'' if cases == 1 else 's'}"


def defaults(as_json: JsonOption = False) -> None:
    """Print every parameter of a study.

    With its meaning, unit, range, default and source, as TOML: a study file to begin with.
    """
    with told():
        from fibermelt.engine.parameters import declarations  # noqa: PLC0415
        from fibermelt.engine.toml import defaults_toml  # noqa: PLC0415
        from fibermelt.study.config import Config  # noqa: PLC0415  lazy, as in run

        if not as_json:
            say(defaults_toml(Config), newline=False)
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
        say(json.dumps(listed, indent=1))
