"""A suspension in a homogeneous flow: what `fibermelt orientation` answers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.errors import ConfigError, legible
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.closures import closure as named
from fibermelt.orientation.flows import flow_gradient, nearest_name
from fibermelt.orientation.fokker_planck import steady_distribution
from fibermelt.orientation.interaction import checked_interaction
from fibermelt.orientation.models import FolgarTucker, model_class
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import preferred_angle as angle_of
from fibermelt.parts.interaction.models import build_model
from fibermelt.parts.interaction.suspension import DISTRIBUTION, rotary_diffusivity
from fibermelt.questions.orbit import read_quantity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fibermelt.orientation.kinetics import OrientationModel

__all__ = [
    "OrientationStudy",
    "check_closure",
    "orientation_in_words",
    "read_parameters",
    "run_orientation",
]

SHAPE = ("shape_factor", "interaction", "convention")
"""What every model with diffusion takes; all else is the model's own."""


@dataclass(frozen=True)
class OrientationStudy:
    """A suspension in a homogeneous flow at unit rate.

    Parameters
    ----------
    closure : str
        One of `fibermelt.orientation.closures.CLOSURES`, or ``"exact-pdf"``: the distribution.
    interaction : float or None
        ``C_I`` [-], positive; None for a model that has coefficients of its own in its place.
    aspect_ratio : float
        ``r_e`` [-], at least one.
    model : str
        One of `fibermelt.orientation.models.MODELS`.
    flow : str
        One of `fibermelt.orientation.flows.FLOWS`; simple shear is ``v_1 = x_2``.
    convention : str
        ``"standard"`` or ``"paper"``.
    parameters : dict
        What the model takes besides, by name.
    """

    closure: str
    interaction: float | None
    aspect_ratio: float
    model: str = "folgar-tucker"
    flow: str = "simple-shear"
    convention: str = "standard"
    parameters: Mapping[str, float] = field(default_factory=dict)


def read_parameters(given: Sequence[str]) -> dict[str, float]:
    """Return ``{"kappa": 0.1}`` of ``["kappa=0.1"]``.

    Raises
    ------
    ConfigError
        If one is no name and number, or is given twice.
    """
    found = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals:
            msg = f"--parameter {legible(text)}: write it as name=value, such as kappa=0.1"
            raise ConfigError(msg)
        key = name.strip()
        if key in found:
            msg = f"--parameter {legible(key)}: is given twice; which one is meant?"
            raise ConfigError(msg)
        found[key] = read_quantity(f"--parameter {legible(key)}", value, "")
    return found


def run_orientation(study: OrientationStudy) -> dict[str, Any]:
    """Return the steady orientation of a suspension, as JSON has it.

    Parameters
    ----------
    study : OrientationStudy
        The suspension and the flow.

    Returns
    -------
    dict
        ``a`` (3x3), ``angle`` of the preferred direction in the plane of 1 and 2 [rad],
        ``eigenvalues`` descending, ``iterations`` of Newton (0 for the distribution, which is one
        linear solve), ``residual`` over the rate of deformation, ``physical`` (eigenvalues in
        [0, 1]) and ``stable`` (every small change dies away).

    Raises
    ------
    ConfigError
        If a name is unknown, or a parameter out of its range.
    ConvergenceError
        If the closure has no steady state there.
    """
    check_closure(study.closure)
    gradient = flow_gradient(study.flow)
    model = _model(study)
    if study.closure == DISTRIBUTION:
        return _distribution(study, model, gradient)
    found = steady_state(model, gradient, named(study.closure))
    return {
        "a": found.a.tolist(),
        "angle": found.angle,
        "eigenvalues": found.eigenvalues.tolist(),
        "iterations": found.iterations,
        "residual": found.residual,
        "physical": found.is_physical,
        "stable": found.is_stable,
    }


def check_closure(name: str) -> None:
    """Refuse what is neither a closure nor the distribution itself."""
    known = {**CLOSURES, DISTRIBUTION: None}
    if name not in known:
        raise ConfigError(nearest_name("closure", name, known))


def _model(study: OrientationStudy) -> OrientationModel:
    """Return the model that a study names, with all that it takes and nothing else."""
    kind = model_class(study.model)
    if study.aspect_ratio < 1.0:
        msg = f"fiber.aspect_ratio = {study.aspect_ratio:g}: must be at least 1 (length over width)"
        raise ConfigError(msg)
    names = [one.name for one in fields(kind)]
    if "convention" not in names:
        msg = (
            f"--model {study.model}: without interaction there is nothing to find: in shear fibers "
            "tumble on and on, in elongation all come to lie along it; take another model"
        )
        raise ConfigError(msg)
    if ("interaction" in names) != (study.interaction is not None):
        raise ConfigError(_one_too_many_or_few(study, names))
    if study.interaction is not None:
        checked_interaction(study.interaction)
    own = [one for one in fields(kind) if one.name not in SHAPE]
    known = [one.name for one in own]
    if unknown := [name for name in study.parameters if name not in known]:
        has = f"it takes {', '.join(known)}" if known else "it takes none"
        msg = f"--parameter {unknown[0]}: no parameter of the model {study.model}; {has}"
        raise ConfigError(msg)
    needed = [one.name for one in own if one.default is MISSING]
    if missing := [name for name in needed if name not in study.parameters]:
        wanted = " ".join(f"--parameter {name}=..." for name in missing)
        msg = f"--model {study.model}: takes {', '.join(known)} besides: add {wanted}"
        raise ConfigError(msg)
    return build_model(
        study.model, study.aspect_ratio, study.interaction, study.convention, study.parameters
    )


def _one_too_many_or_few(study: OrientationStudy, names: Sequence[str]) -> str:
    """Return what to say of a C_I that the model needs, or has not."""
    if "interaction" in names:
        return f"--model {study.model}: needs --interaction C_I, such as 0.0128"
    own = [name for name in names if name not in SHAPE]
    return (
        f"--interaction with --model {study.model}: the model has {', '.join(own)} in its place: "
        f"drop --interaction, and give --parameter {own[0]}=..."
    )


def _distribution(
    study: OrientationStudy, model: OrientationModel, gradient: NDArray[np.float64]
) -> dict[str, Any]:
    """Return the same from the distribution itself, which knows isotropic diffusion only."""
    if type(model) is not FolgarTucker:
        msg = (
            f"--closure {DISTRIBUTION} with --model {study.model}: the distribution is of "
            "isotropic diffusion: take --model folgar-tucker"
        )
        raise ConfigError(msg)
    found = steady_distribution(
        gradient, model.shape_factor, float(rotary_diffusivity(model, gradient))
    )
    a = found.second()
    return {
        "a": a.tolist(),
        "angle": float(angle_of(a)),
        "eigenvalues": np.linalg.eigvalsh(a)[::-1].tolist(),
        "iterations": 0,
        "residual": found.residual,
        "physical": True,
        "stable": True,
    }


def orientation_in_words(answer: Mapping[str, Any]) -> str:
    """Return what `run_orientation` found as a few lines for a person."""
    a = answer["a"]
    rows = ["  ".join(f"{value:9.6f}" for value in row) for row in a]
    notes = [
        note
        for holds, note in (
            (answer["physical"], "no fibers are oriented so: eigenvalues leave [0, 1]"),
            (answer["stable"], "not stable: not every small change dies away"),
        )
        if not holds
    ]
    return "\n".join(
        [
            f"orientation     {rows[0]}",
            *(f"                {row}" for row in rows[1:]),
            f"preferred       {_preferred(a, answer['angle'])}",
            "eigenvalues     " + "  ".join(f"{value:.6f}" for value in answer["eigenvalues"]),
            f"solved          {answer['iterations']} iterations, residual {answer['residual']:.1e}",
            *(f"note            {note}" for note in notes),
        ]
    )


ALIKE = 1e-9
"""Difference of the eigenvalues in the plane below which no direction is preferred: rounding."""


def _preferred(a: Sequence[Sequence[float]], angle: float) -> str:
    """Return the preferred direction in the plane of 1 and 2 in words."""
    if math.hypot(a[0][0] - a[1][1], 2.0 * a[0][1]) < ALIKE:
        return "none in the plane of 1 and 2"
    return f"{math.degrees(angle):.3f} deg from direction 1 ({angle:.5f} rad)"
