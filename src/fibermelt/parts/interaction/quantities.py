"""What is stored of stall and preferred angles as curves."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity, declared

__all__ = ["QUANTITIES"]

_ANGLES = "convention closure interaction"

QUANTITIES = declared(
    Quantity("closure", "closure", "1", "closure of the fourth moment; exact-pdf needs none"),
    Quantity("convention", "convention", "1", "which rate of deformation multiplies C_I"),
    Quantity("interaction", "interaction", "1", "interaction coefficient C_I of the curves"),
    Quantity("interaction_angle", _ANGLES, "rad", "preferred angle in simple shear"),
    Quantity("interaction_closure", "", "1", "closure of the study"),
    Quantity(
        "interaction_angle_paper", "interaction", "rad", "preferred angle, the paper's Eq. 33"
    ),
    Quantity("interaction_angle_difference", "convention", "rad", "largest difference from Eq. 33"),
    Quantity(
        "interaction_domain_size",
        "convention interaction",
        "1",
        "domain size M from C_I; NaN where no cell stalls the fiber there",
    ),
    Quantity(
        "interaction_domain_size_paper", "interaction", "1", "domain size M, the paper's Eq. 34"
    ),
    Quantity(
        "interaction_domain_size_difference", "convention", "1", "largest difference from Eq. 34"
    ),
    Quantity(
        "stall_curve_domain_size", "stall_size", "1", "domain sizes M of the stall angle's curve"
    ),
    Quantity("stall_curve_angle", "stall_size", "rad", "stall angle from the flow"),
    Quantity(
        "stall_curve_paper", "stall_size", "rad", "the paper's Eq. 32; NaN where it does not hold"
    ),
    Quantity("stall_curve_difference", "", "rad", "largest difference from Eq. 32"),
    Quantity(
        "stalling_domain_size", "stalling_size", "1", "domain sizes M of fibers seen to stall"
    ),
    Quantity(
        "stalling_time", "stalling_time", "s", "time since the fiber lay across a flow of 1/s"
    ),
    Quantity("stalling_angle", "stalling_size stalling_time", "rad", "its angle from the flow"),
    Quantity("stalling_spin", "stalling_size stalling_time", "1/s", "its spin"),
)
"""What this part stores, by name."""
