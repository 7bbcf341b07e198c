"""The study's fiber as other models see it, which parts set beside the one that it has."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.parts.bead.stages import stored_model

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.stages import Parameters
    from fibermelt.fiber.models import FiberModel

__all__ = ["MODELS", "confined_ellipse", "fiber_models", "unbounded_models"]

MODELS = ("confined-ellipse", "ellipse", "spheroid")
"""The models that are set beside one another."""


def confined_ellipse(parameters: Parameters, ratio: float, size: float) -> FiberModel:
    """Solve the cell of a confined ellipse."""
    from fibermelt.fiber.cell import solve_cell  # noqa: PLC0415  lazy: loads the finite elements
    from fibermelt.fiber.cell_data import CellNumerics  # noqa: PLC0415
    from fibermelt.fiber.models import confined_model  # noqa: PLC0415
    from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

    numerics = CellNumerics(order=parameters["numerics.cell_order"], estimate=False)
    fiber = Ellipse(parameters["fiber.half_length"], ratio)
    return confined_model(solve_cell(fiber, size, numerics).response)


def unbounded_models(parameters: Parameters, ratio: float) -> list[FiberModel]:
    """Return an ellipse and a spheroid without a cell."""
    from fibermelt.fiber.models import unbounded_model  # noqa: PLC0415  lazy: see the module
    from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

    fiber = Ellipse(parameters["fiber.half_length"], ratio)
    return [unbounded_model("ellipse", fiber), unbounded_model("spheroid", fiber)]


def fiber_models(parameters: Parameters, cell: xr.Dataset, size: float) -> list[FiberModel]:
    """Return the study's fiber as each of the models; its cell is taken if it has one."""
    chosen, ratio = stored_model(cell), parameters["fiber.aspect_ratio"]
    confined = chosen if chosen.name == MODELS[0] else confined_ellipse(parameters, ratio, size)
    return [confined, *unbounded_models(parameters, ratio)]
