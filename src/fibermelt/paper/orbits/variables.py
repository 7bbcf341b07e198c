"""The variables of the sensitivity studies of one fiber, declared like those of the chain."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["SENSITIVITY_VARIABLES"]

_TURN = "case orbit_model"
_INSTANT = "case orbit_model instant"
_FEATURE = "feature dimension_model"

SENSITIVITY_VARIABLES: Mapping[str, tuple[str, str, str]] = {
    # One fiber in simple shear: cases, and what they come to over a turn.
    "ratio": ("ratio", "1", "aspect ratio"),
    "case_sweep": ("case", "1", "what is varied: base, aspect_ratio, shear_rate or viscosity"),
    "case_aspect_ratio": ("case", "1", "aspect ratio of the case"),
    "case_shear_rate": ("case", "1/s", "shear rate of the case"),
    "case_viscosity": ("case", "Pa s", "viscosity of the case"),
    "orbit_model": ("orbit_model", "1", "confined-ellipse: in its cell; ellipse: unbounded"),
    "orbit_domain_size": ("", "1", "domain-size factor M of the cells"),
    "orbit_shape_factor": (_TURN, "1", "shape factor B; Jeffery's xi if unbounded"),
    "orbit_period": (_TURN, "s", "time of a full turn; NaN if the fiber stalls"),
    "orbit_lowest": (_TURN, "Pa", "lowest surface pressure over the turn"),
    "orbit_highest": (_TURN, "Pa", "highest surface pressure over the turn"),
    "orbit_tip_lowest": (_TURN, "Pa", "lowest tip pressure over the turn"),
    "orbit_tip_highest": (_TURN, "Pa", "highest tip pressure over the turn"),
    "orbit_angle_at_lowest": (_TURN, "rad", "angle from the flow at the lowest pressure"),
    "orbit_where_lowest": (_TURN, "rad", "eccentric angle on the surface of the lowest pressure"),
    "printed_period": ("case", "s", "the paper's finite elements' (Table 1); NaN if not printed"),
    "printed_period_jeffery": ("case", "s", "Jeffery's as printed (Table 1); NaN if not printed"),
    # The same as time goes by.
    "turn_time": (_INSTANT, "s", "time since the fiber lay along the flow"),
    "turn_angle": (_INSTANT, "rad", "angle from the flow, continuous"),
    "turn_spin": (_INSTANT, "1/s", "rate of the angle"),
    "turn_lowest": (_INSTANT, "Pa", "lowest pressure over the surface"),
    "turn_highest": (_INSTANT, "Pa", "highest pressure over the surface"),
    "turn_tip": (_INSTANT, "Pa", "pressure at the tips"),
    # Around the fiber when its pressure is lowest.
    "near_angle": ("ratio", "rad", "angle of the fiber from the flow"),
    "near_point": ("ratio ring ray component", "1", "net in the fiber's axes, over half-lengths"),
    "near_pressure": ("ratio ring ray", "Pa", "pressure on the net less the far field's"),
    # Two dimensions against three.
    "dimension_model": ("dimension_model", "1", "what answers for the fiber"),
    "dimension_domain_size": ("", "1", "domain-size factor M of the confined ellipses"),
    "unbounded_model": ("unbounded_model", "1", "closed form"),
    "peak_ratio": ("peak", "1", "aspect ratio"),
    "peak_pressure": ("unbounded_model peak", "1", "highest pressure in shear over mu gamma_dot"),
    "peak_at_ratio": ("dimension_model ratio", "1", "highest pressure in shear over mu gamma_dot"),
    "planar_angle": ("planar_angle", "rad", "angle of the fiber at the inlet, in the plane"),
    "feature_streamline": ("feature", "1", "number of the streamline, from the left edge"),
    "feature_time": ("feature point", "s", "time since the inlet"),
    "feature_middle_time": ("feature", "s", "time at the middle of the capillary"),
    "feature_bound": (f"{_FEATURE} point", "Pa", "lowest pressure over every orientation"),
    "feature_lowest": (f"{_FEATURE} point", "Pa", "lowest pressure over the initial angles"),
    "feature_extreme": (
        f"{_FEATURE} planar_angle location",
        "Pa",
        "lowest pressure on the way of each initial angle",
    ),
    "feature_extreme_bound": (
        f"{_FEATURE} location",
        "Pa",
        "lowest pressure on the way over every orientation",
    ),
}
"""``{name: (dimensions, unit, long name)}``, as in `fibermelt.parts.variables`."""
