"""`fibermelt verify`: what is known by other ways, checked on this machine."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import INCOMPLETE, INTERRUPTED, JsonOption, columns, say, told

__all__ = ["verify"]


def verify(
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="Leave out what takes more than a few seconds: about 10 s in all."
        ),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Check this installation against what is known.

    Exact solutions and independent paths: each check is a number with a bound that was stated
    before, an error or an observed order of convergence. The exit code is 1 if one fails.
    """
    with told():
        from fibermelt.engine.progress import observing  # noqa: PLC0415  lazy: help needs none
        from fibermelt.engine.wrapping import wrapped  # noqa: PLC0415
        from fibermelt.verify.ladder import climb  # noqa: PLC0415
        from fibermelt.verify.rungs import LADDER  # noqa: PLC0415
        from fibermelt.verify.words import as_answer, in_words  # noqa: PLC0415

        try:
            with observing() as observer:
                checks = climb(LADDER, quick=quick, say=observer.step)
        except KeyboardInterrupt:
            raise typer.Exit(INTERRUPTED) from None
        if as_json:
            say(json.dumps(as_answer(checks), indent=1, allow_nan=False))
        else:
            say(wrapped(in_words(checks).split("\n"), columns()))
        if not all(check.passed for check in checks):
            raise typer.Exit(INCOMPLETE)
