"""Models of orientation by their names, as a study and a command ask for them, and in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fibermelt.orientation.kinetics import OrientationModel

__all__ = ["build_model", "model_in_words"]

WRITTEN = {
    "folgar-tucker": "Folgar-Tucker",
    "rsc": "RSC",
    "ard-rsc": "ARD-RSC",
    "iard": "iARD",
    "pard": "pARD",
    "mrd": "MRD",
    "nematic": "the nematic model",
    "jeffery": "Jeffery",
}
"""How a model's name is written in a sentence."""


def build_model(
    name: str,
    aspect_ratio: float,
    interaction: float | None,
    convention: str,
    own: Mapping[str, float],
) -> OrientationModel:
    """Return a model of `fibermelt.orientation.models.MODELS` for a fiber.

    Parameters
    ----------
    name : str
        Its name.
    aspect_ratio : float
        ``r_e`` [-] of the fiber, whose shape factor is Jeffery's.
    interaction : float or None
        ``C_I`` [-], where the model has one.
    convention : str
        ``"standard"`` or ``"paper"``, where the model has one.
    own : mapping
        What it takes besides, by name.

    Raises
    ------
    ConfigError
        If there is no such model, or a parameter is out of its range.
    """
    from dataclasses import fields  # noqa: PLC0415  lazy: see stages

    from fibermelt.fiber.shape import jeffery_factor  # noqa: PLC0415
    from fibermelt.orientation.models import model_class  # noqa: PLC0415

    kind = model_class(name)
    names = {one.name for one in fields(kind)}
    shared: dict[str, Any] = {"interaction": interaction, "convention": convention}
    given = {key: value for key, value in shared.items() if key in names}
    return kind(jeffery_factor(aspect_ratio), **given, **own)


def model_in_words(name: str, interaction: float | None, own: Mapping[str, float]) -> str:
    """Return what a model is called, with its numbers: ``RSC (C_I = 0.0128, kappa = 0.1)``."""
    numbers = {} if interaction is None else {"C_I": f"{interaction:.4f}"}
    numbers |= {key: f"{value:g}" for key, value in own.items()}
    told = ", ".join(f"{key} = {value}" for key, value in numbers.items())
    return f"{WRITTEN[name]} ({told})" if told else WRITTEN[name]
