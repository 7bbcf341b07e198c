"""A chain that costs what it is told to, and tells what it computed: for sweeps that are killed.

Run as a script it is a client: ``fake_sweeps.py DIR --workers N`` or ``--scheduler ADDR``.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import xarray as xr

from fibermelt.engine.parts import Chain, Part
from fibermelt.engine.stages import Neighbour, Parameters, Stage
from fibermelt.errors import ConvergenceError, FibermeltError
from fibermelt.study.loading import load_study
from fibermelt.sweeps.collect import collect_sweep
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.runner import run_sweep

SWEPT = """preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.gap" = ["2 mm", "3 mm", "3.5 mm", "4 mm"]
"fiber.aspect_ratio" = { from = 2, to = 10, count = 24 }
"""
CASES, FAILED = 96, 24
"""Of `SWEPT`: a gap of 2 mm has no answer, whatever the fiber."""

LEADS_NOWHERE = 4.7e-3
"""A gap [m] whose flow no neighbour leads to."""

PAYLOAD = 2000
"""Numbers that a flow writes beside what is asked of it: 16 kB, so that a disk can fill."""


def _note(stage: str, value: object) -> None:
    """Tell that a stage is computed, in one line that cannot be torn."""
    if log := os.environ.get("FAKE_LOG"):
        line = f"{os.getpid()} {stage} {value}\n".encode()
        descriptor = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(descriptor, line)
        os.close(descriptor)
        _wait_at_the_gate(Path(log))
    time.sleep(float(os.environ.get(f"FAKE_{stage.upper()}_TAKES", "0")))


def _wait_at_the_gate(log: Path) -> None:
    """Wait for a file, if there is one to wait for, once so many stages were begun."""
    gate, patience = os.environ.get("FAKE_GATE"), time.monotonic() + 600
    if gate and len(log.read_text().splitlines()) > int(os.environ["FAKE_GATE_AFTER"]):
        while not Path(gate).exists() and time.monotonic() < patience:
            time.sleep(0.01)


def _labelled(**arrays: object) -> xr.Dataset:
    about = {"units": "Pa", "long_name": "a number that tells where it came from"}
    return xr.Dataset({name: (*value, about) for name, value in arrays.items()})


def flow(parameters: Parameters, inputs: object, say: object) -> xr.Dataset:
    gap = parameters["flow.gap"]
    _note("flow", gap)
    if gap < 2.1e-3:
        msg = "flow.gap = 0.002 m: no steady surface; try a larger gap"
        raise ConvergenceError(msg)
    return _labelled(
        bead=((), 2 * gap), trace=((), gap), field=(("node",), np.arange(PAYLOAD) * gap)
    )


def flow_from(
    parameters: Parameters, inputs: object, say: object, neighbour: Neighbour
) -> tuple[xr.Dataset, bool]:
    """Find what is found from cold, and tell from where it started, and that from where.

    Where it leads nowhere the flow is that from cold.
    """
    found = flow(parameters, inputs, say)
    if parameters["flow.gap"] == LEADS_NOWHERE:
        return found, False
    return found.assign(trace=found["trace"] + 1e-2 * neighbour.data["trace"].values), True


def cell(parameters: Parameters, inputs: object, say: object) -> xr.Dataset:
    return _labelled(shape=((), np.sqrt(parameters["fiber.aspect_ratio"])))


def motion(parameters: Parameters, inputs: dict[str, xr.Dataset], say: object) -> xr.Dataset:
    bead, shape = float(inputs["flow"]["bead"]), float(inputs["cell"]["shape"])
    _note("motion", f"{bead:.17g}-{shape:.17g}")
    angles = np.asarray(parameters["fiber.initial_angles"])
    return _labelled(
        kind=(("kind",), ["min", "max"]),
        extreme=(("initial_angle", "kind"), np.stack([np.sin(angles), np.cos(angles)], 1) * bead),
        product=((), bead * shape),
        path=(("point",), np.arange(10) * bead),
    )


STAGES = (
    Stage("flow", 1, ("flow", "melt"), (), flow, compute_from=flow_from),
    Stage("cell", 1, ("fiber.aspect_ratio",), (), cell, light_if=lambda values: True),
    Stage("motion", 1, ("fiber.initial_angles",), ("flow", "cell"), motion),
)
CHAIN = Chain(STAGES, (Part("bead", ("motion",), lambda results: {}, lambda summary: []),), 1)


class Notes:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def step(self, stage: str, line: str) -> None:
        """Ignore it."""

    tick = step

    def done(self, stage: str, line: str) -> None:
        self.lines.append(f"{stage}: {line}")


def study_file(folder: Path, text: str = SWEPT) -> Path:
    path = folder / "swept.toml"
    path.write_text(text)
    return path


def sweep(study: Path, out: Path, **options: object) -> tuple[dict[str, object], list[str]]:
    """Run a sweep in this process unless told otherwise; return its summary and what was said."""
    swept, notes = load_study(str(study)), Notes()
    options = {"workers": 0, **options}
    summary = run_sweep(read_sweep(swept), swept, out, CHAIN, observer=notes, **options)
    return summary, notes.lines


def assert_same(found: Path, expected: Path) -> None:
    """Assert that two sweeps have the same config to the last bit, and numbers to 1e-10."""
    one, other = collect_sweep(found), collect_sweep(expected)
    assert one.attrs == other.attrs
    assert set(one.variables) == set(other.variables)
    for name, variable in other.variables.items():
        assert one[name].dims == variable.dims
        assert one[name].attrs == variable.attrs
        if name in other.coords or variable.dtype.kind in "OUS":
            np.testing.assert_array_equal(one[name].values, variable.values)
        else:
            np.testing.assert_allclose(one[name].values, variable.values, rtol=1e-10, atol=0)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("study", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--scheduler")
    given = parser.parse_args()
    try:
        summary, _ = sweep(given.study, given.out, workers=given.workers, scheduler=given.scheduler)
    except FibermeltError as error:
        sys.exit(str(error))
    sys.stdout.write(json.dumps(summary))


if __name__ == "__main__":
    # Its functions must have the name under which a worker imports them.
    import fake_sweeps

    fake_sweeps.main()
