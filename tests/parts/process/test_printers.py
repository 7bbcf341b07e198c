"""The printers that ship are solved, coarsely, and their results say what they were made of."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from coarse_runs import COARSE

from fibermelt.engine.runner import run_study
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study

pytestmark = pytest.mark.end_to_end


@pytest.mark.parametrize("name", ["pellet", "filament"])
def test_a_printer_lays_its_layer(name: str, tmp_path: Path) -> None:
    coarse = tomllib.loads(COARSE.read_text(encoding="utf-8"))
    tables = {table: coarse[table] for table in ("fiber", "streamlines", "numerics")}
    study = load_study(name, tables)
    summary = run_study(study, tmp_path, CHAIN)
    flow = study.config.flow
    # The outlet closes the mass balance to 1e-6 on the coarsest mesh (`FLUX_BOUND`).
    assert summary["flow"]["bead_height"] == pytest.approx(flow.bead_height, rel=1e-5)
    assert 0.9 * flow.gap < flow.bead_height < 1.1 * flow.gap
    assert summary["notes"] == study.config.notes()
    assert json.loads((tmp_path / "summary.json").read_text())["notes"] == summary["notes"]
    copy = load_study(str(tmp_path / "config.toml"))
    assert copy.config == study.config
    assert run_study(copy, tmp_path, CHAIN) == summary  # nothing of it is computed again
