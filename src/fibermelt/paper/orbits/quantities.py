"""What is stored of single fibers in simple shear."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

_TURN = "case orbit_model"
_INSTANT = "case orbit_model instant"

# fmt: off
QUANTITIES = declared(
    # One fiber in simple shear: cases, and what they come to over a turn.
    Q("ratio", "ratio", "1", "aspect ratio"),
    Q("case_sweep", "case", "1", "what is varied: base, aspect_ratio, shear_rate or viscosity"),
    Q("case_aspect_ratio", "case", "1", "aspect ratio of the case"),
    Q("case_shear_rate", "case", "1/s", "shear rate of the case"),
    Q("case_viscosity", "case", "Pa s", "viscosity of the case"),
    Q("orbit_model", "orbit_model", "1", "confined-ellipse: in its cell; ellipse: unbounded"),
    Q("orbit_domain_size", "", "1", "domain-size factor M of the cells"),
    Q("orbit_shape_factor", _TURN, "1", "shape factor B; Jeffery's xi if unbounded"),
    Q("orbit_period", _TURN, "s", "time of a full turn; NaN if the fiber stalls"),
    Q("orbit_lowest", _TURN, "Pa", "lowest surface pressure over the turn"),
    Q("orbit_highest", _TURN, "Pa", "highest surface pressure over the turn"),
    Q("orbit_tip_lowest", _TURN, "Pa", "lowest tip pressure over the turn"),
    Q("orbit_tip_highest", _TURN, "Pa", "highest tip pressure over the turn"),
    Q("orbit_angle_at_lowest", _TURN, "rad", "angle from the flow at the lowest pressure"),
    Q("orbit_where_lowest", _TURN, "rad", "eccentric angle on the surface of the lowest pressure"),
    Q("printed_period", "case", "s", "the paper's finite elements' (Table 1); NaN if not printed"),
    Q("printed_period_jeffery", "case", "s", "Jeffery's as printed (Table 1); NaN if not printed"),
    # The same as time goes by.
    Q("turn_time", _INSTANT, "s", "time since the fiber lay along the flow"),
    Q("turn_angle", _INSTANT, "rad", "angle from the flow, continuous"),
    Q("turn_spin", _INSTANT, "1/s", "rate of the angle"),
    Q("turn_lowest", _INSTANT, "Pa", "lowest pressure over the surface"),
    Q("turn_highest", _INSTANT, "Pa", "highest pressure over the surface"),
    Q("turn_tip", _INSTANT, "Pa", "pressure at the tips"),
    # Around the fiber when its pressure is lowest.
    Q("near_angle", "ratio", "rad", "angle of the fiber from the flow"),
    Q("near_point", "ratio ring ray component", "1", "net in the fiber's axes, over half-lengths"),
    Q("near_pressure", "ratio ring ray", "Pa", "pressure on the net less the far field's"),
)
# fmt: on
"""What this part stores, by name."""
