"""The claims as a stage: what they are judged by, measured on the results of the other parts.

What computes is imported when the stage runs, so that a study that is stored costs nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.stages import Inputs, Parameters, Say
from fibermelt.engine.toml import as_toml
from fibermelt.paper.claims.judge import claims, measured
from fibermelt.parts.variables import labelled

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.parameters import Value

__all__ = ["CLAIM_TABLES", "STAGES_OF", "claims_stage", "fed_by_parts"]

CLAIM_TABLES = ("flow", "fiber", "interaction")
"""What of a study the quantities read besides the results."""

STAGES_OF = {
    "bead": ("streamlines", "motion"),
    "interaction": ("content", "interaction", "stall"),
    "orbits": ("orbits",),
    "voids": ("streamlines", "voids"),
}
"""The stages that claims are judged by, by the part of a study that has them."""


def fed_by_parts(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return the stages that the claims are fed, as far as a study has their parts."""
    parts: Any = values["study.parts"]
    asked = [name for part, names in STAGES_OF.items() if part in parts for name in names]
    return tuple(dict.fromkeys(asked))


def claims_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Measure what the paper's claims are judged by."""
    import numpy as np  # noqa: PLC0415  lazy, as in the other stages
    import xarray as xr  # noqa: PLC0415

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
        }
    )
