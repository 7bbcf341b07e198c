"""What is stored of orientation tensors along the streamlines."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

# fmt: off
QUANTITIES = declared(
    Q("orientation", "streamline point axis other_axis", "1",
      "second-order orientation tensor, axes x, y, z"),
    Q("orientation_error", "streamline", "1", "estimated error of its components"),
    Q("orientation_violation", "streamline", "1", "how far its eigenvalues leave [0, 1]"),
    Q("orientation_model", "", "1", "model of the orientation along the streamlines"),
    Q("model_parameter", "model_parameter", "1", "what the model takes besides C_I"),
    Q("orientation_parameter", "model_parameter", "1", "its values"),
    Q("orientation_interaction", "", "1", "interaction coefficient C_I along the streamlines"),
    Q("orientation_closure", "", "1", "closure of the fourth moment along the streamlines"),
    Q("orientation_convention", "", "1", "which rate of deformation multiplies C_I there"),
    Q("closure_streamline", "", "1", "streamline along which the closure is judged"),
    Q("closure_exact", "point axis other_axis", "1", "tensor of the distribution itself there"),
    Q("closure_exact_error", "", "1", "estimated error of it"),
    Q("closure_error", "point", "1", "largest error of a component by the closure"),
)
# fmt: on
"""What this part stores, by name."""
