"""The fiber: its shape, its motion along a flow history, the pressure on its surface.

Only what `fibermelt.fiber.cell` has, such as `solve_cell` and `solve_thinning`, needs the finite
elements; they are loaded when first named.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fibermelt.fiber.cell_data import CellError, CellNumerics, CellSolution, CellSystem, FlowAround
from fibermelt.fiber.directions import (
    equal_area_directions,
    even_frames,
    jeffery_director,
    orbit_constant,
    orbit_phase,
    planar_directions,
)
from fibermelt.fiber.directors import DirectorMotion, follow_directors
from fibermelt.fiber.ellipse_field import (
    EllipseField,
    ellipse_field,
    ellipse_spin,
    ellipse_torque,
)
from fibermelt.fiber.ellipsoid import (
    Ellipsoid,
    EllipsoidResponse,
    SurfaceExtremes,
    unbounded_ellipsoid,
)
from fibermelt.fiber.ellipsoid_field import EllipsoidField, body_axes, ellipsoid_field
from fibermelt.fiber.extremes import (
    Extremes,
    ExtremeStatistics,
    extreme_bounds,
    extremes,
    statistics,
)
from fibermelt.fiber.frames import follow_ellipsoids
from fibermelt.fiber.jeffery import (
    ellipse_extremes,
    ellipse_pressure,
    jeffery_angle,
    jeffery_period,
    unbounded_ellipse,
)
from fibermelt.fiber.models import FiberModel, confined_model, unbounded_model
from fibermelt.fiber.motion import (
    Motion,
    angle_to_stream,
    angle_to_stream_at,
    follow,
    isotropic_angles,
    paper_angles,
)
from fibermelt.fiber.newton_motion import NewtonMotion, follow_newton
from fibermelt.fiber.newton_orbit import orbit_newton
from fibermelt.fiber.orbit import Orbit, orbit
from fibermelt.fiber.population import IsotropicPressure, isotropic_pressure
from fibermelt.fiber.pressure import (
    LocalViscosity,
    PressureBounds,
    SurfacePressure,
    pressure_bounds,
    surface_pressure,
)
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.shape import Ellipse, jeffery_factor
from fibermelt.fiber.spatial import (
    EllipsoidMotion,
    SpatialMotion,
    SpatialPressure,
    follow_spatial,
    half_sphere,
    spatial_bounds,
    spatial_pressure,
)
from fibermelt.fiber.spheroid import (
    Spheroid,
    SpheroidResponse,
    embed_planar,
    unbounded_spheroid,
)
from fibermelt.fiber.spheroid_data import SpheroidNumerics, ThinningSpheroid
from fibermelt.fiber.stall import paper_stall_angle, stall_curve
from fibermelt.fiber.stall_data import StallCurve
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.fiber.thinning_motion import ThinningMotion, ThinningPressure
from fibermelt.fiber.thinning_spheroid import unbounded_thinning_spheroid
from fibermelt.fiber.tumbling import Tumbling, tumble, turn_times, turned_angle

if TYPE_CHECKING:
    from fibermelt.fiber.cell import (
        ThinningFiber,
        build_system,
        solve_cell,
        solve_thinning,
        solve_thinning_spheroid,
        thinning_flow_around,
        thinning_surroundings,
    )

__all__ = [
    "CellError",
    "CellNumerics",
    "CellSolution",
    "CellSystem",
    "DirectorMotion",
    "Ellipse",
    "EllipseField",
    "Ellipsoid",
    "EllipsoidField",
    "EllipsoidMotion",
    "EllipsoidResponse",
    "ExtremeStatistics",
    "Extremes",
    "FiberModel",
    "FiberResponse",
    "FlowAround",
    "IsotropicPressure",
    "LocalViscosity",
    "Motion",
    "NewtonMotion",
    "Orbit",
    "PressureBounds",
    "SpatialMotion",
    "SpatialPressure",
    "Spheroid",
    "SpheroidNumerics",
    "SpheroidResponse",
    "StallCurve",
    "SurfaceExtremes",
    "SurfacePressure",
    "ThinningFiber",
    "ThinningMotion",
    "ThinningPressure",
    "ThinningResponse",
    "ThinningSpheroid",
    "Tumbling",
    "angle_to_stream",
    "angle_to_stream_at",
    "body_axes",
    "build_system",
    "confined_model",
    "ellipse_extremes",
    "ellipse_field",
    "ellipse_pressure",
    "ellipse_spin",
    "ellipse_torque",
    "ellipsoid_field",
    "embed_planar",
    "equal_area_directions",
    "even_frames",
    "extreme_bounds",
    "extremes",
    "follow",
    "follow_directors",
    "follow_ellipsoids",
    "follow_newton",
    "follow_spatial",
    "half_sphere",
    "isotropic_angles",
    "isotropic_pressure",
    "jeffery_angle",
    "jeffery_director",
    "jeffery_factor",
    "jeffery_period",
    "orbit",
    "orbit_constant",
    "orbit_newton",
    "orbit_phase",
    "paper_angles",
    "paper_stall_angle",
    "planar_directions",
    "pressure_bounds",
    "solve_cell",
    "solve_thinning",
    "solve_thinning_spheroid",
    "spatial_bounds",
    "spatial_pressure",
    "stall_curve",
    "statistics",
    "surface_pressure",
    "thinning_flow_around",
    "thinning_surroundings",
    "tumble",
    "turn_times",
    "turned_angle",
    "unbounded_ellipse",
    "unbounded_ellipsoid",
    "unbounded_model",
    "unbounded_spheroid",
    "unbounded_thinning_spheroid",
]


OF_CELLS = (
    "ThinningFiber",
    "build_system",
    "solve_cell",
    "solve_thinning",
    "solve_thinning_spheroid",
    "thinning_flow_around",
    "thinning_surroundings",
)
"""What needs the finite elements."""


def __getattr__(name: str) -> Any:
    """Load the finite elements when a cell is asked for."""
    if name in OF_CELLS:
        from fibermelt.fiber import cell  # noqa: PLC0415  # a second's import, on demand only

        return getattr(cell, name)
    msg = f"module {__name__!r} has no attribute {name!r}"
    raise AttributeError(msg)
