"""The claims as a stage: what they are judged by, measured on the results of the other parts."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Parameters, Say
from fibermelt.engine.toml import as_toml
from fibermelt.paper.claims.judge import claims, measured
from fibermelt.paper.claims.quantities import QUANTITIES

__all__ = ["claims_stage"]


def claims_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Measure what the paper's claims are judged by."""
    results = xr.merge(
        inputs.values(), combine_attrs="drop", compat="identical", join="exact"
    ).assign_attrs(config=as_toml(parameters))
    found = [measured(claim, results) for claim in claims()]
    say(f"{np.count_nonzero([not missing for _, missing in found])} of {len(found)} claims")
    return labelled(
        {
            "claim": [claim.id for claim in claims()],
            "claim_value": [value for value, _ in found],
            "claim_missing": [missing for _, missing in found],
        },
        QUANTITIES,
    )
