"""The suspension of a study: its interaction coefficient, its model, its preferred angle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from fibermelt.orientation.closures import closure as named
from fibermelt.orientation.flows import flow_gradient, shear_rate, strain_and_spin
from fibermelt.orientation.fokker_planck import steady_distribution
from fibermelt.orientation.interaction import interaction_law
from fibermelt.orientation.kinetics import CONVENTIONS
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import preferred_angle as angle_of
from fibermelt.parts.interaction.models import build_model

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.orientation.models import FolgarTucker

    Array = NDArray[np.float64]

__all__ = [
    "DISTRIBUTION",
    "folgar_tucker",
    "interaction_coefficient",
    "preferred_angle",
    "rotary_diffusivity",
]

DISTRIBUTION = "exact-pdf"
"""What stands in the place of a closure for the distribution itself, which needs none."""


def interaction_coefficient(
    coefficient: float | None, law: str, volume_fraction: float, aspect_ratio: float
) -> float:
    """Return ``C_I`` [-]: as given, or what a law says of content and aspect ratio."""
    if coefficient is not None:
        return coefficient
    return interaction_law(law).coefficient(volume_fraction, aspect_ratio)


def folgar_tucker(aspect_ratio: float, interaction: float, convention: Any) -> FolgarTucker:
    """Return the Folgar-Tucker model of a fiber; its shape factor is Jeffery's."""
    model = build_model("folgar-tucker", aspect_ratio, interaction, convention, {})
    return cast("FolgarTucker", model)


def rotary_diffusivity(model: FolgarTucker, gradient: Array) -> Array:
    """Return ``D_r = C_I gamma_dot`` [1/s] of velocity gradients (..., 3, 3), (...)."""
    rate = shear_rate(strain_and_spin(gradient)[0])
    return model.interaction * CONVENTIONS[model.convention] * rate


def preferred_angle(model: FolgarTucker, closure: str) -> float:
    """Return the preferred angle in simple shear [rad] from the flow (the paper's Eq. 31).

    The closure may be `DISTRIBUTION`, which is none: the distribution's own moment.
    """
    shear = flow_gradient("simple-shear")
    if closure != DISTRIBUTION:
        return steady_state(model, shear, named(closure)).angle
    diffusivity = float(rotary_diffusivity(model, shear))
    found = steady_distribution(shear, model.shape_factor, diffusivity)
    return float(angle_of(found.second()))
