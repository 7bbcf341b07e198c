"""The stage of a bead in space: solved, stored as a field that paths lead through, and its errors.

What loads the finite elements is imported where it is used.
"""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.flow.problem import BeadDeposition, BeadNumerics, Nozzle
from fibermelt.parts.flow.imported import field_arrays, stored_field, traced
from fibermelt.parts.flow.quantities import QUANTITIES
from fibermelt.parts.melt.melt import law_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.flow.space.field import BeadField


__all__ = [
    "FINER",
    "bead_problem",
    "stored_bead",
    "strand_estimates",
    "strand_paths",
    "strand_stage",
]

SCALARS = (
    "bead_height",
    "bead_width",
    "widest",
    "heel",
    "front",
    "wet_width",
    "section_area",
    "film",
    "inlet_pressure",
    "mass_imbalance",
    "kinematic_residual",
    "divergence",
    "newton_steps",
    "unknowns",
    "elements",
)
"""What is told of a bead in space."""

LENGTH_BOUND = 0.1
"""Largest estimated errors of height, widths and heel [diameters], an eighth of the height: of the
coarsest mesh of the tests they are 0.04 and 0.05, of the default one 0.012 and 0.014."""

PRESSURE_BOUND = 0.15
"""Largest estimated error of the inlet pressure over that pressure (0.08 of the coarsest, 0.04 of
the default)."""

AREA_BOUND = 0.01
"""Largest error of the flux at the outlet (2e-3), as in the plane."""

RESIDUAL_BOUND = 0.03
"""Largest mean ``u.n`` over the free surface in bed speeds (0.011 of the coarsest mesh): paths
within so many radii of the surface may leave through it."""

FINER = "take shorter edges in strand, such as lip_edge and rim_edge, or a thinner strand.film"


def bead_problem(parameters: Parameters) -> BeadDeposition:
    """Return the deposition problem in space of a study: widths are diameters."""
    flow = parameters.section("flow")
    flow.pop("source")
    speeds = {name: flow.pop(name) for name in ("inlet_speed", "bed_speed")}
    return BeadDeposition(nozzle=Nozzle(**flow), melt=cast("Any", law_of(parameters)), **speeds)


def strand_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Solve the bead in space, and cut it into a field that paths can be followed through."""
    from fibermelt.fields.bead import followable  # noqa: PLC0415  loads the finite elements
    from fibermelt.flow.space.bead import BeadError, solve_bead  # noqa: PLC0415

    problem = bead_problem(parameters)
    found = solve_bead(problem, BeadNumerics(**parameters.section("strand")), progress=say)
    errors = [one.name for one in fields(BeadError)]
    return labelled(
        {
            **field_arrays(followable(found.field, problem)),
            "strand_cells": found.field.cells,
            "strand_order": found.field.order,
            **{name: getattr(found, name) for name in SCALARS},
            **{f"{name}_error": getattr(found.error, name) for name in errors},
        },
        QUANTITIES,
    )


def strand_estimates(parameters: Parameters, strand: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the errors of a bead in space, each with its bound."""
    diameter = parameters["flow.capillary_width"]
    bounds = {
        "bead_height_error": LENGTH_BOUND * diameter,
        "bead_width_error": LENGTH_BOUND * diameter,
        "widest_error": LENGTH_BOUND * diameter,
        "heel_error": LENGTH_BOUND * diameter,
        "inlet_pressure_error": PRESSURE_BOUND * abs(float(strand["inlet_pressure"])),
        "mass_imbalance": AREA_BOUND,
        "kinematic_residual": RESIDUAL_BOUND,
    }
    return tuple(
        Estimate(name, float(strand[name]), bound, FINER) for name, bound in bounds.items()
    )


def stored_bead(strand: xr.Dataset) -> BeadField:
    """Return the field on curved tetrahedra that was stored."""
    from fibermelt.flow.space.field import BeadField  # noqa: PLC0415  as above

    names = ("points", "velocity", "pressure", "gradient", "divergence", "viscosity")
    return BeadField(
        order=int(strand["strand_order"]),
        cells=strand["strand_cells"].to_numpy(),
        gradient_error=strand["field_gradient_error"].to_numpy(),
        **{name: strand[f"field_{name}"].to_numpy() for name in names},
    )


def strand_paths(parameters: Parameters, strand: xr.Dataset, say: Say) -> dict[str, Any]:
    """Trace the paths of equal flux through half of a bead."""
    from fibermelt.fields.bead import bead_paths, bead_zones  # noqa: PLC0415  as above

    problem, field = bead_problem(parameters), stored_field(strand)
    count, points = parameters["streamlines.count"], parameters["streamlines.points"]
    say(f"tracing {count} paths of {points} points")
    paths = bead_paths(field, problem, count, points)
    start = np.stack([path.history.position[0] for path in paths])
    zone_time = np.stack([bead_zones(path, problem) for path in paths])
    known = np.isfinite(zone_time).any(axis=0)
    return {
        **traced(paths),
        "start_radius": 2.0 * np.hypot(start[:, 0], start[:, 2]) / problem.nozzle.inlet_width,
        "start_angle": np.arctan2(start[:, 2], start[:, 0]),
        "zone": 1 + np.flatnonzero(known),
        "zone_time": zone_time[:, known],
    }
