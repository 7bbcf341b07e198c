"""What is stored of content and the size of the cell: in numbers, and as curves."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

_ANGLES = "convention closure interaction"

# fmt: off
QUANTITIES = declared(
    # Where a confined fiber stalls.
    Q("stall_domain_size", "stall_node", "1", "domain sizes M of the cells that were solved"),
    Q("stall_shape_factor", "stall_node", "1", "shape factor B in them"),
    Q("stall_shape_factor_error", "", "1", "estimated error of B between them"),
    Q("stall_aspect_ratio", "", "1", "aspect ratio of the fiber in them"),
    Q("largest_stalling_domain", "", "1", "domain size M above which the fiber tumbles"),
    # From content to the size of the cell.
    Q("interaction_coefficient", "", "1", "interaction coefficient C_I"),
    Q("preferred_angle", "", "rad", "preferred angle of the suspension in simple shear"),
    Q("content_domain_size", "", "1", "domain size M at which the fiber stalls there"),
    Q("content_regime", "", "1", "regime of concentration"),
    # The same as curves.
    Q("closure", "closure", "1", "closure of the fourth moment; exact-pdf needs none"),
    Q("convention", "convention", "1", "which rate of deformation multiplies C_I"),
    Q("interaction", "interaction", "1", "interaction coefficient C_I of the curves"),
    Q("interaction_angle", _ANGLES, "rad", "preferred angle in simple shear"),
    Q("interaction_closure", "", "1", "closure of the study"),
    Q("interaction_angle_paper", "interaction", "rad", "preferred angle, the paper's Eq. 33"),
    Q("interaction_angle_difference", "convention", "rad", "largest difference from Eq. 33"),
    Q("interaction_domain_size", "convention interaction", "1",
      "domain size M from C_I; NaN where no cell stalls the fiber there"),
    Q("interaction_domain_size_paper", "interaction", "1", "domain size M, the paper's Eq. 34"),
    Q("interaction_domain_size_difference", "convention", "1", "largest difference from Eq. 34"),
    Q("stall_curve_domain_size", "stall_size", "1", "domain sizes M of the stall angle's curve"),
    Q("stall_curve_angle", "stall_size", "rad", "stall angle from the flow"),
    Q("stall_curve_paper", "stall_size", "rad", "the paper's Eq. 32; NaN where it does not hold"),
    Q("stall_curve_difference", "", "rad", "largest difference from Eq. 32"),
    Q("stalling_domain_size", "stalling_size", "1", "domain sizes M of fibers seen to stall"),
    Q("stalling_time", "stalling_time", "s", "time since the fiber lay across a flow of 1/s"),
    Q("stalling_angle", "stalling_size stalling_time", "rad", "its angle from the flow"),
    Q("stalling_spin", "stalling_size stalling_time", "1/s", "its spin"),
)
# fmt: on
"""What this part stores, by name."""
