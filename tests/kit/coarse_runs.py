"""The coarse study in seconds, and commands: each in a process of its own, or in this one.

A process takes longer to load, to draw and to make its page than the coarse study to compute: that
is for tests of what a process leaves. For what a command says there is `here`, for what a study
comes to `computed`.
"""

import contextlib
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr
from fakes import Notes
from patience import PATIENCE
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.runner import run_study
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study

COARSE = Path(__file__).parent / "coarse.toml"
ONE_THREAD = {**os.environ, "OMP_NUM_THREADS": "1"}


def fibermelt(*arguments, folder):
    """Run a command in a folder, with one thread in the solvers."""
    return subprocess.run(
        [sys.executable, "-m", "fibermelt", *map(str, arguments)],
        cwd=folder,
        env=ONE_THREAD,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
    )


def here(*arguments, folder):
    """Run a command in a folder and in this process; what it does not catch is raised."""
    with contextlib.chdir(folder):
        done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return subprocess.CompletedProcess(arguments, done.exit_code, done.stdout, done.stderr)


@dataclass(frozen=True)
class Computed:
    """A run without figures and page: what it stored, and what it told on the way."""

    summary: dict[str, Any]
    results: xr.Dataset
    told: list[str]

    def drawn(self) -> set[str]:
        """Draw every figure that the results are enough for, into no file, and tell their names."""
        from fibermelt.report.page.figures import FIGURES  # noqa: PLC0415  matplotlib, only here

        plates = [plate for plate in FIGURES if plate.is_of(self.results)]
        for plate in plates:
            plate.draw(self.results)
            assert plate.words(self.results).caption
        return {plate.name for plate in plates}


def computed(study, out, *overrides, fresh=False) -> Computed:
    """Run a study in this process, and read back what it stored."""
    notes = Notes()
    run_study(load_study(str(study), overrides), out, CHAIN, fresh=fresh, observer=notes)
    with xr.open_dataset(out / "results.nc", engine="h5netcdf") as results:
        return Computed(json.loads((out / "summary.json").read_text()), results.load(), notes.lines)
