"""The melt of a study: its law at its temperature, for stages and for words.

Stages read the law's constants, not the card that they come from: a card with other words and the
same constants changes no result, and one with other constants is computed anew.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

from fibermelt.engine.parameters import declarations
from fibermelt.errors import ConfigError
from fibermelt.melt import LAWS, CrossWLF
from fibermelt.melt.melt import Melt
from fibermelt.melt.temperature import ArrheniusShift
from fibermelt.parts.flow.config import Flow
from fibermelt.parts.melt.config import Melt as MeltTable
from fibermelt.parts.melt.values import CONSTANTS, Constants
from fibermelt.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value
    from fibermelt.engine.stages import Parameters
    from fibermelt.engine.tables import Tables
    from fibermelt.fiber.pressure import LocalViscosity
    from fibermelt.melt import ViscosityLaw

__all__ = [
    "CARD",
    "LAW",
    "NEWTONIAN",
    "SAME_TEMPERATURE",
    "derived_of",
    "law_of",
    "melt_notes",
    "melt_of",
    "newtonian_viscosity",
    "refuse_incomplete",
    "refuse_unphysical",
    "thins",
    "thins_at_fibers",
    "viscosity_of",
]

LAW = "law"
"""The table that stages declare for the law of viscosity: its name and its constants, in SI."""

CARD = "card"
"""The table that they declare for the material card of ``[melt]``: its key and its text."""

NEWTONIAN = "newtonian"
"""The name of the law that does not thin."""

LARGEST_REYNOLDS = 0.01
"""Reynolds number up to which a flow creeps: inertia then changes stresses by about as much."""

SAME_TEMPERATURE = 1e-9
"""Part by which temperatures may differ and be one: 446 degF is 230 degC but for a rounding."""


def derived_of(study: Tables) -> dict[str, Value]:
    """Return what follows from ``[melt]``: ``{"law.name": "newtonian", ..., "card.key": ...}``.

    Of ``law``, the law at the melt's temperature, the constants of others are None; ``card`` is
    what the card says.
    """
    melt = study.table(MeltTable)
    law, card = _at_temperature(melt), melt.card
    return {
        **{f"{LAW}.{name}": law.get(name) for name in ("name", *Constants.model_fields)},
        f"{CARD}.key": card.key,
        f"{CARD}.text": card.text,
    }


def law_of(values: Mapping[str, Any]) -> ViscosityLaw:
    """Return the law of viscosity at the melt's temperature.

    Parameters
    ----------
    values : mapping
        What stages can read, `LAW` among it: of a whole study, or of one stage.
    """
    said = {name: values.get(f"{LAW}.{name}") for name in Constants.model_fields}
    constants = {name: value for name, value in said.items() if value is not None}
    return LAWS[values[f"{LAW}.name"]](**constants)


def thins(values: Mapping[str, Any]) -> bool:
    """Return whether the viscosity of a study's melt depends on the rate.

    Parameters
    ----------
    values : mapping
        As for `law_of`.
    """
    name = values[f"{LAW}.name"]
    return name not in ("", NEWTONIAN) and not law_of(values).is_newtonian


def thins_at_fibers(values: Mapping[str, Any]) -> bool:
    """Return whether fibers disturb a melt that thins, and are not told to see it as Newtonian."""
    return values["fiber.melt"] == "law" and thins(values)


def viscosity_of(parameters: Parameters) -> float | ViscosityLaw | LocalViscosity:
    """Return what pressures on fibers are taken from: ``mu`` [Pa s], the law, or its local value.

    The law itself goes with a fiber's table of it; `fibermelt.fiber` refuses it without one.
    """
    law = law_of(parameters)
    if law.is_newtonian:
        return float(law.viscosity_at(1.0))
    if parameters["fiber.melt"] == "law":
        return law
    from fibermelt.fiber.pressure import LocalViscosity  # noqa: PLC0415  the fibers, a second

    return LocalViscosity(law)


def newtonian_viscosity(parameters: Parameters) -> float:
    """Return the viscosity [Pa s] of a Newtonian melt, for what knows no other.

    Raises
    ------
    ConfigError
        If the melt is not Newtonian: a study that was read has been refused before.
    """
    law = law_of(parameters)
    if not law.is_newtonian:
        msg = f'melt.law = "{parameters[f"{LAW}.name"]}": must be "newtonian" here'
        raise ConfigError(msg)
    return float(law.viscosity_at(1.0))


def melt_of(table: MeltTable) -> Melt:
    """Return the melt of a table ``[melt]`` at its temperature.

    Raises
    ------
    ConfigError
        If it has no law of viscosity, or a constant is missing or out of its range.
    """
    card = table.card
    refuse_incomplete(table)
    law = _at_temperature(table)
    known = card.viscosity
    is_cards = table.law == known.law and all(
        getattr(known, name) in (None, getattr(table, name)) for name in CONSTANTS[str(table.law)]
    )
    where = [origin.text for key, origin in card.provenance.items() if key.startswith("viscosity.")]
    has_rates = is_cards and known.slowest is not None and known.fastest is not None
    return Melt(
        name=card.name,
        law=LAWS[str(law.pop("name"))](**law),
        temperature=table.kelvin,
        measured_at=_held_at(table),
        rates=(known.slowest, known.fastest) if has_rates else None,  # type: ignore[arg-type]
        temperatures=card.melt.temperatures,
        density=cast("float", table.density),
        sources=tuple(dict.fromkeys(where)) if is_cards else ("the study",),
    )


def melt_notes(study: Tables) -> list[str]:
    """Return what a person has to know of the melt, a sentence each."""
    table = study.table(MeltTable)
    if table.missing:
        return []
    notes = [*_inertia(study), *_local_viscosity(study)]
    if (at := _held_at(table)) is None:
        return notes
    return [
        *notes,
        f"the viscosity is that of {at - ZERO_CELSIUS:g} degC, the melt's temperature "
        f"{table.kelvin - ZERO_CELSIUS:g} degC: nothing tells how it follows the temperature; "
        "give melt.activation_temperature, or the constants at that temperature",
    ]


def _local_viscosity(study: Tables) -> list[str]:
    """Tell that fibers in a melt that thins are taken for those in a Newtonian one."""
    values = study.values()
    if values["fiber.melt"] == "law" or not thins(values):
        return []
    return [
        'fiber.melt = "local-viscosity": fibers are those of a Newtonian melt that has the '
        "viscosity of the flow around them; by the melt's own law, which their disturbance thins "
        "too, they see less of a pressure: 0.71 of it at an index of 0.7, 0.45 at 0.35 (an ellipse "
        "of aspect ratio 6, M = 4)"
    ]


def _inertia(study: Tables) -> list[str]:
    """Tell a Reynolds number ``rho V W / eta`` of the capillary at which inertia counts."""
    flow, melt = study.table(Flow), study.table(MeltTable)
    density = melt.density
    if density is None:
        return []
    width, flux = flow.capillary_width, flow.inlet_speed * flow.inlet_width
    viscosity = float(melt_of(melt).law.viscosity_at(6 * flux / width**2))
    reynolds = density * flux / viscosity
    if reynolds <= LARGEST_REYNOLDS:
        return []
    return [
        f"the Reynolds number of the capillary is {reynolds:.2g}, that of a creeping flow below "
        f"{LARGEST_REYNOLDS:g}: inertia, which is left out here, changes what comes out; is "
        f"the viscosity of {viscosity:.3g} Pa s meant?"
    ]


def refuse_incomplete(table: MeltTable) -> None:
    """Refuse a melt without a law of viscosity, or a law without its constants.

    Raises
    ------
    ConfigError
        The keys that are missing, and the way out.
    """
    if not table.missing:
        return
    card = f'the card melt.material = "{table.material}"'
    if table.law is None:
        msg = (
            f"melt.law: missing: {card} knows no viscosity; say melt.law and its constants, such "
            'as melt.law = "newtonian" and melt.viscosity, or take another card'
        )
    else:
        msg = (
            f'{", ".join(table.missing)}: missing: melt.law = "{table.law}" cannot do without, and '
            f"{card} has none of it; say it, or take another law or card"
        )
    raise ConfigError(msg)


def refuse_unphysical(table: MeltTable, fastest: float) -> None:
    """Refuse a law whose viscosity leaves all bounds somewhere in a flow.

    Parameters
    ----------
    table : Melt
        The table ``[melt]``, complete.
    fastest : float
        Highest rate of deformation that the flow's mesh resolves [1/s].

    Raises
    ------
    ConfigError
        If a constant is out of its range, or the viscosity is: the rate and the bound.
    """
    constants = _at_temperature(table)
    bounds = {item.key: dict(item.bounds) for item in declarations(type(table))}["viscosity"]
    law = LAWS[str(constants.pop("name"))](**constants)
    for rate in (0.0, fastest):
        viscosity = float(law.viscosity_at(rate))
        if not bounds["ge"] <= viscosity <= bounds["le"]:
            at = f"{rate:g} 1/s" if rate else "rest"
            said = ", ".join(
                f"melt.{name} = {getattr(table, name):g}" for name in CONSTANTS[str(table.law)]
            )
            msg = (
                f'melt.law = "{table.law}": its viscosity at {at} is {viscosity:g} Pa s, must be '
                f"from {bounds['ge']:g} to {bounds['le']:g} Pa s in all of the flow, up to "
                f"{fastest:.3g} 1/s ({said}; melt.temperature = {table.temperature:g} K): correct "
                "one of these"
            )
            raise ConfigError(msg)


def _held_at(table: MeltTable) -> float | None:
    """Return the temperature [K] that the constants stay at; None if they are at the melt's."""
    at, temperature = table.law_temperature, table.kelvin
    if at is None or table.activation_temperature:
        return None
    return None if abs(at - temperature) <= SAME_TEMPERATURE * temperature else at


def _at_temperature(table: MeltTable) -> dict[str, float | str]:
    """Return the name and the constants of the law at the melt's temperature, in SI.

    A law that lacks constants has an empty name: stages that need it are refused before.
    """
    if table.missing:
        return {"name": ""}
    name, temperature, at = str(table.law), table.kelvin, table.law_temperature
    constants = {key: getattr(table, key) for key in CONSTANTS[name]}
    if name != "cross-wlf" and (at in (None, temperature) or not table.activation_temperature):
        return {"name": name, **constants}
    if name == "cross-wlf":
        law: ViscosityLaw = CrossWLF(**constants, temperature=temperature).at_rest
        return {"name": "cross", **law.constants()}
    shift = ArrheniusShift(cast("float", table.activation_temperature), cast("float", at))
    factor = shift.factor(temperature)
    return {"name": name, **LAWS[name](**constants).scaled(factor, factor).constants()}
