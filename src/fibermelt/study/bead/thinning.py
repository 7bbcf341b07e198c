"""The fiber's answers in a melt that thins, as a stage: a table over rate and direction.

It depends on fiber, cell and law and on nothing of the flow, so that all flows of a melt share it.
What computes is imported when the stage runs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.study.bead.fiber import domain_size, thinning_numerics
from fibermelt.study.melt import law_of
from fibermelt.study.stages import Estimate, Inputs, Parameters, Say
from fibermelt.study.variables import labelled

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.fiber.thinning import ThinningResponse

__all__ = ["thinning_estimates", "thinning_stage"]

SPIN_BOUND, PRESSURE_BOUND = 5e-3, 5e-3
"""Largest estimated errors of a table: of the spin over the strain's size, and of the pressure
extremes over the largest pressure. Finer costs minutes, and no law of a melt is known so well."""


def thinning_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Solve the fiber's cell in the study's melt, over rates and directions."""
    answer = _ellipse(parameters, inputs)
    rates = "any rate" if answer.rate.size == 1 else f"{answer.rate.size} rates"
    say(f"table for {rates}, its pressures within {100 * answer.pressure_error:.2g} %")
    return labelled(answer.to_arrays())


def thinning_estimates(parameters: Parameters, table: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the errors of a table, each with its bound."""
    cure = (
        "take a higher numerics.thinning_order, a smaller fiber.aspect_ratio or a larger "
        'melt.index; or say fiber.melt = "local-viscosity", an approximation'
    )
    return tuple(
        Estimate(name, float(table[name]), bound, cure)
        for name, bound in (
            ("thinning_spin_error", SPIN_BOUND),
            ("thinning_pressure_error", PRESSURE_BOUND),
        )
    )


def _ellipse(parameters: Parameters, inputs: Inputs) -> ThinningResponse:
    """Return the table of an ellipse in its cell, or in one so large that it is hardly felt."""
    from fibermelt.fiber.cell import solve_thinning  # noqa: PLC0415  lazy: the finite elements
    from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415
    from fibermelt.fiber.thinning import UNBOUNDED_SIZE  # noqa: PLC0415

    fiber = Ellipse(parameters["fiber.half_length"], parameters["fiber.aspect_ratio"])
    is_confined = parameters["fiber.model"] == "confined-ellipse"
    size = domain_size(parameters, inputs) if is_confined else UNBOUNDED_SIZE
    return solve_thinning(fiber, size, law_of(parameters), thinning_numerics(parameters))
