"""A population from the study file to its quantiles and back, with a response in closed form."""

import json

import fake_sweeps
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.parts import Chain, Part
from fibermelt.engine.stages import Stage
from fibermelt.sweeps.collect import collect_sweep
from fibermelt.sweeps.distributions import Truncated, Weibull
from fibermelt.sweeps.quantiles import LEVELS, quantiles
from fibermelt.sweeps.record import restored
from fibermelt.sweeps.store import CaseStore

pytestmark = pytest.mark.end_to_end

SAMPLES, RATE = 64, 2.0
SWEPT = f"""preset = "paper"
study.parts = ["bead"]
[sweep]
"fiber.aspect_ratio" = {{ scale = 7, shape = 2, between = [1, 50] }}
design = "sobol"
samples = {SAMPLES}
seed = 5
weight = "fiber.aspect_ratio"
"""


def shear(parameters, inputs, say):
    """Return the lowest pressure on an ellipse in simple shear [Pa], -mu gamma_dot (1 + r_e)."""
    value = -parameters["melt.viscosity"] * RATE * (1 + parameters["fiber.aspect_ratio"])
    told = {"units": "Pa", "long_name": "lowest surface pressure in simple shear"}
    return xr.Dataset({"shear_lowest": ((), value, told)})


CHAIN = Chain(
    (Stage("shear", 1, ("melt.viscosity", "fiber.aspect_ratio"), (), shear),),
    (Part("bead", ("shear",), lambda results: {}, lambda summary: []),),
    1,
)


@pytest.fixture
def swept(tmp_path, monkeypatch):
    monkeypatch.setattr("fibermelt.study.chain.CHAIN", CHAIN)
    study, out = fake_sweeps.study_file(tmp_path, SWEPT), tmp_path / "out"
    planned = CliRunner().invoke(app, ["plan", str(study)])
    told = "fiber.aspect_ratio: Weibull, scale 7, shape 2, between 1 and 50 (98 % of it)"
    assert told in " ".join(planned.stdout.split())
    done = CliRunner().invoke(app, ["sweep", str(study), "--out", str(out), "--workers", "0"])
    assert done.exit_code == 0, done.output
    return out


def test_a_population_is_run_collected_and_gone_on_with(swept):
    collected = collect_sweep(swept)
    ratio = Truncated(Weibull(7.0, 2.0), 1.0, 50.0)
    found = quantiles(collected["shear_lowest"].to_numpy())
    for level, value in zip(LEVELS, found, strict=True):
        # A Sobol sequence has one sample in each of 64 strata: one more or less bounds it.
        shares = np.clip([1 - level + 1 / SAMPLES, 1 - level - 1 / SAMPLES], 0, 1)
        low, high = (-817.0 * RATE * (1 + ratio.at(share)) for share in shares)
        assert low <= value <= high
    asked = json.loads(collected.attrs["sweep"])
    assert (asked["seed"], asked["weight"]) == (5, "fiber.aspect_ratio")
    sweep, study = restored(CaseStore(swept))
    assert (sweep.weight, sweep.seed, study.sweep) == ("fiber.aspect_ratio", 5, asked)
