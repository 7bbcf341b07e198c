"""What is stored of single fibers in simple shear."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity, declared

__all__ = ["QUANTITIES"]

_TURN = "case orbit_model"
_INSTANT = "case orbit_model instant"

QUANTITIES = declared(
    # One fiber in simple shear: cases, and what they come to over a turn.
    Quantity("ratio", "ratio", "1", "aspect ratio"),
    Quantity(
        "case_sweep", "case", "1", "what is varied: base, aspect_ratio, shear_rate or viscosity"
    ),
    Quantity("case_aspect_ratio", "case", "1", "aspect ratio of the case"),
    Quantity("case_shear_rate", "case", "1/s", "shear rate of the case"),
    Quantity("case_viscosity", "case", "Pa s", "viscosity of the case"),
    Quantity(
        "orbit_model", "orbit_model", "1", "confined-ellipse: in its cell; ellipse: unbounded"
    ),
    Quantity("orbit_domain_size", "", "1", "domain-size factor M of the cells"),
    Quantity("orbit_shape_factor", _TURN, "1", "shape factor B; Jeffery's xi if unbounded"),
    Quantity("orbit_period", _TURN, "s", "time of a full turn; NaN if the fiber stalls"),
    Quantity("orbit_lowest", _TURN, "Pa", "lowest surface pressure over the turn"),
    Quantity("orbit_highest", _TURN, "Pa", "highest surface pressure over the turn"),
    Quantity("orbit_tip_lowest", _TURN, "Pa", "lowest tip pressure over the turn"),
    Quantity("orbit_tip_highest", _TURN, "Pa", "highest tip pressure over the turn"),
    Quantity("orbit_angle_at_lowest", _TURN, "rad", "angle from the flow at the lowest pressure"),
    Quantity(
        "orbit_where_lowest", _TURN, "rad", "eccentric angle on the surface of the lowest pressure"
    ),
    Quantity(
        "printed_period", "case", "s", "the paper's finite elements' (Table 1); NaN if not printed"
    ),
    Quantity(
        "printed_period_jeffery", "case", "s", "Jeffery's as printed (Table 1); NaN if not printed"
    ),
    # The same as time goes by.
    Quantity("turn_time", _INSTANT, "s", "time since the fiber lay along the flow"),
    Quantity("turn_angle", _INSTANT, "rad", "angle from the flow, continuous"),
    Quantity("turn_spin", _INSTANT, "1/s", "rate of the angle"),
    Quantity("turn_lowest", _INSTANT, "Pa", "lowest pressure over the surface"),
    Quantity("turn_highest", _INSTANT, "Pa", "highest pressure over the surface"),
    Quantity("turn_tip", _INSTANT, "Pa", "pressure at the tips"),
    # Around the fiber when its pressure is lowest.
    Quantity("near_angle", "ratio", "rad", "angle of the fiber from the flow"),
    Quantity(
        "near_point", "ratio ring ray component", "1", "net in the fiber's axes, over half-lengths"
    ),
    Quantity("near_pressure", "ratio ring ray", "Pa", "pressure on the net less the far field's"),
)
"""What this part stores, by name."""
