"""Orientation tensors along the streamlines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.orientation.closures import closure as named
from fibermelt.orientation.evolve import follow_orientation
from fibermelt.orientation.flows import embedded
from fibermelt.orientation.fokker_planck import follow_distribution, steady_distribution
from fibermelt.orientation.models import FolgarTucker
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import isotropic
from fibermelt.parts.interaction.config import OWN, WITHOUT_COEFFICIENT
from fibermelt.parts.interaction.models import build_model, model_in_words
from fibermelt.parts.interaction.suspension import interaction_coefficient, rotary_diffusivity
from fibermelt.parts.orientation.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.orientation.models import OrientationModel

    Array = NDArray[np.float64]

__all__ = ["orientation_estimates", "orientation_stage"]


TENSOR_BOUND = 1e-3
"""Largest estimated error of a component of a tensor, by a closure or of the distribution itself: a
tenth of what a good closure is off, which the one is held against the other for. The integration
leaves 1e-7 and 1e-5."""

WAY_OUT = "take more streamlines.points, or a larger interaction.coefficient"


def orientation_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Follow the orientation tensor along every streamline, and the distribution along one.

    The distribution is known for isotropic diffusion only: beside Folgar and Tucker's model.
    """
    lines = inputs["streamlines"]
    time, gradient = lines["time"].to_numpy(), lines["gradient"].to_numpy()
    aspect_ratio, name = parameters["fiber.aspect_ratio"], parameters["interaction.model"]
    interaction = (
        None
        if name in WITHOUT_COEFFICIENT
        else interaction_coefficient(
            parameters["interaction.coefficient"],
            parameters["interaction.law"],
            parameters["interaction.volume_fraction"],
            aspect_ratio,
        )
    )
    own = {name: parameters[f"interaction.{name}"] for name in OWN[name]}
    model = build_model(name, aspect_ratio, interaction, parameters["interaction.convention"], own)
    closure = named(parameters["interaction.closure"])
    start = _start(parameters["interaction.start"], model, gradient[:, 0], closure)
    told = model_in_words(name, interaction, own)
    say(f"{told}, closure {closure.name}, {len(time)} streamlines")
    found = follow_orientation(model, closure, (time, gradient), start)
    variables: dict[str, Any] = {
        "orientation": found.a,
        "orientation_error": found.error,
        "orientation_violation": found.violation,
        "orientation_model": name,
        "orientation_closure": closure.name,
    }
    if own:
        variables |= {"model_parameter": list(own), "orientation_parameter": list(own.values())}
    if interaction is not None:
        variables["orientation_interaction"] = interaction
    if hasattr(model, "convention"):
        variables["orientation_convention"] = model.convention
    if type(model) is FolgarTucker:
        center = int(np.argmin(np.abs(lines["flux_fraction"].to_numpy() - CENTER_FRACTION)))
        say("the distribution itself, along the center streamline")
        enters = parameters["interaction.start"]
        exact, exact_error = _distribution(model, time[center], gradient[center], enters)
        variables |= {
            "closure_streamline": int(lines["streamline"][center]),
            "closure_exact": exact,
            "closure_exact_error": exact_error,
            "closure_error": np.abs(found.a[center] - exact).max(axis=(-2, -1)),
        }
    return labelled(variables, QUANTITIES)


def orientation_estimates(parameters: Parameters, found: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the errors of orientation tensors, each with its bound."""
    return tuple(
        Estimate(name, float(found[name].max()), TENSOR_BOUND, WAY_OUT)
        for name in ("orientation_error", "closure_exact_error")
        if name in found
    )


CENTER_FRACTION = 9.5 / 22
"""Share of the flux left of the paper's streamline 10, on which closures are told by."""


def _start(name: str, model: OrientationModel, first: Array, closure: Any) -> Array:
    """Return the tensors with which fibers enter, one for each streamline."""
    if name == "isotropic":
        return np.broadcast_to(isotropic(), (len(first), 3, 3))
    return np.stack([steady_state(model, L, closure).a for L in first])


def _distribution(
    model: FolgarTucker, time: Array, gradient: Array, enters: str
) -> tuple[Array, float]:
    """Return the second moment (n, 3, 3) of the distribution along a history, and its error.

    No closure is in it. It starts isotropic, or steady in the inlet's flow.
    """
    L = embedded(gradient)
    diffusivity, xi = rotary_diffusivity(model, L), model.shape_factor
    steady = enters != "isotropic"
    initial = steady_distribution(L[0], xi, float(diffusivity[0])) if steady else None
    history = follow_distribution(time, L, xi, diffusivity, initial)
    return history.distribution.second(), history.error
