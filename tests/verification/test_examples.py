"""Every example runs, and what it finds is checked."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_no_example_is_missing_here() -> None:
    names = {"content_to_cell.py", "lowest_pressure.py", "one_turn.py", "sweep_on_slurm.py"}
    assert {path.name for path in EXAMPLES.glob("*.py")} == names


def test_one_turn(capsys: pytest.CaptureFixture[str]) -> None:
    """Table 1 prints 38.75 s by Jeffery and 39.53 s by finite elements."""
    names = runpy.run_path(str(EXAMPLES / "one_turn.py"))
    turns = names["turns"]
    assert turns["ellipse"].period == pytest.approx(38.75, abs=0.005)
    assert turns["in its cell"].period == pytest.approx(39.53, rel=2e-3)
    assert turns["ellipse"].min_pressure == pytest.approx(-817.0 * 7, rel=1e-12)
    assert turns["spheroid"].min_pressure == pytest.approx(-817.0 * 15.5337, rel=1e-5)
    assert np.allclose(names["angle"][[0, 2, 4, 8]], [0, -90, -180, -360], atol=1e-6)
    assert "deg" in capsys.readouterr().out


def test_content_to_cell(capsys: pytest.CaptureFixture[str]) -> None:
    """The paper finds M = 4.08, with its own rate of deformation."""
    sizes = runpy.run_path(str(EXAMPLES / "content_to_cell.py"))["sizes"]
    assert sizes["paper"] == pytest.approx(4.08, abs=0.1)
    assert sizes["standard"] > sizes["paper"] + 0.3
    assert "C_I = 0.0128" in capsys.readouterr().out


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
