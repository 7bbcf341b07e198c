"""The fibers of a study along its streamlines: in the plane, out of it, by the paper's algorithm.

Each way returns arrays by the names of their variables; ``middle`` (n_streamlines,) is the time at
the middle of the capillary [s] and ``zone_time`` (n_streamlines, n_zones) when the zones are
reached [s]. What computes is imported when it is asked for, as in the stages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fibermelt.errors import ConfigError
from fibermelt.study.bead.newton import newton_motions
from fibermelt.study.melt import law_of, newtonian_viscosity, viscosity_of
from fibermelt.study.stages import Parameters, Say

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.fiber.cell_data import CellNumerics
    from fibermelt.fiber.extremes import Extremes
    from fibermelt.fiber.models import FiberModel
    from fibermelt.fiber.motion import Turning
    from fibermelt.fiber.pressure import SurfaceHistory
    from fibermelt.history import FlowHistory

    Array = NDArray[np.float64]

__all__ = ["followed_by_newton", "followed_in_plane", "followed_in_space"]


def followed_in_plane(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    middle: Array,
    zone_time: Array,
    say: Say,
) -> dict[str, Any]:
    """Return the fibers that enter at the initial angles, in the plane of the flow."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.extremes import extremes  # noqa: PLC0415
    from fibermelt.fiber.motion import angle_to_stream_at, follow  # noqa: PLC0415
    from fibermelt.fiber.pressure import surface_pressure  # noqa: PLC0415

    angles = np.asarray(parameters["fiber.initial_angles"])
    tolerance = parameters["numerics.angle_tolerance"]
    say(f"{len(angles)} angles on {len(path.lines)} streamlines")
    motion = follow(path, model.turning, angles, tolerance)
    pressure = surface_pressure(path, model.in_plane, viscosity_of(parameters), motion)
    return {
        "initial_angle": angles,
        "angle": motion.angle,
        "lowest": pressure.lowest,
        "highest": pressure.highest,
        "zone_angle": angle_to_stream_at(path, motion, zone_time),
        **_named(extremes(path, pressure, motion, middle)),
    }


def followed_by_newton(
    parameters: Parameters,
    path: FlowHistory,
    size: float,
    numerics: CellNumerics,
    middle: Array,
    zone_time: Array,
    say: Say,
) -> dict[str, Any]:
    """Return the same fibers by the paper's algorithm, on a cell of size ``M``.

    The extremes are those of its steps and of the cell's surface points, as in the paper.
    """
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.cell import ThinningFiber, build_system  # noqa: PLC0415
    from fibermelt.fiber.newton import FreeFiber, NewtonSolver  # noqa: PLC0415
    from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

    fiber = Ellipse(parameters["fiber.half_length"], parameters["fiber.aspect_ratio"])
    angles, law = np.asarray(parameters["fiber.initial_angles"]), law_of(parameters)
    free: FreeFiber
    if law.is_newtonian:
        free = NewtonSolver(build_system(fiber, size, numerics))
        viscosity = newtonian_viscosity(parameters)
    else:
        free, viscosity = ThinningFiber(fiber, size, law, numerics), 1.0
    motions = newton_motions(free, fiber, path.lines, viscosity, angles, say)
    lines = zip(path.lines, motions, middle, zone_time, strict=True)
    found = [_on_line(one, run, run, at, times) for one, run, at, times in lines]
    return {"initial_angle": angles, **_stacked(found)}


def followed_in_space(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    middle: Array,
    zone_time: Array,
    say: Say,
) -> dict[str, Any]:
    """Return the fibers that enter evenly over the sphere, streamline by streamline.

    They are ordered by their angle seen along z, which is that of the results; beside it stands
    their elevation out of the plane.
    """
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.spatial import (  # noqa: PLC0415
        follow_spatial,
        half_sphere,
        spatial_pressure,
    )

    if model.spheroid is None:
        msg = f'fiber.directions = "equal-area" with fiber.model = "{model.name}"'
        raise ConfigError(msg)
    start = half_sphere(parameters["fiber.direction_count"])
    tolerance = parameters["numerics.angle_tolerance"]
    say(f"{len(start)} directions on {len(path.lines)} streamlines")
    found = []
    for one, middle_time, times in zip(path.lines, middle, zone_time, strict=True):
        motion = follow_spatial(one, model.spheroid.shape_factor, start, tolerance)
        pressure = spatial_pressure(one, model.spheroid, viscosity_of(parameters), motion)
        line = _on_line(one, motion, pressure, middle_time, times)
        found.append({**line, "elevation": motion.elevation})
    return {
        "initial_angle": np.arctan2(start[:, 1], start[:, 0]),
        "initial_elevation": np.arcsin(start[:, 2]),
        **_stacked(found),
    }


def _on_line(
    one: FlowHistory,
    motion: Turning,
    pressure: SurfaceHistory,
    middle_time: float,
    zone_time: Array,
) -> dict[str, Any]:
    """Return what is known of the fibers of one streamline, by the names of its variables."""
    from fibermelt.fiber.extremes import extremes  # noqa: PLC0415  lazy: see the module
    from fibermelt.fiber.motion import angle_to_stream_at  # noqa: PLC0415

    return {
        "angle": motion.angle,
        "lowest": pressure.lowest,
        "highest": pressure.highest,
        "zone_angle": angle_to_stream_at(one, motion, zone_time),
        **_named(extremes(one, pressure, motion, float(middle_time))),
    }


def _stacked(lines: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the variables of all streamlines."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    return {name: np.stack([line[name] for line in lines]) for name in lines[0]}


def _named(found: Extremes) -> dict[str, Any]:
    """Return extremes by the names of their variables."""
    parts = ("x", "y", "time", "pressure", "angle", "where")
    return {"extreme": found.value, **{f"extreme_{name}": getattr(found, name) for name in parts}}
