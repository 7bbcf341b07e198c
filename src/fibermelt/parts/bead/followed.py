"""The fibers of a study along its streamlines: in the plane, out of it, by the paper's algorithm.

Each way returns arrays by the names of their variables; ``zone_time`` (n_streamlines, 3) is when
zones 1 to 3 are reached [s], NaN where one is not. What loads the finite elements is imported where
it is used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.stages import Parameters, Say
from fibermelt.fiber.extremes import extremes
from fibermelt.fiber.motion import UNCHECKED, angle_to_stream_at, follow
from fibermelt.fiber.newton import FreeFiber, NewtonSolver
from fibermelt.fiber.pressure import surface_pressure
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.spatial import spatial_pressure
from fibermelt.parts.bead.newton import newton_motions
from fibermelt.parts.melt.melt import law_of, newtonian_viscosity, viscosity_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fibermelt.fiber.cell_data import CellNumerics
    from fibermelt.fiber.extremes import Extremes
    from fibermelt.fiber.models import FiberModel
    from fibermelt.fiber.motion import Turning
    from fibermelt.fiber.pressure import SurfaceHistory
    from fibermelt.history import FlowHistory

    Array = NDArray[np.float64]

COARSE_TOLERANCE = 1e-4
"""Angle error [rad] where only a difference is asked that is larger by far."""

__all__ = ["followed_by_newton", "followed_in_plane", "followed_in_space"]


def followed_in_plane(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    zone_time: Array | None,
    say: Say,
) -> dict[str, Any]:
    """Return the fibers that enter at the initial angles, in the plane of the flow."""
    angles = np.asarray(parameters["fiber.initial_angles"])
    say(f"{len(angles)} angles on {len(path.lines)} streamlines")
    error = _in_plane_error(parameters, path, model, angles, zone_time)
    tolerance = parameters["numerics.angle_tolerance"]
    motion, pressure, found = _in_plane(parameters, path, model, angles, zone_time, tolerance)
    return {
        "initial_angle": angles,
        "angle": motion.angle,
        "lowest": pressure.lowest,
        "highest": pressure.highest,
        **_at_zones(path, motion, zone_time),
        **_named(found),
        "extreme_error": error(found.value),
    }


def _in_plane(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    angles: Array,
    zone_time: Array | None,
    tolerance: float,
) -> tuple[Turning, SurfaceHistory, Extremes]:
    """Return motion, surface pressure and extremes of fibers in the plane of the flow."""
    motion = follow(path, model.turning, angles, tolerance)
    pressure = surface_pressure(path, model.in_plane, viscosity_of(parameters), motion)
    return motion, pressure, extremes(path, pressure, motion, zone_time)


def _in_plane_error(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    angles: Array,
    zone_time: Array | None,
) -> Callable[[Array], Array]:
    """Return what estimates the errors of extremes that the points' spacing makes [Pa].

    From the same fibers on every second point; they come first, as the last path that was followed
    is kept at hand for others.
    """
    coarse = path.every_second()
    tolerance = UNCHECKED if model.thinning is None else COARSE_TOLERANCE
    _, _, found = _in_plane(parameters, coarse, model, angles, zone_time, tolerance)
    return lambda value: np.abs(value - found.value)


def followed_by_newton(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    size: float,
    numerics: CellNumerics,
    zone_time: Array | None,
    say: Say,
) -> dict[str, Any]:
    """Return the same fibers by the paper's algorithm, on a cell of size ``M``.

    The extremes are those of its steps and of the cell's surface points, as in the paper. What the
    points' spacing does to them is estimated by superposition: the algorithm itself would take half
    its time again.
    """
    from fibermelt.fiber.cell import ThinningFiber, build_system  # noqa: PLC0415

    fiber = Ellipse(parameters["fiber.half_length"], parameters["fiber.aspect_ratio"])
    angles, law = np.asarray(parameters["fiber.initial_angles"]), law_of(parameters)
    free: FreeFiber
    if law.is_newtonian:
        free = NewtonSolver(build_system(fiber, size, numerics))
        viscosity = newtonian_viscosity(parameters)
    else:
        free, viscosity = ThinningFiber(fiber, size, law, numerics), 1.0
    motions = newton_motions(free, fiber, path.lines, viscosity, angles, say)
    lines = zip(path.lines, motions, _by_line(path, zone_time), strict=True)
    found = [_on_line(one, run, run, times) for one, run, times in lines]
    error = _in_plane_error(parameters, path, model, angles, zone_time)
    value = _in_plane(parameters, path, model, angles, zone_time, COARSE_TOLERANCE)[2].value
    return {"initial_angle": angles, **_stacked(found), "extreme_error": error(value)}


def followed_in_space(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    zone_time: Array | None,
    say: Say,
) -> dict[str, Any]:
    """Return the fibers that enter evenly over the sphere, streamline by streamline.

    They are ordered by their angle seen along z, which is that of the results; beside it stands
    their elevation out of the plane.
    """
    body, viscosity = model.in_space, viscosity_of(parameters)
    start = model.directions(parameters["fiber.direction_count"], planar=path.planar)
    tolerance = parameters["numerics.angle_tolerance"]
    say(f"{len(start)} directions on {len(path.lines)} streamlines")
    found = []
    for one, times in zip(path.lines, _by_line(path, zone_time), strict=True):
        motion = model.follow_in_space(one, start, tolerance)
        pressure = spatial_pressure(one, body, viscosity, motion)
        line = _on_line(one, motion, pressure, times)
        coarse = one.every_second()
        rough = model.follow_in_space(coarse, start, COARSE_TOLERANCE)
        again = extremes(coarse, spatial_pressure(coarse, body, viscosity, rough), rough, times)
        error = np.abs(line["extreme"] - again.value)
        found.append({**line, "elevation": motion.elevation, "extreme_error": error})
    return {
        "initial_angle": np.arctan2(*motion.initial_directions[:, 1::-1].T),
        "initial_elevation": np.arcsin(motion.initial_directions[:, 2]),
        **_stacked(found),
    }


def _on_line(
    one: FlowHistory,
    motion: Turning,
    pressure: SurfaceHistory,
    zone_time: Array | None,
) -> dict[str, Any]:
    """Return what is known of the fibers of one streamline, by the names of its variables."""
    return {
        "angle": motion.angle,
        "lowest": pressure.lowest,
        "highest": pressure.highest,
        **_at_zones(one, motion, zone_time),
        **_named(extremes(one, pressure, motion, zone_time)),
    }


def _at_zones(path: FlowHistory, motion: Turning, zone_time: Array | None) -> dict[str, Any]:
    """Return the fibers' angles at the zones, where there are any."""
    if zone_time is None:
        return {}
    known = np.isfinite(zone_time)  # paths of a given flow may end before
    angle = angle_to_stream_at(path, motion, np.where(known, zone_time, path.time[..., :1]))
    return {"zone_angle": np.where(known[..., None, :], angle, np.nan)}


def _by_line(path: FlowHistory, zone_time: Array | None) -> list[Any]:
    """Return the times at zones line by line, None where there are none."""
    return [None] * len(path.lines) if zone_time is None else list(zone_time)


def _stacked(lines: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the variables of all streamlines."""
    return {name: np.stack([line[name] for line in lines]) for name in lines[0]}


def _named(found: Extremes) -> dict[str, Any]:
    """Return extremes by the names of their variables."""
    parts = ("x", "y", "z", "time", "pressure", "angle", "where")
    return {"extreme": found.value, **{f"extreme_{name}": getattr(found, name) for name in parts}}
