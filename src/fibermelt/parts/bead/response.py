"""The fiber's answers in a melt that thins, as a stage: a table over rate and direction.

It depends on fiber, cell and law and on nothing of the flow, so that all flows of a melt share it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.parts.bead.quantities import QUANTITIES
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.parts.bead.stages import domain_size, sizes_of, thinning_numerics
from fibermelt.parts.melt.melt import law_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw

__all__ = ["response_estimates", "response_stage", "thinning_response"]


def response_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Find the fiber's answers in the study's melt, over rates and directions."""
    law = law_of(parameters)
    answer = thinning_response(parameters, inputs, parameters["fiber.model"], law)
    rates = "any rate" if answer.rate.size == 1 else f"{answer.rate.size} rates"
    say(f"table for {rates}, its pressures within {100 * answer.pressure_error:.2g} %")
    return labelled(answer.to_arrays(), QUANTITIES)


def response_estimates(parameters: Parameters, table: Mapping[Any, Any]) -> tuple[Estimate, ...]:
    """Return the errors of a table, each with its bound."""
    cure = (
        "take a higher numerics.thinning_order, a smaller fiber.aspect_ratio or a larger "
        'melt.index; or say fiber.melt = "local-viscosity", an approximation'
    )
    bounds = SHAPES[parameters["fiber.model"]].table_bounds
    return tuple(
        Estimate(f"thinning_{name}_error", float(table[f"thinning_{name}_error"]), bound, cure)
        for name, bound in zip(("spin", "pressure"), bounds, strict=True)
    )


def thinning_response(
    parameters: Parameters, inputs: Inputs, model: str, law: ViscosityLaw
) -> ThinningResponse:
    """Return the table of a study's fiber in a melt.

    Parameters
    ----------
    parameters, inputs
        As a stage has them.
    model : str
        The name of its shape.
    law : ViscosityLaw
        The melt.
    """
    shape = SHAPES[model]
    size = domain_size(parameters, inputs) if shape.has_cell else 0.0
    return shape.thinning(sizes_of(parameters), law, size, thinning_numerics(parameters))
