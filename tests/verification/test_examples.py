"""Every example runs, and what it finds is checked."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_no_example_is_missing_here() -> None:
    assert {path.name for path in EXAMPLES.glob("*.py")} == {"lowest_pressure.py"}


def test_lowest_pressure(capsys: pytest.CaptureFixture[str]) -> None:
    """Only below the nozzle does the pressure fall below the air's (the paper's Fig. 16)."""
    names = runpy.run_path(str(EXAMPLES / "lowest_pressure.py"))
    in_nozzle, in_bead = names["lowest"]
    assert in_nozzle > 0 > in_bead
    assert "MPa in the bead" in capsys.readouterr().out
    # every fiber's extreme lies within the bound over every orientation
    line, cell = names["line"], names["cell"]
    bound = names["fm"].pressure_bounds(line.history, cell.response, 817.0)
    assert names["pressure"].lowest.min() >= bound.lowest.min()
