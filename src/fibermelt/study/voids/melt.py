"""The moist melt of a study: a material card at a moisture and a temperature, checked."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from fibermelt.errors import ConfigError
from fibermelt.study.materials import Card, load_card, material_names
from fibermelt.voids.checks import checked_moisture

__all__ = ["FROM_CARD", "MoistMelt", "moist_melt"]

FROM_CARD: Literal["from-card"] = "from-card"
"""Stands for the card's own moisture or temperature."""

STUDY = "voids."
"""How the keys of a study begin."""

_shipped = cache(load_card)


@dataclass(frozen=True)
class MoistMelt:
    """A melt with moisture in it, and the rate that counts as nucleation.

    Parameters
    ----------
    card : Card
        The material.
    moisture : float
        Over the mass of polymer [-], at most saturation.
    temperature : float
        Of the melt [K].
    log10_threshold : float
        log10 of the rate [1/(m3 s)] that counts as nucleation.
    """

    card: Card
    moisture: float
    temperature: float
    log10_threshold: float


def moist_melt(
    material: str,
    moisture: float | Literal["from-card"] = FROM_CARD,
    temperature: float | Literal["from-card"] = FROM_CARD,
    threshold_rate: float = 1.0,
    said: str = STUDY,
) -> MoistMelt:
    """Return the melt of a card at a moisture and a temperature.

    Parameters
    ----------
    material : str
        A shipped card, or the path of one.
    moisture : float or "from-card"
        Over the mass of polymer [-]; from the card: as received.
    temperature : float or "from-card"
        Of the melt [K]; from the card: that of printing.
    threshold_rate : float
        Rate that counts as nucleation [1/(m3 s)], > 0.
    said : str
        How the three are called in front of their names, for messages.

    Raises
    ------
    ConfigError
        If there is no such card, it cannot give a vapor pressure, or the moisture or the
        temperature is out of its range.
    """
    with _named(said, "material"):
        card = _shipped(material) if material in material_names() else load_card(material)
        if gap := card.melt.gaps.get("isotherm"):
            msg = f"{card.name}: {gap}"
            raise ConfigError(msg)
    instead = '; or write "from-card"' if said == STUDY else ""
    T = card.temperature if temperature == FROM_CARD else temperature
    w = card.moisture if moisture == FROM_CARD else moisture
    if w is None:
        msg = f"{said}moisture: the card of {card.name} has none: give one, such as 0.1 %"
        raise ConfigError(msg)
    with _named(said, "temperature", instead):
        saturation = card.melt.saturation_content(T)
    with _named(said, "moisture"):
        checked_moisture(w, saturation, np.asarray(T))
    return MoistMelt(card, w, T, math.log10(threshold_rate))


@contextmanager
def _named(said: str, name: str, way_out: str = "") -> Iterator[None]:
    """Have every line of what is wrong with a value start with its key."""
    try:
        yield
    except ConfigError as error:
        lines = str(error).split("\n")
        msg = "\n".join(
            f"{said}{line}" if line.startswith(f"{name} =") else f"{said}{name}: {line}"
            for line in lines
        )
        raise ConfigError(msg + way_out) from error
