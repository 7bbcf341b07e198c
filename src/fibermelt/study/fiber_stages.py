"""The fiber's stages: its cell, and its motion and pressure along streamlines, as labelled data.

What computes is imported when a stage runs, so that a study that is stored costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from fibermelt.study.stages import Inputs, Parameters, Say
from fibermelt.study.variables import labelled

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.fiber.paths import PathBundle
    from fibermelt.fiber.response import FiberResponse

__all__ = ["cell_stage", "motion_stage"]

PRESSURE_REFERENCE: dict[str, Literal["cell-edge", "far-node"]] = {
    "mean": "cell-edge",
    "far-node": "far-node",
}
"""Names that the pressure's level has in a study, and in `fibermelt.fiber`."""


def cell_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Solve the fiber's cell."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.cell import solve_cell  # noqa: PLC0415
    from fibermelt.fiber.cell_data import CellNumerics  # noqa: PLC0415
    from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

    fiber = Ellipse(parameters["fiber.half_length"], parameters["fiber.aspect_ratio"])
    numerics = CellNumerics(
        order=parameters["numerics.cell_order"],
        pressure_reference=PRESSURE_REFERENCE[parameters["fiber.pressure_reference"]],
    )
    solution = solve_cell(fiber, parameters["fiber.domain_size"], numerics)
    say(f"{solution.unknowns} unknowns, shape factor {solution.shape_factor:.6f}")
    stall_angle, error = solution.stall_angle, solution.error_estimate
    return labelled(
        {
            "aspect_ratio": fiber.aspect_ratio,
            "domain_size": solution.domain_size,
            "shape_factor": solution.shape_factor,
            "stall_angle": np.nan if stall_angle is None else stall_angle,
            "tip_pressure": solution.tip_pressure,
            "shape_factor_error": np.nan if error is None else error.shape_factor,
            "tip_pressure_error": np.nan if error is None else error.tip_pressure,
            "cell_unknowns": solution.unknowns,
            "surface_angle": solution.response.surface,
            "surface_basis": solution.response.basis,
            "cell_point": solution.points,
            "cell_triangle": solution.cells,
            "cell_edge": solution.element_edges,
            "cell_velocity": solution.velocity,
            "cell_pressure": solution.pressure,
        }
    )


def _response(cell: xr.Dataset) -> FiberResponse:
    """Return the fiber's response that was stored."""
    from fibermelt.fiber.response import FiberResponse  # noqa: PLC0415  lazy: see the module

    return FiberResponse(
        aspect_ratio=float(cell["aspect_ratio"]),
        shape_factor=float(cell["shape_factor"]),
        surface=cell["surface_angle"].to_numpy(),
        basis=cell["surface_basis"].to_numpy(),
    )


def _path(lines: xr.Dataset) -> PathBundle:
    """Return the flow histories that were stored."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.paths import PathBundle  # noqa: PLC0415
    from fibermelt.history import FlowHistory  # noqa: PLC0415

    position = np.stack([lines["x"], lines["y"]], axis=-1)
    velocity = np.stack([lines["u"], lines["v"]], axis=-1)
    time, gradient, pressure = (lines[n].to_numpy() for n in ("time", "gradient", "pressure"))
    return PathBundle(
        [
            FlowHistory(time[k], position[k], velocity[k], gradient[k], pressure[k])
            for k in range(len(time))
        ]
    )


def motion_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Follow the fibers along all streamlines, and find the pressure on their surfaces."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.extremes import KINDS, LOCATIONS, extreme_bounds, extremes  # noqa: PLC0415
    from fibermelt.fiber.motion import angle_to_stream_at, follow  # noqa: PLC0415
    from fibermelt.fiber.population import QUANTILE_LEVELS, isotropic_pressure  # noqa: PLC0415
    from fibermelt.fiber.pressure import pressure_bounds, surface_pressure  # noqa: PLC0415

    path, response = _path(inputs["streamlines"]), _response(inputs["cell"])
    viscosity, count = parameters["melt.viscosity"], parameters["numerics.isotropic_angles"]
    middle = inputs["streamlines"]["middle_time"].to_numpy()
    angles = np.asarray(parameters["fiber.initial_angles"])
    say(f"{len(angles)} angles on {len(path)} streamlines")
    motion = follow(path, response.shape_factor, angles, parameters["numerics.angle_tolerance"])
    pressure = surface_pressure(path, response, viscosity, motion)
    bounds = pressure_bounds(path, response, viscosity)
    zone_time = inputs["streamlines"]["zone_time"].to_numpy()
    say(f"{count} angles of an isotropic start")
    isotropic = isotropic_pressure(path, response, viscosity, middle, count, QUANTILE_LEVELS)
    arrays: dict[str, Any] = {
        "initial_angle": angles,
        "location": np.asarray(LOCATIONS),
        "kind": np.asarray(KINDS),
        "quantile": isotropic.levels,
        "angle": motion.angle,
        "lowest": pressure.lowest,
        "highest": pressure.highest,
        "bound_lowest": bounds.lowest,
        "bound_highest": bounds.highest,
        "quantile_lowest": isotropic.lowest,
        "quantile_highest": isotropic.highest,
        "extreme_bounds": extreme_bounds(path, bounds, middle),
        "extreme_quantiles": isotropic.extremes,
        "zone_angle": angle_to_stream_at(path, motion, zone_time),
    }
    found = extremes(path, pressure, motion, middle)
    arrays["extreme"] = found.value
    for name in ("x", "y", "time", "pressure", "angle", "where"):
        arrays[f"extreme_{name}"] = getattr(found, name)
    return labelled(arrays)
