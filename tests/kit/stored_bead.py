"""The made-up bead as a finished run: results with a study, a summary, and a folder of both."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from drawn_bead import ASPECT, made_up

from fibermelt.engine.files import write_through
from fibermelt.engine.netcdf import to_bytes
from fibermelt.engine.outputs import publish
from fibermelt.engine.quantities import labelled
from fibermelt.engine.schema import SCHEMA
from fibermelt.engine.store import Store
from fibermelt.engine.tables import Tables
from fibermelt.engine.toml import resolved_toml
from fibermelt.paper.claims.conditions import conditions_of
from fibermelt.parts.bead.summary import summarize_bead
from fibermelt.report.page.figures import draw_figures
from fibermelt.study.config import Config
from fibermelt.study.quantities import QUANTITIES

CLAIMS = [
    {
        "id": "period",
        "section": "Section 2.4",
        "statement": "A period at 1 1/s.",
        "paper": "38.75 s",
        "ours": 38.74,
        "verdict": "holds",
        "reason": "",
    },
    {
        "id": "uniform",
        "section": "Section 3",
        "statement": "Minima are uniform.",
        "paper": -0.5,
        "ours": -0.39,
        "verdict": "differs",
        "reason": "by 0.11 MPa",
    },
]


def stored_results(
    count: int = 6, angles: int = 3, name: str = "made up", config: Tables | None = None
) -> xr.Dataset:
    """Return results as results.nc holds them, study included."""
    bare = made_up(count=count, angles=angles)
    more: dict[str, Any] = {
        "bead_height": 3e-3,
        "contact_point_error": 2e-6,
        "mass_imbalance": 1e-10,
        "kinematic_residual": 2e-5,
        "newton_steps": 9,
        "stream_function_drift": np.zeros(count),
        "shape_factor": 0.95,
        "shape_factor_error": 1e-6,
        "stall_angle": np.nan,
        "tip_pressure": 2 * ASPECT,
        "tip_pressure_error": 1e-4,
    }
    results = bare.assign(
        labelled({name: more[name] for name in more if name not in bare}, QUANTITIES)
    )
    study = config or Config()
    results.attrs = {
        "title": f"fibermelt study {name}",
        "schema": SCHEMA,
        "config": resolved_toml(study, f"The study {name} (made.toml) as it was run, in SI."),
        **conditions_of(study),
        "software": json.dumps({"python": "3.11.7", "fibermelt": "0.1.0"}),
    }
    return results


def stored_summary(results: xr.Dataset, *, claims: bool = True) -> dict[str, Any]:
    """Return the summary of such results."""
    summary: dict[str, Any] = {"schema": SCHEMA, **summarize_bead(results)}
    if claims:
        summary["claims"] = CLAIMS
    return {**summary, "cost": {"flow": 8.7, "total": 12.3}}


def store(folder: Path, *, drawn: bool = True) -> Path:
    """Make a folder that holds a finished run, with its figures or an empty one, and return it."""
    results = stored_results()

    def write(into: Path) -> None:
        write_through(into / "results.nc", to_bytes(results))
        write_through(into / "summary.json", json.dumps(stored_summary(results)).encode())
        (into / "figures").mkdir()
        if drawn:
            draw_figures(results, into / "figures")
        else:
            (into / "figures/overview.svg").write_text("<svg/>")

    publish(Store.open(folder).directory, "key", write)
    return folder
