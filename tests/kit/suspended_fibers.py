"""Results of orientation and interaction in little, for several tests: no cell is solved."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from drawn_bead import made_up

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Parameters
from fibermelt.fiber.shape import jeffery_factor
from fibermelt.parts.interaction.stages import content_stage, interaction_stage
from fibermelt.parts.orientation.stages import orientation_stage
from fibermelt.study.quantities import QUANTITIES

PARAMETERS: dict[str, Any] = {
    "fiber.aspect_ratio": 6.0,
    "interaction.volume_fraction": 0.084,
    "interaction.law": "bay",
    "interaction.coefficient": None,
    "interaction.closure": "ORE",
    "interaction.convention": "standard",
    "interaction.start": "isotropic",
    "interaction.model": "folgar-tucker",
}
"""The paper's suspension."""

CELLS = (
    (2.1, 1.156601),
    (2.136289, 1.156142),
    (2.277896, 1.146494),
    (2.639129, 1.114054),
    (3.550292, 1.053678),
    (6.631524, 0.981599),
    (13.034276, 0.955590),
    (np.inf, jeffery_factor(6.0)),
)
"""Domain sizes and shape factors of cells around a fiber of aspect ratio 6, solved before."""


def quiet(line: str) -> None:
    """Take progress, say nothing."""


def parameters(**changes: Any) -> Parameters:
    """Return the paper's suspension; ``closure="ORF"`` and the like change its interaction."""
    changed = {
        f"interaction.{name}" if name != "aspect_ratio" else "fiber.aspect_ratio": value
        for name, value in changes.items()
    }
    return Parameters(PARAMETERS | changed)


def stalled(aspect_ratio: float = 6.0) -> xr.Dataset:
    """Return results of "stall" from a few cells; another aspect ratio is but another label."""
    size, factor = np.array(CELLS).T
    return labelled(
        {
            "stall_domain_size": size,
            "stall_shape_factor": factor,
            "stall_shape_factor_error": 1e-3,
            "stall_aspect_ratio": aspect_ratio,
            "largest_stalling_domain": 5.29,
        },
        QUANTITIES,
    )


def interacting(aspect_ratio: float = 6.0, **changes: Any) -> xr.Dataset:
    """Return results of "stall", "content" and "interaction"."""
    given, stall = parameters(aspect_ratio=aspect_ratio, **changes), stalled(aspect_ratio)
    inputs = {"stall": stall}
    return xr.merge(
        [stall, content_stage(given, inputs, quiet), interaction_stage(given, inputs, quiet)]
    )


def oriented(count: int = 22, points: int = 60, **changes: Any) -> xr.Dataset:
    """Return results of "orientation" on the streamlines of the made-up bead."""
    lines = made_up(count, points=points)
    return lines.merge(orientation_stage(parameters(**changes), {"streamlines": lines}, quiet))
