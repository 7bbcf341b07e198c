"""Every variable of results.nc, declared once by its part: its dimensions, unit and meaning."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from fibermelt.engine.parameters import Section
from fibermelt.errors import StoreError
from fibermelt.paper.claims.variables import CLAIM_VARIABLES
from fibermelt.paper.orbits.variables import SENSITIVITY_VARIABLES
from fibermelt.parts.bead.variables import BEAD_VARIABLES
from fibermelt.parts.orientation.variables import ORIENTATION_VARIABLES
from fibermelt.parts.thinning.variables import EFFECT_VARIABLES
from fibermelt.parts.verification.variables import VERIFICATION_VARIABLES
from fibermelt.parts.voids.variables import VOID_VARIABLES

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["VARIABLES", "has_conditions_of_paper", "labelled", "or_none", "study_of", "table_of"]

Table = TypeVar("Table", bound=Section)

VARIABLES: Mapping[str, tuple[str, str, str]] = {
    **BEAD_VARIABLES,
    **CLAIM_VARIABLES,
    **EFFECT_VARIABLES,
    **ORIENTATION_VARIABLES,
    **SENSITIVITY_VARIABLES,
    **VOID_VARIABLES,
    **VERIFICATION_VARIABLES,
}
"""``{name: (dimensions, unit, long name)}``; a pure number has the unit 1."""


def labelled(arrays: Mapping[str, Any]) -> xr.Dataset:
    """Return arrays as a dataset with the declared dimensions, units and long names.

    Parameters
    ----------
    arrays : mapping
        Arrays and numbers by the names of `VARIABLES`.

    Raises
    ------
    StoreError
        If a name is not declared, or an array has not the declared number of dimensions.
    """
    import numpy as np  # noqa: PLC0415  lazy: a run that finds everything done needs neither
    import xarray as xr  # noqa: PLC0415

    variables = {}
    for name, values in arrays.items():
        if name not in VARIABLES:
            msg = f"results: variable {name} is not declared: add it to the variables of its part"
            raise StoreError(msg)
        dimensions, unit, long_name = VARIABLES[name]
        array = np.asarray(values)
        if array.ndim != len(dimensions.split()):
            msg = f"results: {name} has shape {array.shape}, declared are ({dimensions})"
            raise StoreError(msg)
        attributes = {"units": unit, "long_name": long_name}
        variables[name] = (tuple(dimensions.split()), array, attributes)
    return xr.Dataset(variables)


def or_none(value: Any) -> float | None:
    """Return a number of the results, None for the NaN of what does not exist."""
    number = float(value)
    return None if math.isnan(number) else number


def study_of(results: xr.Dataset) -> dict[str, Any]:
    """Return the study that results hold as tables, in SI; empty if they hold none."""
    return tomllib.loads(results.attrs.get("config", ""))


def table_of(results: xr.Dataset, name: str, kind: type[Table]) -> Table:
    """Return a table of the study that results hold; what they do not hold has its default."""
    return kind.model_validate(study_of(results).get(name, {}))


def has_conditions_of_paper(results: xr.Dataset) -> bool:
    """Tell whether results are of the paper's study, whatever parts of it were computed."""
    return results.attrs.get("conditions") == "paper"
