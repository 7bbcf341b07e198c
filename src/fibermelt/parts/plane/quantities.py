"""What is stored of the slot beside a bead in space."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

_FIBER = "on paths that pass no sharp corner"

# fmt: off
QUANTITIES = declared(
    Q("plane_slot", "", "m", "width of the slot that stands for the round nozzle",
      title="Slot", shown_in="mm", response=False),
    Q("plane_bead_height", "", "m", "height of the slot's bead", title="Bead height",
      shown_in="mm"),
    Q("plane_inlet_pressure", "", "Pa", "mean pressure over the slot's inlet",
      title="Inlet pressure", shown_in="MPa"),
    Q("plane_inlet_pressure_error", "", "Pa", "estimated error of it"),
    Q("plane_heel", "", "m", "x of the slot's foremost point upstream", title="Heel",
      shown_in="mm"),
    Q("plane_heel_error", "", "m", "estimated error of it"),
    Q("plane_lowest_pressure", "", "Pa",
      f"lowest pressure on a fiber in its worst direction, above the air's, {_FIBER}, in the slot",
      title="Lowest pressure on a fiber", shown_in="MPa"),
    Q("plane_exponent", "", "1",
      f"growth exponent on a fiber in its worst direction, mean by flux {_FIBER}, in the slot; NaN "
      "without moisture", title="Growth exponent"),
    Q("space_lowest_pressure", "", "Pa", "the lowest pressure, in the bead in space",
      title="Lowest pressure on a fiber", shown_in="MPa"),
    Q("space_exponent", "", "1", "the growth exponent, in the bead in space",
      title="Growth exponent"),
)
# fmt: on
"""What this part stores, by name."""
