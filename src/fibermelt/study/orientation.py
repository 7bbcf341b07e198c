"""A suspension in a homogeneous flow: what `fibermelt orientation` and `domain-size` answer.

What computes is imported when it is asked for, as in the stages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Any

from fibermelt.errors import ConfigError, legible
from fibermelt.study.orientation_stages import (
    DISTRIBUTION,
    folgar_tucker,
    interaction_coefficient,
    preferred_angle,
    rotary_diffusivity,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.orientation.kinetics import OrientationModel

__all__ = [
    "DomainStudy",
    "OrientationStudy",
    "domain_in_words",
    "orientation_in_words",
    "read_parameters",
    "run_domain_size",
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
    interaction : float
        ``C_I`` [-], positive.
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
    interaction: float
    aspect_ratio: float
    model: str = "folgar-tucker"
    flow: str = "simple-shear"
    convention: str = "standard"
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class DomainStudy:
    """A suspension whose content decides the size of the cell.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], above one.
    volume_fraction : float
        ``v_f`` [-], in (0, 1).
    closure, convention : str
        As in `OrientationStudy`.
    interaction : float, optional
        ``C_I`` [-]; from the law if not given.
    law : str
        One of `fibermelt.orientation.interaction.INTERACTION_LAWS`.
    """

    aspect_ratio: float
    volume_fraction: float
    closure: str = "ORE"
    convention: str = "standard"
    interaction: float | None = None
    law: str = "bay"


def read_parameters(given: Sequence[str]) -> dict[str, float]:
    """Return ``{"kappa": 0.1}`` of ``["kappa=0.1"]``.

    Raises
    ------
    ConfigError
        If one is no name and number.
    """
    from fibermelt.study.orbit import read_quantity  # noqa: PLC0415  lazy: see the module

    found = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals:
            msg = f"--parameter {legible(text)}: write it as name=value, such as kappa=0.1"
            raise ConfigError(msg)
        found[name.strip()] = read_quantity(f"--parameter {legible(name.strip())}", value, "")
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
        linear solve), ``residual`` over the rate of deformation, and ``stable``, None for the
        distribution.

    Raises
    ------
    ConfigError
        If a name is unknown, or a parameter out of its range.
    ConvergenceError
        If the closure has no steady state there.
    """
    from fibermelt.orientation.closures import closure as named  # noqa: PLC0415  lazy: see above
    from fibermelt.orientation.flows import flow_gradient  # noqa: PLC0415
    from fibermelt.orientation.steady import steady_state  # noqa: PLC0415

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


def _model(study: OrientationStudy) -> OrientationModel:
    """Return the model that a study names, with all that it takes and nothing else."""
    from fibermelt.fiber.shape import jeffery_factor  # noqa: PLC0415  lazy: see the module
    from fibermelt.orientation.models import model_class  # noqa: PLC0415

    kind = model_class(study.model)
    given: dict[str, Any] = {
        "shape_factor": jeffery_factor(study.aspect_ratio),
        "interaction": study.interaction,
        "convention": study.convention,
    }
    names = [one.name for one in fields(kind)]
    if "interaction" not in names:
        msg = (
            f"--model {study.model}: has not one C_I: take folgar-tucker or another, or use "
            "it in Python (fibermelt.orientation.models)"
        )
        raise ConfigError(msg)
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
    return kind(**given, **study.parameters)


def _distribution(
    study: OrientationStudy, model: OrientationModel, gradient: NDArray[np.float64]
) -> dict[str, Any]:
    """Return the same from the distribution itself, which knows isotropic diffusion only."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.orientation.fokker_planck import steady_distribution  # noqa: PLC0415
    from fibermelt.orientation.models import FolgarTucker  # noqa: PLC0415
    from fibermelt.orientation.tensors import preferred_angle as angle_of  # noqa: PLC0415

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
    warnings = [
        f"note            {line}"
        for holds, line in (
            (
                answer["physical"],
                "note            no fibers are oriented so: eigenvalues leave [0, 1]",
            ),
            (answer["stable"], "note            not stable: small changes grow"),
        )
        if not holds
    ]
    return "\n".join(
        [
            f"orientation     {rows[0]}",
            *(f"                {row}" for row in rows[1:]),
            f"preferred       {math.degrees(answer['angle']):.3f} deg from the flow "
            f"({answer['angle']:.5f} rad)",
            "eigenvalues     " + "  ".join(f"{value:.6f}" for value in answer["eigenvalues"]),
            f"solved          {answer['iterations']} iterations, residual {answer['residual']:.1e}",
            *warnings,
        ]
    )


def run_domain_size(study: DomainStudy) -> dict[str, Any]:
    """Return the cell that a fiber content stands for, as JSON has it.

    Parameters
    ----------
    study : DomainStudy
        The suspension.

    Returns
    -------
    dict
        ``interaction`` C_I, ``preferred_angle`` [rad], ``domain_size`` M, ``regime`` of
        concentration and ``largest_stalling_domain``.

    Raises
    ------
    ConfigError
        If a parameter is out of its range, or no cell stalls the fiber at the preferred angle.
    """
    from fibermelt.fiber.stall import stall_curve  # noqa: PLC0415  lazy: see the module
    from fibermelt.orientation.interaction import regime  # noqa: PLC0415

    concentration = regime(study.volume_fraction, study.aspect_ratio)
    interaction = interaction_coefficient(
        study.interaction, study.law, study.volume_fraction, study.aspect_ratio
    )
    model = folgar_tucker(study.aspect_ratio, interaction, study.convention)
    angle = preferred_angle(model, study.closure)
    curve = stall_curve(study.aspect_ratio)
    return {
        "interaction": interaction,
        "preferred_angle": angle,
        "domain_size": curve.domain_size_at(angle),
        "regime": concentration,
        "largest_stalling_domain": curve.largest_stalling_domain,
    }


def domain_in_words(answer: Mapping[str, Any]) -> str:
    """Return what `run_domain_size` found as a few lines for a person."""
    angle = math.degrees(answer["preferred_angle"])
    return "\n".join(
        [
            f"interaction     C_I = {answer['interaction']:.5f} ({answer['regime']} suspension)",
            f"preferred       {angle:.3f} deg from the flow in simple shear",
            f"domain size     M = {answer['domain_size']:.4f}: a fiber in that cell stalls there",
            f"stalls          in cells up to M = {answer['largest_stalling_domain']:.4f}",
        ]
    )
