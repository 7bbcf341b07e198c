"""The fiber's answers in a melt that thins, as a stage: a table over rate and direction.

It depends on fiber, cell and law and on nothing of the flow, so that all flows of a melt share it.
What computes is imported when the stage runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.parts.bead.quantities import QUANTITIES
from fibermelt.parts.bead.stages import domain_size, thinning_numerics
from fibermelt.parts.melt.melt import law_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw

__all__ = ["response_estimates", "response_stage", "thinning_response"]

SPIN_BOUND, PRESSURE_BOUND = 5e-3, 1e-2
"""Largest estimated errors of an ellipse's table: of the spin over the strain's size, and of the
pressure extremes over the largest pressure. At n = 0.25 they have 2e-5 and 2.8e-3 for r_e = 6,
1e-5 and 7.9e-3 for 20; no law of a melt is known so well."""

SPHEROID_BOUND = 0.2
"""The same of a spheroid's, in three dimensions and for a local index: as told beside it."""


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
    bounds = (SPIN_BOUND, PRESSURE_BOUND)
    if parameters["fiber.model"] == "spheroid":
        bounds = (SPHEROID_BOUND, SPHEROID_BOUND)
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
        An ellipse in its cell, or in one so large that it is hardly felt; or a spheroid, whose
        table is shipped.
    law : ViscosityLaw
        The melt.
    """
    from fibermelt.fiber.cell import solve_thinning  # noqa: PLC0415  lazy: the finite elements
    from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415
    from fibermelt.fiber.spheroid import Spheroid  # noqa: PLC0415
    from fibermelt.fiber.thinning import UNBOUNDED_SIZE  # noqa: PLC0415
    from fibermelt.fiber.thinning_spheroid import unbounded_thinning_spheroid  # noqa: PLC0415

    size = parameters["fiber.half_length"], parameters["fiber.aspect_ratio"]
    if model == "spheroid":
        return unbounded_thinning_spheroid(Spheroid(*size), law)
    cell = domain_size(parameters, inputs) if model == "confined-ellipse" else UNBOUNDED_SIZE
    return solve_thinning(Ellipse(*size), cell, law, thinning_numerics(parameters))
