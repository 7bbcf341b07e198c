"""The fiber's answers in a melt that thins, as a stage: a table over rate and direction.

It depends on fiber, cell and law and on nothing of the flow, so that all flows of a melt share it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.fiber.extremes import ENTRANCE
from fibermelt.fiber.shape import Ellipse
from fibermelt.parts.bead.quantities import QUANTITIES
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.parts.bead.stages import domain_size, sizes_of, thinning_numerics
from fibermelt.parts.flow.marked import middle_marked
from fibermelt.parts.melt.melt import law_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw

__all__ = ["response_estimates", "response_stage", "surroundings_stage", "thinning_response"]


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


def surroundings_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Solve for the flow around a fiber where its pressure is lowest before the capillary.

    In a Newtonian melt it is a sum of the cell's two flows; here it is solved for at the strain
    that the fiber meets: the one that enters nearest to the x axis, on the marked streamline
    nearest to the middle of the flux (the paper's Fig. 16).
    """
    from fibermelt.fiber.cell import thinning_surroundings  # noqa: PLC0415  lazy: finite elements

    lines, motion = inputs["streamlines"], inputs["motion"]
    numbers, fraction = (lines[name].to_numpy() for name in ("streamline", "flux_fraction"))
    row = middle_marked(numbers, fraction, parameters["streamlines.features"])
    fiber = int(np.argmax(np.abs(np.cos(motion["initial_angle"].to_numpy()))))
    one = motion.isel(streamline=row, initial_angle=fiber)
    when = float(one["extreme_time"].sel(location=ENTRANCE, kind="min"))
    path = lines.isel(streamline=row)
    point = int(np.argmin(np.abs(path["time"].to_numpy() - when)))
    cell, seen = thinning_surroundings(
        Ellipse(parameters["fiber.half_length"], parameters["fiber.aspect_ratio"]),
        domain_size(parameters, inputs),
        law_of(parameters),
        path["gradient"].to_numpy()[point, :2, :2],
        float(one["angle"].to_numpy()[point]),
        thinning_numerics(parameters),
    )
    say(f"flow around the fiber of streamline {numbers[row]} at {when:.3g} s")
    return labelled(
        {
            "around_streamline": int(numbers[row]),
            "around_initial_angle": float(motion["initial_angle"][fiber]),
            "around_time": float(path["time"].to_numpy()[point]),
            "around_point": cell.points,
            "around_triangle": cell.cells,
            "around_velocity": seen.velocity,
            "around_pressure": seen.pressure,
        },
        QUANTITIES,
    )
