"""The bead in space that tests look at: a straight nozzle, a gap of one diameter."""

from __future__ import annotations

from typing import Any

from fibermelt.flow.problem import BeadDeposition, Nozzle
from fibermelt.melt import Newtonian

DIAMETER = 3.175e-3

BEAD_PROBLEM = BeadDeposition(
    Nozzle(
        DIAMETER,
        0.1 * DIAMETER,
        0.1 * DIAMETER,
        DIAMETER,
        0.6 * DIAMETER,
        DIAMETER,
        3 * DIAMETER,
    ),
    Newtonian(817.0),
    inlet_speed=0.095,
    bed_speed=0.1,
)
"""0.8 diameters long: what the numbers to hold against were found on."""

BEAD_COARSE: dict[str, Any] = {
    "lip_edge": 0.1,
    "bulk_edge": 0.4,
    "rim_edge": 0.1,
    "sectors": 12,
    "film": 0.02,
}
"""Numerics; coarser ones do not converge."""
