"""What is stored of what thinning does."""

from __future__ import annotations

from dataclasses import replace

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared
from fibermelt.parts.flow.quantities import QUANTITIES as FLOW

__all__ = ["QUANTITIES"]

_LAW = "effect_index"
_FIBER = "effect_index effect_model"
_LINE = "effect_index effect_model effect_cause streamline"


def _of_flow(name: str) -> Q:
    """Return a number of the flow as that of each law."""
    return replace(FLOW[name], name=f"effect_{name}", dimensions=_LAW, response=None)


# fmt: off
QUANTITIES = declared(
    Q("effect_index", _LAW, "1", "index of the power law", title="Index"),
    Q("effect_model", "effect_model", "1", "what answers for the fiber"),
    Q("effect_cause", "effect_cause", "1",
      "what thins: both, the flow alone, the fiber's melt alone"),
    Q("effect_consistency", _LAW, "Pa s", "viscosity of the power law at 1 1/s",
      title="Viscosity at 1 1/s"),
    _of_flow("inlet_pressure"),
    _of_flow("inlet_pressure_error"),
    _of_flow("contact_point"),
    _of_flow("contact_point_error"),
    Q("effect_regular", "streamline", "1", "whether it passes no sharp corner in any flow"),
    Q("effect_lowest", _LINE, "Pa",
      "lowest pressure on a fiber from the exit to the end of the swell, above the surrounding "
      "air's, mean over the initial angles", shown_in="MPa"),
    Q("effect_bound", _LINE, "Pa", "the same of any direction"),
    Q("effect_period", _FIBER, "1", "time of a turn in simple shear times rate; NaN if it stalls"),
    Q("effect_stall_angle", _FIBER, "rad", "angle to simple shear at which it stalls; NaN if not"),
    Q("effect_peak", _FIBER, "1", "largest pressure in simple shear over viscosity and rate there"),
    Q("effect_peak_error", _FIBER, "1", "estimated error of that"),
)
# fmt: on
"""What this part stores, by name."""
