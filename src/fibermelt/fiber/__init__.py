"""The fiber: its shape, its motion along a flow history, the pressure on its surface.

Only `solve_cell` and `build_system` need the finite elements; they are loaded when first named.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fibermelt.fiber.cell_data import CellError, CellNumerics, CellSolution, CellSystem
from fibermelt.fiber.extremes import (
    Extremes,
    ExtremeStatistics,
    extreme_bounds,
    extremes,
    statistics,
)
from fibermelt.fiber.jeffery import (
    ellipse_extremes,
    ellipse_pressure,
    jeffery_angle,
    jeffery_period,
    unbounded_ellipse,
)
from fibermelt.fiber.motion import (
    Motion,
    angle_to_stream,
    angle_to_stream_at,
    follow,
    isotropic_angles,
    paper_angles,
)
from fibermelt.fiber.newton import NewtonMotion, follow_newton
from fibermelt.fiber.paths import PathBundle
from fibermelt.fiber.population import IsotropicPressure, isotropic_pressure
from fibermelt.fiber.pressure import (
    PressureBounds,
    SurfacePressure,
    pressure_bounds,
    surface_pressure,
)
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.shape import Ellipse, jeffery_factor

if TYPE_CHECKING:
    from fibermelt.fiber.cell import build_system, solve_cell

__all__ = [
    "CellError",
    "CellNumerics",
    "CellSolution",
    "CellSystem",
    "Ellipse",
    "ExtremeStatistics",
    "Extremes",
    "FiberResponse",
    "IsotropicPressure",
    "Motion",
    "NewtonMotion",
    "PathBundle",
    "PressureBounds",
    "SurfacePressure",
    "angle_to_stream",
    "angle_to_stream_at",
    "build_system",
    "ellipse_extremes",
    "ellipse_pressure",
    "extreme_bounds",
    "extremes",
    "follow",
    "follow_newton",
    "isotropic_angles",
    "isotropic_pressure",
    "jeffery_angle",
    "jeffery_factor",
    "jeffery_period",
    "paper_angles",
    "pressure_bounds",
    "solve_cell",
    "statistics",
    "surface_pressure",
    "unbounded_ellipse",
]


def __getattr__(name: str) -> Any:
    """Load the finite elements when a cell is asked for."""
    if name in ("build_system", "solve_cell"):
        from fibermelt.fiber import cell  # noqa: PLC0415  # a second's import, on demand only

        return getattr(cell, name)
    msg = f"module {__name__!r} has no attribute {name!r}"
    raise AttributeError(msg)
