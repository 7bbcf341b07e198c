"""The command line: thin, and a person's mistake never ends in a traceback.

Exit codes: 0 done; 2 what the user can cause or cure, with one line for each fault on standard
error; 130 interrupted.
"""

from __future__ import annotations

import typer

from fibermelt.cli.fibers import orbit
from fibermelt.cli.studies import defaults, run, validate
from fibermelt.cli.sweeps import clean, collect, plan, resume, status, sweep
from fibermelt.cli.versions import options, version

__all__ = ["app", "main"]

app = typer.Typer(
    help="Where a short-fiber polymer bead will void.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.callback()(options)
_STUDIES = (run, validate, defaults, orbit)
_SWEEPS = (plan, sweep, status, resume, collect, clean)
for command in (*_STUDIES, *_SWEEPS, version):
    app.command()(command)


def main() -> None:
    """Run the command line."""
    app()
