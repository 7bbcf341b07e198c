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
from fibermelt.units import ZERO_CELSIUS, celsius_meant, in_celsius
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
    T = card.temperature if temperature == FROM_CARD else temperature
    w = card.moisture if moisture == FROM_CARD else moisture
    if w is None:
        msg = f"{said}moisture: the card of {card.name} has none: give one, such as 0.1 %"
        raise ConfigError(msg)
    try:
        saturation = card.melt.saturation_content(T)
    except ConfigError as error:
        instead = '; or write "from-card"' if said == STUDY else ""
        msg = f"{said}{error}{_meant(card, T)}{instead}"
        raise ConfigError(msg) from error
    with _named(said, "moisture"):
        checked_moisture(w, saturation, np.asarray(T))
    return MoistMelt(card, w, T, math.log10(threshold_rate))


def _meant(card: Card, temperature: float) -> str:
    """Return how to write a temperature that the card allows in degrees Celsius; else nothing."""
    if temperature < ZERO_CELSIUS:
        return celsius_meant(temperature, "K")
    try:
        card.melt.saturation_content(temperature + ZERO_CELSIUS)
    except ConfigError:
        return ""
    return in_celsius(temperature)


@contextmanager
def _named(said: str, name: str) -> Iterator[None]:
    """Have every line of what is wrong with a value start with its key."""
    try:
        yield
    except ConfigError as error:
        lines = str(error).split("\n")
        msg = "\n".join(
            f"{said}{line}" if line.startswith(f"{name} =") else f"{said}{name}: {line}"
            for line in lines
        )
        raise ConfigError(msg) from error
