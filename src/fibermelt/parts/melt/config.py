"""The table ``[melt]``: a material card, and what a study says otherwise.

What a study leaves out is filled in from the card as it is read, so that a resolved study says its
law and all constants itself, and needs the card only for moisture.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Self, cast

from pydantic import PrivateAttr, model_validator

from fibermelt.engine.parameters import Section, excerpt, quantity, setting
from fibermelt.errors import ConfigError
from fibermelt.melt import LAWS
from fibermelt.parts.melt.cards import RENAMED, Card, load_card, material_names
from fibermelt.parts.melt.values import CONSTANTS, OPTIONAL, Constants, LawName
from fibermelt.parts.sources import PAPER_2
from fibermelt.units import ZERO_CELSIUS, celsius_meant, in_celsius, parse

__all__ = ["Melt", "melted"]

SHAPES = ("index", "transition")
"""Constants that are the same at every temperature."""

_shipped = cache(load_card)


class Named(Section):
    """Which melt it is."""

    material: str = setting(
        "paper",
        "Material card: the path of a TOML file, from the working directory, or a shipped one: "
        f"{', '.join(material_names())}. What is not said below is the card's.",
        source=PAPER_2,
    )
    law: LawName | None = setting(
        None,
        "Law of viscosity. Another law than the card's takes none of its constants.",
        example="newtonian",
    )
    temperature: float | None = quantity(
        None,
        "K",
        "Temperature of the melt, the same everywhere; the card's is that of printing.",
        ge=273.16,
        le=647.096,
        example="230 degC",
        hints={"ge": "water's triple point", "le": "water's critical point"},
    )
    law_temperature: float | None = quantity(
        None,
        "K",
        "Temperature at which the constants of the law hold: the card's, or where a study says "
        "them, that of the melt; cross-wlf needs none.",
        ge=200,
        le=1000,
        example="230 degC",
    )


class Melt(Constants, Named):
    """The polymer melt: one card, and what is known otherwise."""

    density: float | None = quantity(
        None,
        "kg/m^3",
        "Density of the melt with its fibers.",
        gt=0,
        le=1e5,
        example="1.15 g/cm^3",
    )

    _card: Card = PrivateAttr()

    @property
    def card(self) -> Card:
        """Return the card, as it was when the study was read."""
        return self._card

    @property
    def kelvin(self) -> float:
        """Return the temperature [K], which a study that was read has from its card at least."""
        return cast("float", self.temperature)

    @property
    def missing(self) -> tuple[str, ...]:
        """Return the keys that the law lacks."""
        if self.law is None:
            return ("melt.law",)
        lacking = [name for name in CONSTANTS[self.law] if getattr(self, name) is None]
        return tuple(f"melt.{name}" for name in lacking)

    @model_validator(mode="before")
    @classmethod
    def _filled(cls, data: Any) -> Any:
        """Fill in from the card what the study does not say."""
        if not isinstance(data, Mapping):
            return data
        said = {name: value for name, value in data.items() if value is not None}
        material = said.get("material", cls.model_fields["material"].default)
        if not isinstance(material, str) or said.get("law") not in (None, *LAWS):
            return data
        card = _card(material)
        said["material"] = card.key
        # What is no quantity is for the fields to refuse.
        try:
            return _merged(said, card)
        except ConfigError:
            return said

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        """Refuse constants of another law, and what the card does not allow."""
        self._card = _card(self.material)
        for name in Constants.model_fields:
            value = getattr(self, name)
            if value is None or name == "activation_temperature" or self.law is None:
                continue
            if name not in CONSTANTS[self.law]:
                laws = " or ".join(f'"{law}"' for law, names in CONSTANTS.items() if name in names)
                msg = (
                    f'melt.{name} = {value:g}: is no constant of melt.law = "{self.law}", which '
                    f"has {', '.join(CONSTANTS[self.law])}: leave it away, or say melt.law = {laws}"
                )
                raise ValueError(msg)
        self._temperature()
        return self

    def _temperature(self) -> None:
        """Refuse a temperature that the card does not know."""
        T, (low, high) = self.temperature, self._card.melt.temperatures
        if T is None or low <= T <= high:
            return
        meant = celsius_meant(T, "K")
        if low <= T + ZERO_CELSIUS <= high:
            meant = in_celsius(T)
        msg = (
            f"melt.temperature = {T:g} K: must be from {low:g} to {high:g} K, the range of the "
            f'card melt.material = "{self.material}": take another card{meant}'
        )
        raise ValueError(msg)


def _card(material: str) -> Card:
    """Return a card; every line of what is wrong with it starts with its key."""
    try:
        is_shipped = RENAMED.get(material, material) in material_names()
        return _shipped(material) if is_shipped else load_card(material)
    except ConfigError as error:
        lines = str(error).split("\n")
        raise ValueError("\n".join(f"melt.material: {line}" for line in lines)) from None


def _merged(said: dict[str, Any], card: Card) -> dict[str, Any]:
    """Return what a study says, and what it does not from the card.

    What a study says of a law holds at its own temperature, what the card says at the card's:
    where both are in one law, only the shapes may be the study's.
    """
    known = card.viscosity
    melt = {
        "law": known.law,
        "temperature": card.temperature,
        "density": card.melt.density,
        "activation_temperature": known.activation_temperature or 0.0,
    } | said
    law = melt["law"]
    if law is None:
        return melt
    names = CONSTANTS[law]
    told = [name for name in names if name in said]
    lent = [
        name
        for name in names
        if name not in said and law == known.law and getattr(known, name) is not None
    ]
    melt |= {name: getattr(known, name) for name in lent}
    melt |= {name: value for name, value in OPTIONAL.items() if name in names and name not in melt}
    if law == "cross-wlf" or "law_temperature" in said:
        return melt
    own = [name for name in told if name not in SHAPES]
    temperature, at = parse(melt["temperature"], "K"), known.temperature
    mixed = [name for name in lent if name not in SHAPES and getattr(known, name) != 0.0]
    if own and mixed and at != temperature:
        msg = (
            f"melt.law_temperature: missing: at which temperature does melt.{own[0]} = "
            f"{excerpt(melt[own[0]])} hold? melt.{mixed[0]} is the card's, at {at:g} K, and "
            f"melt.temperature = {temperature:g} K: say it, or all constants of the law"
        )
        raise ValueError(msg)
    return melt | {"law_temperature": at if lent and not own else temperature}


def melted(below: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is left of a table ``[melt]`` under one that names another card or law.

    Parameters
    ----------
    below, over : mapping
        Two tables ``[melt]`` as written. What is said of one melt, or of one law, is not true of
        another.
    """
    if "material" in over and over["material"] != below.get("material", "paper"):
        return {}
    law = over.get("law", below.get("law"))
    if law == below.get("law") or law not in CONSTANTS:
        return dict(below)
    gone = {*Constants.model_fields, "law_temperature"} - {"activation_temperature"}
    return {name: value for name, value in below.items() if name not in gone}
