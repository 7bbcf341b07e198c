"""Results of the sensitivity studies on coarse cells and a made-up bead, for several tests."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from drawn_bead import made_up

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Parameters
from fibermelt.paper.dimensions import part as dimensions
from fibermelt.paper.dimensions.stages import dimensions_stage
from fibermelt.paper.orbits import part as orbits
from fibermelt.paper.orbits.stages import orbits_stage
from fibermelt.study.quantities import QUANTITIES

PARAMETERS: dict[str, Any] = {
    "sensitivity.aspect_ratios": (1.0, 6.0, 10.0),
    "sensitivity.shear_rates": (0.5, 1.0, 2.0),
    "sensitivity.viscosities": (400.0, 817.0),
    "sensitivity.shear_rate": 1.0,
    "sensitivity.domain_size": 28.0,
    "fiber.half_length": 42e-6,
    "fiber.aspect_ratio": 6.0,
    "fiber.domain_size": 4.0,
    "fiber.initial_angles": tuple(np.radians(np.arange(-90.0, 91.0, 45.0))),
    "law.name": "newtonian",
    "law.viscosity": 817.0,
    "numerics.cell_order": 3,
    "numerics.angle_tolerance": 1e-6,
    "streamlines.features": (4, 10, 18),
}
"""The paper's study in little; the cells' order is the lowest that is within 1e-2."""


def quiet(line: str) -> None:
    """Take progress, say nothing."""


def declared(names: tuple[str, ...], values: dict[str, Any] = PARAMETERS) -> Parameters:
    """Return the parameters that a stage declares by key or by table."""
    return Parameters(
        {k: v for k, v in values.items() if k in names or k.partition(".")[0] in names}
    )


def turned(**changes: Any) -> xr.Dataset:
    """Return results of "orbits"; ``domain_size=4.0`` and the like change the sensitivity table."""
    values = PARAMETERS | {f"sensitivity.{name}": value for name, value in changes.items()}
    return orbits_stage(declared(orbits.PART.brings[0].parameters, values), {}, quiet)


def compared(count: int = 22, model: str = "ellipse", **changes: Any) -> xr.Dataset:
    """Return results of "dimensions" on the streamlines of the made-up bead."""
    values = PARAMETERS | {f"sensitivity.{name}": value for name, value in changes.items()}
    cell = labelled(
        {"fiber_model": model, "aspect_ratio": values["fiber.aspect_ratio"]}, QUANTITIES
    )
    inputs = {"streamlines": made_up(count, points=60), "cell": cell}
    parameters = declared(dimensions.PART.brings[0].parameters, values)
    return dimensions_stage(parameters, inputs, quiet)
