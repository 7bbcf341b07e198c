"""From fiber content to the size of the cell, and orientation tensors along the streamlines.

What computes is imported when a stage runs, so that a study that is stored costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.parts.interaction.config import OWN, WITHOUT_COEFFICIENT
from fibermelt.parts.orientation.models import build_model, model_in_words
from fibermelt.parts.variables import labelled

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.fiber.stall_data import StallCurve
    from fibermelt.orientation.models import FolgarTucker, OrientationModel

    Array = NDArray[np.float64]

__all__ = [
    "DISTRIBUTION",
    "content_stage",
    "folgar_tucker",
    "interaction_coefficient",
    "orientation_estimates",
    "orientation_stage",
    "preferred_angle",
    "rotary_diffusivity",
    "stall_estimates",
    "stall_stage",
    "stored_curve",
]


DISTRIBUTION = "exact-pdf"
"""What stands in the place of a closure for the distribution itself, which needs none."""

TENSOR_BOUND = 1e-3
"""Largest estimated error of a component of a tensor, by a closure or of the distribution itself: a
tenth of what a good closure is off, which the one is held against the other for. The integration
leaves 1e-7 and 1e-5."""

WAY_OUT = "take more streamlines.points, or a larger interaction.coefficient"


def stall_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Compute where a confined fiber stalls, against the size of its cell."""
    from fibermelt.fiber.stall import stall_curve  # noqa: PLC0415  lazy: see the module

    curve = stall_curve(parameters["fiber.aspect_ratio"])
    say(f"the fiber stalls in cells up to M = {curve.largest_stalling_domain:.4f}")
    return labelled(
        {
            "stall_domain_size": curve.domain_size,
            "stall_shape_factor": curve.shape_factor,
            "stall_shape_factor_error": curve.error,
            "stall_aspect_ratio": curve.fiber_aspect_ratio,
            "largest_stalling_domain": curve.largest_stalling_domain,
        }
    )


def stall_estimates(parameters: Parameters, stall: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the error of the stall angle's curve with its bound, that of `stall_curve`."""
    from fibermelt.fiber.stall import CURVE_TOLERANCE  # noqa: PLC0415  lazy: see the module

    error = float(stall["stall_shape_factor_error"])
    cure = "take another fiber.aspect_ratio"
    return (Estimate("stall_shape_factor_error", error, CURVE_TOLERANCE, cure),)


def stored_curve(stall: xr.Dataset) -> StallCurve:
    """Return the curve that was stored."""
    from fibermelt.fiber.stall_data import StallCurve  # noqa: PLC0415  lazy: see the module

    return StallCurve(
        float(stall["stall_aspect_ratio"]),
        stall["stall_domain_size"].to_numpy(),
        stall["stall_shape_factor"].to_numpy(),
        float(stall["stall_shape_factor_error"]),
    )


def interaction_coefficient(
    coefficient: float | None, law: str, volume_fraction: float, aspect_ratio: float
) -> float:
    """Return ``C_I`` [-]: as given, or what a law says of content and aspect ratio."""
    from fibermelt.orientation.interaction import interaction_law  # noqa: PLC0415  lazy

    if coefficient is not None:
        return coefficient
    return interaction_law(law).coefficient(volume_fraction, aspect_ratio)


def folgar_tucker(aspect_ratio: float, interaction: float, convention: Any) -> FolgarTucker:
    """Return the Folgar-Tucker model of a fiber; its shape factor is Jeffery's."""
    model = build_model("folgar-tucker", aspect_ratio, interaction, convention, {})
    return cast("FolgarTucker", model)


def rotary_diffusivity(model: FolgarTucker, gradient: Array) -> Array:
    """Return ``D_r = C_I gamma_dot`` [1/s] of velocity gradients (..., 3, 3), (...)."""
    from fibermelt.orientation.flows import shear_rate, strain_and_spin  # noqa: PLC0415  lazy
    from fibermelt.orientation.kinetics import CONVENTIONS  # noqa: PLC0415

    rate = shear_rate(strain_and_spin(gradient)[0])
    return model.interaction * CONVENTIONS[model.convention] * rate


def preferred_angle(model: FolgarTucker, closure: str) -> float:
    """Return the preferred angle in simple shear [rad] from the flow (the paper's Eq. 31).

    The closure may be `DISTRIBUTION`, which is none: the distribution's own moment.
    """
    from fibermelt.orientation.closures import closure as named  # noqa: PLC0415  lazy
    from fibermelt.orientation.flows import flow_gradient  # noqa: PLC0415
    from fibermelt.orientation.fokker_planck import steady_distribution  # noqa: PLC0415
    from fibermelt.orientation.steady import steady_state  # noqa: PLC0415
    from fibermelt.orientation.tensors import preferred_angle as angle_of  # noqa: PLC0415

    shear = flow_gradient("simple-shear")
    if closure != DISTRIBUTION:
        return steady_state(model, shear, named(closure)).angle
    diffusivity = float(rotary_diffusivity(model, shear))
    found = steady_distribution(shear, model.shape_factor, diffusivity)
    return float(angle_of(found.second()))


def content_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Follow the paper's section 2.5: content, interaction, preferred angle, size of the cell.

    The suspension is Folgar and Tucker's, whatever model the tensors follow along the streamlines.
    The cell is the one in which a single fiber stalls at the preferred angle of its suspension.
    """
    from fibermelt.orientation.interaction import regime  # noqa: PLC0415  lazy: see the module

    aspect_ratio = parameters["fiber.aspect_ratio"]
    content = parameters["interaction.volume_fraction"]
    interaction = interaction_coefficient(
        parameters["interaction.coefficient"],
        parameters["interaction.law"],
        content,
        aspect_ratio,
    )
    model = folgar_tucker(aspect_ratio, interaction, parameters["interaction.convention"])
    angle = preferred_angle(model, parameters["interaction.closure"])
    domain_size = stored_curve(inputs["stall"]).domain_size_at(angle)
    say(f"C_I = {interaction:.5f}, preferred angle {angle:.4f} rad, M = {domain_size:.4f}")
    return labelled(
        {
            "interaction_coefficient": interaction,
            "preferred_angle": angle,
            "content_domain_size": domain_size,
            "content_regime": regime(content, aspect_ratio),
        }
    )


def orientation_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Follow the orientation tensor along every streamline, and the distribution along one.

    The distribution is known for isotropic diffusion only: beside Folgar and Tucker's model.
    """
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.orientation.closures import closure as named  # noqa: PLC0415
    from fibermelt.orientation.evolve import follow_orientation  # noqa: PLC0415
    from fibermelt.orientation.models import FolgarTucker  # noqa: PLC0415

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
    return labelled(variables)


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
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.orientation.steady import steady_state  # noqa: PLC0415
    from fibermelt.orientation.tensors import isotropic  # noqa: PLC0415

    if name == "isotropic":
        return np.broadcast_to(isotropic(), (len(first), 3, 3))
    return np.stack([steady_state(model, L, closure).a for L in first])


def _distribution(
    model: FolgarTucker, time: Array, gradient: Array, enters: str
) -> tuple[Array, float]:
    """Return the second moment (n, 3, 3) of the distribution along a history, and its error.

    No closure is in it. It starts isotropic, or steady in the inlet's flow.
    """
    from fibermelt.orientation.flows import embedded  # noqa: PLC0415  lazy: see the module
    from fibermelt.orientation.fokker_planck import (  # noqa: PLC0415
        follow_distribution,
        steady_distribution,
    )

    L = embedded(gradient)
    diffusivity, xi = rotary_diffusivity(model, L), model.shape_factor
    steady = enters != "isotropic"
    initial = steady_distribution(L[0], xi, float(diffusivity[0])) if steady else None
    history = follow_distribution(time, L, xi, diffusivity, initial)
    return history.distribution.second(), history.error
