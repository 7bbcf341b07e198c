"""The cell that stands for a fiber content: what `fibermelt domain-size` answers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fibermelt.errors import ConfigError
from fibermelt.fiber.stall import stall_curve
from fibermelt.orientation.interaction import checked_interaction, interaction_law, regime
from fibermelt.parts.interaction.suspension import (
    folgar_tucker,
    interaction_coefficient,
    preferred_angle,
)
from fibermelt.questions.orientation import check_closure

PAPER_LAW = "bay"
"""The law of the paper's section 2.5."""

__all__ = ["DomainStudy", "domain_in_words", "run_domain_size"]


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
        As in `fibermelt.questions.orientation.OrientationStudy`.
    interaction : float, optional
        ``C_I`` [-]; from the law if not given.
    law : str, optional
        One of `fibermelt.orientation.interaction.INTERACTION_LAWS`; the paper's, ``"bay"``, if
        neither it nor the coefficient is given. Not both.
    """

    aspect_ratio: float
    volume_fraction: float
    closure: str = "ORE"
    convention: str = "standard"
    interaction: float | None = None
    law: str | None = None


def run_domain_size(study: DomainStudy) -> dict[str, Any]:
    """Return the cell that a fiber content stands for, as JSON has it.

    Parameters
    ----------
    study : DomainStudy
        The suspension.

    Returns
    -------
    dict
        ``convention``, ``interaction`` C_I, ``preferred_angle`` [rad], ``domain_size`` M,
        ``regime`` of concentration, ``largest_stalling_domain``, and ``extrapolates``: whether the
        law was asked beyond the regimes that it is meant for.

    Raises
    ------
    ConfigError
        If a parameter is out of its range, or no cell stalls the fiber at the preferred angle.
    """
    check_closure(study.closure)
    content = study.volume_fraction, study.aspect_ratio
    concentration, law = regime(*content), interaction_law(study.law or PAPER_LAW)
    if study.interaction is not None:
        if study.law is not None:
            msg = (
                f"interaction = {study.interaction:g} with law = {law.name}: the law is for who "
                "has no coefficient: give one of the two"
            )
            raise ConfigError(msg)
        checked_interaction(study.interaction)
    interaction = interaction_coefficient(study.interaction, law.name, *content)
    model = folgar_tucker(study.aspect_ratio, interaction, study.convention)
    angle = preferred_angle(model, study.closure)
    curve = stall_curve(study.aspect_ratio)
    return {
        "convention": study.convention,
        "interaction": interaction,
        "preferred_angle": angle,
        "domain_size": curve.domain_size_at(angle),
        "regime": concentration,
        "largest_stalling_domain": curve.largest_stalling_domain,
        "extrapolates": study.interaction is None and law.extrapolates(*content),
    }


CONVENTIONS = {
    "standard": [
        "convention      standard: rate of deformation sqrt(2 D:D); the paper's results, and the",
        "                report of its study, go with --convention paper, sqrt(2) times that",
    ],
    "paper": ["convention      the paper's: sqrt(2) times the rate of deformation sqrt(2 D:D)"],
}
"""What an answer stands for: both conventions are in use, and their answers differ."""


def domain_in_words(answer: Mapping[str, Any]) -> str:
    """Return what `run_domain_size` found as a few lines for a person."""
    angle = math.degrees(answer["preferred_angle"])
    note = "note            the law is not meant for that regime: it extrapolates"
    return "\n".join(
        [
            f"interaction     C_I = {answer['interaction']:.5f} ({answer['regime']} suspension)",
            *CONVENTIONS[answer["convention"]],
            f"preferred       {angle:.3f} deg from the flow in simple shear",
            f"domain size     M = {answer['domain_size']:.4f}: a fiber in that cell stalls there",
            f"stalls          in cells up to M = {answer['largest_stalling_domain']:.4f}",
            *([note] if answer["extrapolates"] else []),
        ]
    )
