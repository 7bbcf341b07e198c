"""The study's fiber as other shapes see it, which parts set beside the one that it has."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.parts.bead.shape import Sizes
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.parts.bead.stages import stored_model

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.stages import Parameters
    from fibermelt.fiber.models import FiberModel

__all__ = ["MODELS", "confined_ellipse", "fiber_models", "unbounded_models"]

MODELS = ("confined-ellipse", "ellipse", "spheroid")
"""The shapes that are set beside one another."""


def confined_ellipse(parameters: Parameters, ratio: float, size: float) -> FiberModel:
    """Solve the cell of a confined ellipse."""
    numerics = CellNumerics(order=parameters["numerics.cell_order"], estimate=False)
    sizes = Sizes(parameters["fiber.half_length"], ratio)
    return SHAPES[MODELS[0]].model(sizes, size, numerics)


def unbounded_models(parameters: Parameters, ratio: float) -> list[FiberModel]:
    """Return an ellipse and a spheroid without a cell."""
    sizes = Sizes(parameters["fiber.half_length"], ratio)
    return [SHAPES[name].model(sizes, 0.0, None) for name in MODELS[1:]]


def fiber_models(parameters: Parameters, cell: xr.Dataset, size: float) -> list[FiberModel]:
    """Return the study's fiber as each of the shapes; its cell is taken if it has one."""
    chosen, ratio = stored_model(cell), parameters["fiber.aspect_ratio"]
    confined = chosen if chosen.name == MODELS[0] else confined_ellipse(parameters, ratio, size)
    return [confined, *unbounded_models(parameters, ratio)]
