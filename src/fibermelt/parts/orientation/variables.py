"""Variables of results.nc on orientation and on the size of the cell; see study.variables."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["ORIENTATION_VARIABLES"]

_ANGLES = "convention closure interaction"

ORIENTATION_VARIABLES: Mapping[str, tuple[str, str, str]] = {
    # Where a confined fiber stalls.
    "stall_domain_size": ("stall_node", "1", "domain sizes M of the cells that were solved"),
    "stall_shape_factor": ("stall_node", "1", "shape factor B in them"),
    "stall_shape_factor_error": ("", "1", "estimated error of B between them"),
    "stall_aspect_ratio": ("", "1", "aspect ratio of the fiber in them"),
    "largest_stalling_domain": ("", "1", "domain size M above which the fiber tumbles"),
    # From content to the size of the cell.
    "interaction_coefficient": ("", "1", "interaction coefficient C_I"),
    "preferred_angle": ("", "rad", "preferred angle of the suspension in simple shear"),
    "content_domain_size": ("", "1", "domain size M at which the fiber stalls there"),
    "content_regime": ("", "1", "regime of concentration"),
    # The same as curves.
    "closure": ("closure", "1", "closure of the fourth moment; exact-pdf needs none"),
    "convention": ("convention", "1", "which rate of deformation multiplies C_I"),
    "interaction": ("interaction", "1", "interaction coefficient C_I of the curves"),
    "interaction_angle": (_ANGLES, "rad", "preferred angle in simple shear"),
    "interaction_closure": ("", "1", "closure of the study"),
    "interaction_angle_paper": ("interaction", "rad", "preferred angle, the paper's Eq. 33"),
    "interaction_angle_difference": ("convention", "rad", "largest difference from Eq. 33"),
    "interaction_domain_size": (
        "convention interaction",
        "1",
        "domain size M from C_I; NaN where no cell stalls the fiber there",
    ),
    "interaction_domain_size_paper": ("interaction", "1", "domain size M, the paper's Eq. 34"),
    "interaction_domain_size_difference": ("convention", "1", "largest difference from Eq. 34"),
    "stall_curve_domain_size": ("stall_size", "1", "domain sizes M of the stall angle's curve"),
    "stall_curve_angle": ("stall_size", "rad", "stall angle from the flow"),
    "stall_curve_paper": ("stall_size", "rad", "the paper's Eq. 32; NaN where it does not hold"),
    "stall_curve_difference": ("", "rad", "largest difference from Eq. 32"),
    "stalling_domain_size": ("stalling_size", "1", "domain sizes M of fibers seen to stall"),
    "stalling_time": ("stalling_time", "s", "time since the fiber lay across a flow of 1/s"),
    "stalling_angle": ("stalling_size stalling_time", "rad", "its angle from the flow"),
    "stalling_spin": ("stalling_size stalling_time", "1/s", "its spin"),
    # Along the streamlines.
    "orientation": (
        "streamline point axis other_axis",
        "1",
        "second-order orientation tensor, axes x, y, z",
    ),
    "orientation_error": ("streamline", "1", "estimated error of its components"),
    "orientation_violation": ("streamline", "1", "how far its eigenvalues leave [0, 1]"),
    "orientation_model": ("", "1", "model of the orientation along the streamlines"),
    "model_parameter": ("model_parameter", "1", "what the model takes besides C_I"),
    "orientation_parameter": ("model_parameter", "1", "its values"),
    "orientation_interaction": ("", "1", "interaction coefficient C_I along the streamlines"),
    "orientation_closure": ("", "1", "closure of the fourth moment along the streamlines"),
    "orientation_convention": ("", "1", "which rate of deformation multiplies C_I there"),
    "closure_streamline": ("", "1", "streamline along which the closure is judged"),
    "closure_exact": ("point axis other_axis", "1", "tensor of the distribution itself there"),
    "closure_exact_error": ("", "1", "estimated error of it"),
    "closure_error": ("point", "1", "largest error of a component by the closure"),
}
"""``{name: (dimensions, unit, long name)}``, as in `fibermelt.parts.variables.VARIABLES`."""
