"""The paper's section 2.5 for any fiber: from content to the cell; its Fig. 14 and 15."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber.stall import CURVE_TOLERANCE, PAPER_DOMAIN_END, paper_stall_angle, stall_curve
from fibermelt.fiber.stall_data import StallCurve
from fibermelt.fiber.tumbling import turned_angle
from fibermelt.orientation.closures import closure as named
from fibermelt.orientation.flows import flow_gradient
from fibermelt.orientation.interaction import paper_domain_size, paper_preferred_angle, regime
from fibermelt.orientation.steady import steady_state
from fibermelt.parts.interaction.quantities import QUANTITIES
from fibermelt.parts.interaction.suspension import (
    DISTRIBUTION,
    folgar_tucker,
    interaction_coefficient,
    preferred_angle,
)

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = [
    "content_stage",
    "interaction_stage",
    "stall_estimates",
    "stall_stage",
    "stored_curve",
]

CLOSURES = ("ORE", "ORF", "ORW3", "IBOF", "exact", "quadratic", "hybrid")
"""Closures whose preferred angles are drawn: the paper's, the fits in use, and the crude ones."""

CONVENTIONS = ("standard", "paper")

LEAST_INTERACTION, STEPS_AN_OCTAVE, INTERACTIONS = 0.003, 4, 15
"""The first interaction coefficient of a curve, how many to twice as much, and how many; the last
is 0.034, as Eq. 34 holds up to 0.041."""

SIZES = 121
"""Points of the stall angle's curve."""

SMALLEST_DRAWN, LONGEST_TIME, TIMES = 3.0, 20.0, 241
"""Smallest cell, longest time [1/gamma_dot] and points of a fiber's motion towards its stall; the
paper's Eq. 32 is compared with from that cell on, as a parabola cannot follow smaller ones."""


def stall_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Compute where a confined fiber stalls, against the size of its cell."""
    curve = stall_curve(parameters["fiber.aspect_ratio"])
    say(f"the fiber stalls in cells up to M = {curve.largest_stalling_domain:.4f}")
    return labelled(
        {
            "stall_domain_size": curve.domain_size,
            "stall_shape_factor": curve.shape_factor,
            "stall_shape_factor_error": curve.error,
            "stall_aspect_ratio": curve.fiber_aspect_ratio,
            "largest_stalling_domain": curve.largest_stalling_domain,
        },
        QUANTITIES,
    )


def stall_estimates(parameters: Parameters, stall: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the error of the stall angle's curve with its bound, that of `stall_curve`."""
    error = float(stall["stall_shape_factor_error"])
    cure = "take another fiber.aspect_ratio"
    return (Estimate("stall_shape_factor_error", error, CURVE_TOLERANCE, cure),)


def stored_curve(stall: xr.Dataset) -> StallCurve:
    """Return the curve that was stored."""
    return StallCurve(
        float(stall["stall_aspect_ratio"]),
        stall["stall_domain_size"].to_numpy(),
        stall["stall_shape_factor"].to_numpy(),
        float(stall["stall_shape_factor_error"]),
    )


def content_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Follow the paper's section 2.5: content, interaction, preferred angle, size of the cell.

    The suspension is Folgar and Tucker's, whatever model the tensors follow along the streamlines.
    The cell is the one in which a single fiber stalls at the preferred angle of its suspension.
    """
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
        },
        QUANTITIES,
    )


def interaction_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Compute stall angles against cells, preferred angles against C_I, and one against another."""
    curve = stored_curve(inputs["stall"])
    interaction = LEAST_INTERACTION * 2.0 ** (np.arange(INTERACTIONS) / STEPS_AN_OCTAVE)
    aspect_ratio, closure = parameters["fiber.aspect_ratio"], parameters["interaction.closure"]
    say(f"{len(CLOSURES)} closures and the distribution at {INTERACTIONS} C_I")
    angle = np.stack(
        [_by_convention(aspect_ratio, interaction, one) for one in (*CLOSURES, DISTRIBUTION)],
        axis=1,
    )
    chosen = _by_convention(aspect_ratio, interaction, closure)
    domain = np.array([[_domain_size(curve, one) for one in row] for row in chosen])
    return labelled(
        {
            **_stalling(curve),
            **_stall_angles(curve),
            "closure": [*CLOSURES, DISTRIBUTION],
            "convention": list(CONVENTIONS),
            "interaction": interaction,
            "interaction_angle": angle,
            "interaction_domain_size": domain,
            "interaction_closure": closure,
            **_polynomials(interaction, chosen, domain),
        },
        QUANTITIES,
    )


def _stalling(curve: StallCurve) -> dict[str, Any]:
    """Return how fibers turn, from across the flow, until they stall (the paper's Fig. 14a-b)."""
    largest = np.floor(10 * curve.largest_stalling_domain) / 10
    sizes = np.linspace(min(SMALLEST_DRAWN, largest), largest, 5)
    time, factor = np.linspace(0.0, LONGEST_TIME, TIMES), curve.value(sizes)
    angle = np.stack([turned_angle(float(B), 1.0, time, 0.5 * np.pi) for B in factor])
    return {
        "stalling_domain_size": sizes,
        "stalling_time": time,
        "stalling_angle": angle,
        "stalling_spin": 0.5 * (factor[:, None] * np.cos(2 * angle) - 1),
    }


def _stall_angles(curve: StallCurve) -> dict[str, Any]:
    """Return the stall angle against the size of the cell (Fig. 14c), Eq. 32 where it holds."""
    sizes = np.linspace(float(curve.domain_size[0]), curve.largest_stalling_domain, SIZES)
    angle = np.nan_to_num(curve.stall_angle(sizes), nan=0.0)
    fitted = (sizes >= SMALLEST_DRAWN) & (sizes <= PAPER_DOMAIN_END)
    paper = np.full(SIZES, np.nan)
    paper[fitted] = paper_stall_angle(sizes[fitted])
    return {
        "stall_curve_domain_size": sizes,
        "stall_curve_angle": angle,
        "stall_curve_paper": paper,
        "stall_curve_difference": _largest(angle - paper),
    }


def _by_convention(aspect_ratio: float, interaction: Array, closure: str) -> Array:
    """Return the preferred angle [rad] by convention and C_I (Fig. 14d), NaN where there is none.

    The paper's rate of deformation is ``sqrt(2)`` times the standard one, so its angles are the
    standard ones of a ``C_I`` half an octave up.
    """
    shift = STEPS_AN_OCTAVE // 2
    beyond = interaction[-1] * 2.0 ** (np.arange(1, shift + 1) / STEPS_AN_OCTAVE)
    every = np.concatenate([interaction, beyond])
    angle = _angles(aspect_ratio, every, closure)
    return np.stack([angle[: len(interaction)], angle[shift:]])


def _angles(aspect_ratio: float, interaction: Array, closure: str) -> Array:
    """Return preferred angles [rad] in the standard convention, NaN where there is none."""
    models = [folgar_tucker(aspect_ratio, float(C_I), "standard") for C_I in interaction]
    if closure == DISTRIBUTION:
        return np.array([preferred_angle(model, DISTRIBUTION) for model in models])
    found, shear, chosen = (
        np.full(len(models), np.nan),
        flow_gradient("simple-shear"),
        named(closure),
    )
    start = None
    for k in reversed(range(len(models))):  # from the one before, with more diffusion
        try:
            state = steady_state(models[k], shear, chosen, start)
        except ConvergenceError:
            start = None
            continue
        found[k], start = state.angle, state.a
    return found


def _domain_size(curve: StallCurve, angle: float) -> float:
    """Return the cell that stalls the fiber at an angle, NaN where none does."""
    try:
        return curve.domain_size_at(angle)
    except ConfigError:
        return float("nan")


def _polynomials(interaction: Array, angle: Array, domain: Array) -> dict[str, Any]:
    """Return the paper's Eq. 33 and 34 and how far the computed curves are, by convention."""
    angles, sizes = paper_preferred_angle(interaction), paper_domain_size(interaction)
    return {
        "interaction_angle_paper": angles,
        "interaction_angle_difference": np.array([_largest(one - angles) for one in angle]),
        "interaction_domain_size_paper": sizes,
        "interaction_domain_size_difference": np.array([_largest(one - sizes) for one in domain]),
    }


def _largest(difference: Array) -> float:
    """Return the largest size of a difference, over where both sides are."""
    known = np.abs(difference[np.isfinite(difference)])
    return float(known.max()) if known.size else float("nan")
