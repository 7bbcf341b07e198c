"""The command line: thin, and a person's mistake never ends in a traceback.

Exit codes: 0 all done; 1 it ran, but not all came out: a run whose flow has no answer, a sweep with
a case that has none or is not finished, a check of `fibermelt verify` that fails; 2 what it was
given is of no use, with one line for each fault on standard error; 130 interrupted; 143 and 129 a
sweep that was told to end (SIGTERM), and one whose terminal was closed (SIGHUP).
"""

from __future__ import annotations

import typer

from fibermelt.cli.checks import verify
from fibermelt.cli.exports import export
from fibermelt.cli.fibers import domain_size, orbit, orientation
from fibermelt.cli.fields import fields
from fibermelt.cli.plans import plan
from fibermelt.cli.reports import report
from fibermelt.cli.signals import stand_in_for_closed
from fibermelt.cli.studies import defaults, run, validate
from fibermelt.cli.sweeps import clean, collect, resume, status, sweep
from fibermelt.cli.versions import options, version
from fibermelt.cli.voids import voids

__all__ = ["app", "main"]

app = typer.Typer(
    help="Where a short-fiber polymer bead will void. Begin with: fibermelt run paper",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.callback()(options)
COMMANDS = (
    *(run, report, export, voids, fields, validate, defaults),
    *(plan, sweep, status, resume, collect, clean),
    *(orbit, orientation, domain_size),
    *(verify, version),
)
for command in COMMANDS:
    app.command()(command)


def main() -> None:
    """Run the command line, once it is loaded: `fibermelt.__main__` begins before that."""
    stand_in_for_closed()
    app()
