"""Material cards: what is known of a melt, with the source of every value.

A card is a TOML file. Each value is a table of its own that says where it comes from::

    [surface]
    tension = { value = "38.5 mN/m", source = "..." }                 # read in a source
    slope = { value = "-0.07 mN/(m K)", estimate = "most polymers" }  # or estimated, and on what

A key that is left out is a hole: the card says which results it cannot give. A card that begins
with ``like = "paper"`` has all values of that one but those that it says itself; with a law of
viscosity of its own it has nothing of that one's.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from fibermelt.declared import BOUNDS
from fibermelt.engine.parameters import (
    Declaration,
    declarations,
    excerpt,
    flatten,
)
from fibermelt.engine.syntax import parse_toml, read_toml
from fibermelt.errors import ConfigError, legible
from fibermelt.parts.melt.values import (
    CardValues,
    DiffusionValues,
    IsothermValues,
    SurfaceValues,
    ViscosityValues,
)
from fibermelt.units import celsius_meant
from fibermelt.voids.diffusion import Arrhenius
from fibermelt.voids.melt import VolatileMelt
from fibermelt.voids.surface_tension import LinearTension
from fibermelt.voids.vapor import ActivityLaw, Isotherm

__all__ = ["Card", "Provenance", "card_of", "load_card", "material_names"]

_LONGEST_PATH = 200
_RANGE_FAULTS = dict(
    zip(("greater_than", "greater_than_equal", "less_than", "less_than_equal"), BOUNDS, strict=True)
)
"""What pydantic calls a broken bound, in the order of `BOUNDS`."""

RENAMED = {"abs-cf13": "paper"}
"""Cards by a name that they had."""

_NEEDED = ("melt.density", "melt.temperature", "melt.coldest", "melt.hottest")
"""Keys that no card can do without."""


@dataclass(frozen=True)
class Provenance:
    """Where a value comes from.

    Parameters
    ----------
    written : str or float
        The value as the card has it, with its unit.
    text : str
        The source, or what an estimate is based on.
    is_estimate : bool
        Whether nobody measured it for this material at this temperature.
    """

    written: str | float
    text: str
    is_estimate: bool


@dataclass(frozen=True)
class Card:
    """A material card, read and checked.

    Parameters
    ----------
    key : str
        By what it was asked for: ``"paper"`` or a path.
    name : str
        What the material is called.
    melt : VolatileMelt
        Its laws, in SI; what is missing in it is in ``melt.gaps``.
    temperature : float
        Temperature of printing [K].
    moisture : float or None
        As received [-]; None where the card does not say.
    provenance : mapping
        Where each value comes from, by its key: ``{"surface.tension": ...}``.
    viscosity : ViscosityValues
        The law of viscosity, in SI; None for what the card does not say.
    text : str
        All that the card says, as `card_of` reads it again.
    """

    key: str
    name: str
    melt: VolatileMelt
    temperature: float
    moisture: float | None
    provenance: Mapping[str, Provenance]
    viscosity: ViscosityValues = field(default_factory=ViscosityValues)
    text: str = ""

    @property
    def estimates(self) -> list[str]:
        """Return the keys of the values that are estimates."""
        return [key for key, where in self.provenance.items() if where.is_estimate]


def material_names() -> list[str]:
    """Return the names of the cards that ship with the package."""
    shipped = files("fibermelt").joinpath("data", "materials").iterdir()
    return sorted(e.name.removesuffix(".toml") for e in shipped if e.name.endswith(".toml"))


def load_card(material: str) -> Card:
    """Return a material card.

    Parameters
    ----------
    material : str
        The name of a shipped card, such as ``"paper"``, or the path of a TOML file, from the
        working directory.

    Raises
    ------
    ConfigError
        If there is no such card, it is not TOML, or a value is wrong or has no source; one line
        for each fault, that names the key, the value, the bound and the way out.
    """
    material = RENAMED.get(material, material)
    return _card(material, _whole(material, ()))


def card_of(key: str, text: str) -> Card:
    """Return the card that was asked for by ``key``, of what its ``text`` says."""
    return _card(key, json.loads(text))


def _whole(material: str, above: tuple[str, ...]) -> dict[str, Any]:
    """Return the tables of a card, those that it has from another included."""
    tables = _read(material)
    like = tables.pop("like", None)
    if like is None:
        return tables
    shown = legible(material, _LONGEST_PATH)
    if not isinstance(like, str) or like in (*above, material):
        msg = f'{shown}: like = {excerpt(like)}: must name another card, such as like = "paper"'
        raise ConfigError(msg)
    whole = _whole(RENAMED.get(like, like), (*above, material))
    for name, table in tables.items():
        is_law = name == "viscosity" and isinstance(table, Mapping) and "law" in table
        both = isinstance(table, Mapping) and isinstance(whole.get(name), Mapping)
        whole[name] = {**whole[name], **table} if both and not is_law else table
    return whole


def _card(material: str, tables: Mapping[str, Any]) -> Card:
    """Return the card of what a file says, checked."""
    tables = dict(tables)
    name = tables.pop("name", None)
    shown = legible(material, _LONGEST_PATH)
    if not isinstance(name, str) or not name:
        msg = f'{shown}: name: missing; write what the material is called, name = "PLA"'
        raise ConfigError(msg)
    values, provenance = _split(tables, shown)
    try:
        card = CardValues.model_validate(values)
    except ValidationError as error:
        raise ConfigError(_explain(error, values, shown)) from None
    lacking = [key for key in _NEEDED if key not in provenance]
    if lacking:
        msg = f"{shown}: {', '.join(lacking)}: missing; no card can do without"
        raise ConfigError(msg)
    melt = card.melt
    if not melt.coldest <= melt.temperature <= melt.hottest:
        written = provenance["melt.temperature"].written
        msg = (
            f"{shown}: melt.temperature = {written}: must lie between melt.coldest, "
            f"{provenance['melt.coldest'].written}, and melt.hottest, "
            f"{provenance['melt.hottest'].written}"
        )
        raise ConfigError(msg)
    if fault := card.viscosity.fault():
        msg = f"{shown}: {fault}"
        raise ConfigError(msg)
    return Card(
        key=material,
        name=name,
        melt=_melt(name, card),
        temperature=melt.temperature,
        moisture=melt.moisture,
        provenance=provenance,
        viscosity=card.viscosity,
        text=json.dumps({"name": name, **tables}),
    )


def _read(material: str) -> dict[str, Any]:
    """Return the tables of a shipped card, or of a file."""
    shipped = material_names()
    if material in shipped:
        file = files("fibermelt").joinpath("data", "materials", f"{material}.toml")
        return parse_toml(file.read_text(encoding="utf-8"), material)
    path = Path(material)
    try:
        is_there = path.exists()
    except OSError:
        is_there = True  # Who reads it says what the system has against it.
    if not is_there:
        nearest = get_close_matches(material, shipped, n=1)
        guess = f"; did you mean {nearest[0]}?" if nearest else ""
        msg = (
            f'no material is called "{legible(material, _LONGEST_PATH)}"{guess} '
            f"(shipped: {', '.join(shipped)}; or a path to a TOML file)"
        )
        raise ConfigError(msg)
    return read_toml(path)


def _split(
    tables: Mapping[str, Any], where: str
) -> tuple[dict[str, dict[str, Any]], dict[str, Provenance]]:
    """Return the bare values of a card, and where each comes from."""
    values: dict[str, dict[str, Any]] = {}
    provenance: dict[str, Provenance] = {}
    for section, table in tables.items():
        if not isinstance(table, Mapping):
            msg = f"{where}: {legible(section)}: must be a table of values: write [{section}]"
            raise ConfigError(msg)
        values[section] = {}
        for name, entry in table.items():
            key = f"{section}.{name}"
            origin = set(entry) - {"value"} if isinstance(entry, Mapping) else set()
            kind = next(iter(origin), "")
            if origin not in ({"source"}, {"estimate"}) or "value" not in entry or not entry[kind]:
                msg = (
                    f'{where}: {legible(key)}: must say where it is from: {{ value = "...", '
                    'source = "..." }, or estimate = "on what basis" in place of source'
                )
                raise ConfigError(msg)
            values[section][name] = entry["value"]
            provenance[key] = Provenance(entry["value"], str(entry[kind]), kind == "estimate")
    return values, provenance


def _explain(error: ValidationError, values: Mapping[str, Any], where: str) -> str:
    """Return one line for each fault of a card."""
    known = {declaration.key: declaration for declaration in declarations(CardValues)}
    return "\n".join(f"{where}: {_line(fault, values, known)}" for fault in error.errors())


def _line(fault: ErrorDetails, values: Mapping[str, Any], known: Mapping[str, Declaration]) -> str:
    """Return what is wrong with one value, its bound and how to write it."""
    kind = fault["type"]
    location = [str(part) for part in fault["loc"]]
    key = ".".join(location)
    if kind == "extra_forbidden":
        sections = {name.partition(".")[0] for name in known}
        nearest = get_close_matches(key, [*known, *sections], n=1)
        guess = f"; did you mean {nearest[0]}?" if nearest else f"; known: {', '.join(known)}"
        return f"{legible(key)}: unknown key{guess}"
    declaration = known[key]
    written = f"{key} = {excerpt(values[location[0]][location[1]])}"
    if kind in _RANGE_FAULTS:
        name = _RANGE_FAULTS[kind]
        bound = f"{dict(declaration.bounds)[name]:g} {declaration.unit}".rstrip()
        meant = celsius_meant(fault["input"], declaration.unit)
        return f"{written}: must be {BOUNDS[name]} {bound}{meant}"
    if kind == "literal_error":
        return f"{written}: must be {declaration.range}"
    reason = fault["ctx"]["error"] if kind == "value_error" else "is no quantity"
    return f'{written}: {reason}; write it as "{declaration.example}"'


def _melt(name: str, card: CardValues) -> VolatileMelt:
    """Return the laws of a card; one whose values are not all there is None."""
    span = (card.melt.coldest, card.melt.hottest)
    missing = {
        law: gaps
        for law, section in (
            ("isotherm", card.isotherm),
            ("diffusion", card.diffusion),
            ("surface", card.surface),
            ("contact_angle", card.wetting),
        )
        if (gaps := _holes(section, law))
    }
    return VolatileMelt(
        name=name,
        density=card.melt.density,
        polymer_fraction=card.melt.polymer_fraction,
        temperatures=span,
        isotherm=_isotherm(card.isotherm, span),
        diffusion=_diffusion(card.diffusion, span),
        surface=_surface(card.surface, span),
        contact_angle=card.wetting.contact_angle,
        missing=missing,
    )


def _holes(section: BaseModel, law: str) -> tuple[str, ...]:
    prefix = "wetting." if law == "contact_angle" else f"{law}."
    return tuple(key for key, value in flatten(section, prefix).items() if value is None)


def _isotherm(values: IsothermValues, span: tuple[float, float]) -> Isotherm | None:
    content, reference = values.content, values.reference_temperature
    if content is None or reference is None or values.mixing_heat is None:
        return None
    return ActivityLaw(content, reference, values.mixing_heat, span)


def _diffusion(values: DiffusionValues, span: tuple[float, float]) -> Arrhenius | None:
    if values.prefactor is None or values.activation_energy is None:
        return None
    return Arrhenius.of_energy(values.prefactor, values.activation_energy, span)


def _surface(values: SurfaceValues, span: tuple[float, float]) -> LinearTension | None:
    tension, reference = values.tension, values.reference_temperature
    if tension is None or reference is None or values.slope is None:
        return None
    return LinearTension(tension, reference, values.slope, span)
