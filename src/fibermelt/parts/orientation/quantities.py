"""What is stored of orientation, and of the size of the cell that a content asks for."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity, declared

__all__ = ["QUANTITIES"]

QUANTITIES = declared(
    # Where a confined fiber stalls.
    Quantity(
        "stall_domain_size", "stall_node", "1", "domain sizes M of the cells that were solved"
    ),
    Quantity(
        "stall_shape_factor",
        "stall_node",
        "1",
        "shape factor B in them",
        error="stall_shape_factor_error",
    ),
    Quantity("stall_shape_factor_error", "", "1", "estimated error of B between them"),
    Quantity("stall_aspect_ratio", "", "1", "aspect ratio of the fiber in them"),
    Quantity("largest_stalling_domain", "", "1", "domain size M above which the fiber tumbles"),
    # From content to the size of the cell.
    Quantity("interaction_coefficient", "", "1", "interaction coefficient C_I"),
    Quantity("preferred_angle", "", "rad", "preferred angle of the suspension in simple shear"),
    Quantity("content_domain_size", "", "1", "domain size M at which the fiber stalls there"),
    Quantity("content_regime", "", "1", "regime of concentration"),
    # Along the streamlines.
    Quantity(
        "orientation",
        "streamline point axis other_axis",
        "1",
        "second-order orientation tensor, axes x, y, z",
        error="orientation_error",
    ),
    Quantity("orientation_error", "streamline", "1", "estimated error of its components"),
    Quantity("orientation_violation", "streamline", "1", "how far its eigenvalues leave [0, 1]"),
    Quantity("orientation_model", "", "1", "model of the orientation along the streamlines"),
    Quantity("model_parameter", "model_parameter", "1", "what the model takes besides C_I"),
    Quantity("orientation_parameter", "model_parameter", "1", "its values"),
    Quantity(
        "orientation_interaction", "", "1", "interaction coefficient C_I along the streamlines"
    ),
    Quantity("orientation_closure", "", "1", "closure of the fourth moment along the streamlines"),
    Quantity("orientation_convention", "", "1", "which rate of deformation multiplies C_I there"),
    Quantity("closure_streamline", "", "1", "streamline along which the closure is judged"),
    Quantity(
        "closure_exact",
        "point axis other_axis",
        "1",
        "tensor of the distribution itself there",
        error="closure_exact_error",
    ),
    Quantity("closure_exact_error", "", "1", "estimated error of it"),
    Quantity("closure_error", "point", "1", "largest error of a component by the closure"),
)
"""What this part stores, by name."""
