"""The variables of what thinning does; merged into `fibermelt.parts.variables`."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["EFFECT_VARIABLES"]

_LAW = "effect_index"
_FIBER = "effect_index effect_model"
_LINE = "effect_index effect_model effect_cause streamline"

EFFECT_VARIABLES: Mapping[str, tuple[str, str, str]] = {
    "effect_index": (_LAW, "1", "index of the power law"),
    "effect_model": ("effect_model", "1", "what answers for the fiber"),
    "effect_cause": (
        "effect_cause",
        "1",
        "what thins: both, the flow alone, the fiber's melt alone",
    ),
    "effect_consistency": (_LAW, "Pa s", "viscosity of the power law at 1 1/s"),
    "effect_inlet_pressure": (_LAW, "Pa", "pressure at the inlet above the surrounding air's"),
    "effect_inlet_pressure_error": (_LAW, "Pa", "estimated error of the inlet pressure"),
    "effect_contact_point": (_LAW, "m", "x where the upstream free surface meets the bed"),
    "effect_contact_point_error": (_LAW, "m", "estimated error of the contact point"),
    "effect_regular": ("streamline", "1", "whether it passes no singular corner in any flow"),
    "effect_lowest": (
        _LINE,
        "Pa",
        "lowest pressure on a fiber below the middle of the capillary, above the surrounding "
        "air's, mean over the initial angles",
    ),
    "effect_bound": (_LINE, "Pa", "the same of any direction"),
    "effect_period": (_FIBER, "1", "time of a turn in simple shear times rate; NaN if it stalls"),
    "effect_stall_angle": (_FIBER, "rad", "angle to simple shear at which it stalls; NaN if not"),
    "effect_peak": (_FIBER, "1", "largest pressure in simple shear over viscosity and rate there"),
    "effect_peak_error": (_FIBER, "1", "estimated error of that"),
}
"""``{name: (dimensions, unit, long name)}``, as `fibermelt.parts.variables.VARIABLES`."""
