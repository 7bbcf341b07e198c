"""The moist melt of a study: a material card at a moisture and a temperature, checked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from fibermelt.errors import ConfigError
from fibermelt.parts.melt.cards import Card
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.voids.config import Voids
from fibermelt.units import ZERO_CELSIUS, celsius_meant, in_celsius
from fibermelt.voids.checks import checked_moisture

if TYPE_CHECKING:
    from fibermelt.engine.tables import Tables

__all__ = ["FROM_CARD", "MoistMelt", "moist_melt", "refuse_moisture"]

FROM_CARD: Literal["from-card"] = "from-card"
"""Stands for the card's own moisture."""

STUDY = {
    "material": "melt.material",
    "moisture": "voids.moisture",
    "temperature": "melt.temperature",
}
"""What they are called in a study."""


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
    card: Card,
    moisture: float | Literal["from-card"] = FROM_CARD,
    temperature: float | None = None,
    threshold_rate: float = 1.0,
    *,
    density: float | None = None,
    keys: Mapping[str, str] = STUDY,
) -> MoistMelt:
    """Return the melt of a card at a moisture and a temperature.

    Parameters
    ----------
    card : Card
        What is known of the material.
    moisture : float or "from-card"
        Over the mass of polymer [-]; from the card: as received.
    temperature : float, optional
        Of the melt [K]; from the card if not given: that of printing.
    threshold_rate : float
        Rate that counts as nucleation [1/(m3 s)], > 0.
    density : float, optional
        Of the melt with its fibers [kg/m3]; the card's if not given.
    keys : mapping
        What the material, the moisture and the temperature are called, for messages.

    Raises
    ------
    ConfigError
        If the card cannot give a vapor pressure, or the moisture or the temperature is out of its
        range.
    """
    if gap := card.melt.gaps.get("isotherm"):
        msg = f"{keys['material']}: {card.name}: {gap}"
        raise ConfigError(msg)
    T = card.temperature if temperature is None else temperature
    w = card.moisture if moisture == FROM_CARD else moisture
    if w is None:
        msg = f"{keys['moisture']}: the card of {card.name} has none: give one, such as 0.1 %"
        raise ConfigError(msg)
    try:
        saturation = card.melt.saturation_content(T)
    except ConfigError as error:
        told = str(error).removeprefix("temperature")
        msg = f"{keys['temperature']}{told}{_meant(card, T)}"
        raise ConfigError(msg) from error
    try:
        checked_moisture(w, saturation, np.asarray(T))
    except ConfigError as error:
        msg = f"{keys['moisture']}{str(error).removeprefix('moisture')}"
        raise ConfigError(msg) from error
    melt = card.melt if density is None else replace(card.melt, density=density)
    return MoistMelt(replace(card, melt=melt), w, T, math.log10(threshold_rate))


def _meant(card: Card, temperature: float) -> str:
    """Return how to write a temperature that the card allows in degrees Celsius; else nothing."""
    if temperature < ZERO_CELSIUS:
        return celsius_meant(temperature, "K")
    low, high = card.melt.temperatures
    return in_celsius(temperature) if low <= temperature + ZERO_CELSIUS <= high else ""


def refuse_moisture(study: Tables) -> None:
    """Refuse a moisture that the card does not know, or does not allow.

    Raises
    ------
    ConfigError
        The key, the value, the bound and the way out.
    """
    if "voids" in study.study.parts:
        melt = study.table(Melt)
        moist_melt(melt.card, study.table(Voids).moisture, melt.temperature)
