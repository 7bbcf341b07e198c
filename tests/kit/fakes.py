"""A chain of stages that cost nothing, for what the runner and the store do with any chain."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from fibermelt.engine.parts import Chain, Part
from fibermelt.engine.runner import run_study
from fibermelt.engine.stages import Parameters, Stage
from fibermelt.errors import ConvergenceError
from fibermelt.study.loading import load_study

UNITS = {"units": "m", "long_name": "a number that tells where it came from"}


def hears_ctrl_c() -> None:
    """Undo what a shell does to its jobs in the background: they ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def process_of(say: object) -> int:
    """Return the number of the process that is asked."""
    return os.getpid()


def scalar(name: str, value: float) -> xr.Dataset:
    return xr.Dataset({name: ((), value, UNITS)})


def flow(parameters: Parameters, inputs: object, say: object) -> xr.Dataset:
    say("mesh 1 of 1, Newton step 1: residual 1.0e-10")
    if parameters["flow.gap"] < 2.1e-3:
        msg = "flow.gap = 0.002 m: no steady surface; try a larger gap"
        raise ConvergenceError(msg)
    return scalar("bead", 2 * parameters["flow.gap"])


def cell(parameters: Parameters, inputs: object, say: object) -> xr.Dataset:
    return scalar("shape", parameters["fiber.aspect_ratio"])


def motion(parameters: Parameters, inputs: dict[str, xr.Dataset], say: object) -> xr.Dataset:
    if marker := os.environ.get("FAKE_MOTION_WAITS"):
        Path(marker).touch()
        time.sleep(600)  # far longer than who kills it takes to notice
    return scalar("extreme", float(inputs["flow"]["bead"] * inputs["cell"]["shape"]))


def summarize(results: xr.Dataset) -> dict[str, object]:
    return {"extreme": float(results["extreme"])}


def words(summary: Mapping[str, object]) -> list[str]:
    return [f"extreme {summary['extreme']:g}"]


def write_fields(results: xr.Dataset, folder: Path) -> None:
    (folder / "flow.vtu").write_text("<VTKFile/>")


def draw(results: xr.Dataset, folder: Path) -> list[Path]:
    figure = folder / "bead.svg"
    figure.write_text("<svg/>")
    return [figure]


STAGES = (
    Stage("flow", 1, ("flow", "melt"), (), flow),
    Stage("cell", 1, ("fiber.aspect_ratio",), (), cell),
    Stage("motion", 1, ("fiber.initial_angles",), ("flow", "cell"), motion),
)
CHAIN = Chain(STAGES, (Part("bead", ("motion",), summarize, words, write_fields),), 1)


class Notes:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def step(self, stage: str, line: str) -> None:
        self.lines.append(f"{stage}: {line}")

    tick = done = step

    def reused(self) -> list[str]:
        return [line.split(":")[0] for line in self.lines if "reused" in line]


def run(folder: Path, *overrides: str, chain: Chain = CHAIN, fresh: bool = False) -> Notes:
    notes = Notes()
    study = load_study("paper", overrides)
    run_study(study, folder, chain, draw=draw, fresh=fresh, observer=notes)
    return notes


if __name__ == "__main__":
    run(Path(sys.argv[1]))
