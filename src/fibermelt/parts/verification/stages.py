"""The verification ladder as a stage, so that a study can show what its installation was held to.

What loads the finite elements is imported where it is used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Parameters, Say
from fibermelt.parts.verification.quantities import QUANTITIES
from fibermelt.verify.ladder import as_dataset_rows, chosen, climb
from fibermelt.verify.words import versions

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["verification_stage"]


def verification_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Climb the ladder as far as the study says; a check that fails is stored as such."""
    from fibermelt.verify.rungs import LADDER  # noqa: PLC0415

    extent = parameters["study.ladder"]
    checks = climb(chosen(LADDER, extent), say=lambda subject, name: say(f"{subject}: {name}"))
    rows = {f"check_{column}": values for column, values in as_dataset_rows(checks).items()}
    software = ", ".join(f"{name} {number}" for name, number in versions().items())
    return labelled({**rows, "check_ladder": extent, "check_software": software}, QUANTITIES)
