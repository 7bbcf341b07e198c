"""The levers of a printer: what an operator can move, and by how much in one step.

A step is a complete change of settings that a study can run with; nothing is scaled from it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from fibermelt.parts.process.slot import lend
from fibermelt.parts.voids.answer import MOISTURE

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value

__all__ = ["COSTS_NOTHING", "Step", "steps_of"]

SHARE = 0.05
"""Part by which speeds and lengths of a nozzle are moved: what a slicer's setting allows at once,
far above the flow's own error and below where a shape of the bead turns into another."""

KELVIN = 10.0
"""Step of the melt's temperature [K]."""

SHORTER = 0.8
"""Fibers of the next shorter pellets, over these: they keep their width."""

LESS = 0.8
"""Fiber content of the next lower grade, over this one."""

COSTS_NOTHING = ""
"""What a lever costs that neither slows the print down nor changes the material."""


@dataclass(frozen=True)
class Step:
    """One lever, moved.

    Parameters
    ----------
    lever : str
        What is moved, in words of the trade.
    settings : mapping
        The keys that change and what they become, in SI.
    costs : str
        What it costs: ``"output"``, ``"another compound"``, or nothing.
    """

    lever: str
    settings: Mapping[str, float]
    costs: str = COSTS_NOTHING

    def mirrored(self, values: Mapping[str, Value]) -> dict[str, float]:
        """Return as large a step the other way."""
        return {
            key: 2.0 * float(cast("float", values[key])) - to for key, to in self.settings.items()
        }


@dataclass(frozen=True)
class _Lever:
    """Keys that are moved together, by a factor or by a difference."""

    name: str
    keys: tuple[str, ...]
    factors: tuple[float, ...] = ()
    differences: tuple[float, ...] = ()
    costs: str = COSTS_NOTHING
    moves: tuple[str, ...] = ()
    """Keys of the plane that follow from these, of a lever of ``[process]``."""

    def steps(self, values: Mapping[str, Value]) -> Iterator[Step]:
        """Yield its steps, as far as the study has numbers to move."""
        base = {key: values.get(key) for key in self.keys}
        numbers = {key: float(one) for key, one in base.items() if isinstance(one, int | float)}
        if len(numbers) < len(self.keys) or not all(numbers.values()):
            return
        for factor in self.factors:
            yield Step(self.name, {k: v * factor for k, v in numbers.items()}, self.costs)
        for difference in self.differences:
            yield Step(self.name, {k: v + difference for k, v in numbers.items()}, self.costs)


SPEEDS, FLOW = ("flow.inlet_speed", "flow.bed_speed"), ("flow.inlet_speed",)
GAP, WIDTH = ("flow.gap",), ("flow.capillary_width",)
CONTENT = ("interaction.volume_fraction",)

TOGETHER = "print speed and flow together"
NOZZLE = (
    _Lever(TOGETHER, SPEEDS, (1.0 - SHARE,), costs="output"),
    _Lever("flow at the same print speed and gap", FLOW, (1.0 + SHARE,), costs="the bead’s height"),
    _Lever("gap between nozzle and bed", GAP, (1.0 - SHARE,)),
    _Lever("nozzle diameter", WIDTH, (1.0 - SHARE,)),
    _Lever("length of the nozzle’s land", ("flow.capillary_length",), (1.0 - SHARE,)),
)  # fmt: skip
"""Levers of a flow that is solved here: one from elsewhere has a nozzle of its own. Each goes the
way that lets less pressure fall on the paper's bead."""

TEMPERATURE = "melt.temperature"

MELT = (
    _Lever("temperature of the melt", (TEMPERATURE,), differences=(KELVIN,)),
    _Lever("moisture", (MOISTURE,), (0.5,)),
    _Lever("fiber length", ("fiber.half_length", "fiber.aspect_ratio"), (SHORTER,),
           costs="another compound"),
    _Lever("fiber content", CONTENT, (LESS,), costs="another compound"),
)  # fmt: skip


def _of_printer(values: Mapping[str, Value]) -> list[_Lever]:
    """Return the levers of ``[process]``, which a file of a printer has: they can be pasted there.

    Where the bead's section says the flow, print speed alone moves both, its width the flow at one
    layer height, and a lower layer lays down less.
    """
    said = [f"process.{name}" for name in ("flow_rate", "mass_flow")]
    rate = [key for key in said if values.get(key) is not None][:1]
    return [
        _Lever(TOGETHER, ("process.print_speed", *rate), (1.0 - SHARE,),
               costs="output", moves=SPEEDS),
        _Lever("flow at the same print speed and layer height", tuple(rate), (1.0 + SHARE,),
               costs="the bead’s width", moves=FLOW)
        if rate
        else _Lever("width of the bead", ("process.bead_width",), (1.0 + SHARE,),
                    costs="the bead’s width", moves=FLOW),
        _Lever("layer height", ("process.layer_height",), (1.0 - SHARE,),
               costs=COSTS_NOTHING if rate else "output", moves=GAP),
        _Lever("nozzle diameter", ("process.nozzle_diameter",), (1.0 - SHARE,), moves=WIDTH),
        _Lever("fiber content", ("process.fiber_weight_fraction",), (LESS,),
               costs="another compound", moves=CONTENT),
    ]  # fmt: skip


def _effective(levers: Sequence[_Lever], values: Mapping[str, Value]) -> dict[Any, _Lever]:
    """Return the levers of ``[process]`` that move what they stand for, by what that is.

    A key of ``[flow]`` that the study says itself wins over them.
    """
    tables: dict[str, dict[str, Any]] = {"process": {}, "flow": {}}
    for key, value in values.items():
        table, _, name = key.partition(".")
        if table in tables:
            tables[table][name] = value
    lent = lend({**tables, "melt": {"density": values.get("melt.density")}})
    return {
        one.moves: one
        for one in levers
        if all(
            key in lent and math.isclose(lent[key].value, float(cast("float", values[key])))
            for key in one.moves
        )
    }


def steps_of(values: Mapping[str, Value]) -> list[Step]:
    """Return the steps of all levers that a study has.

    Parameters
    ----------
    values : mapping
        The resolved study, with numbers for what a card may say.
    """
    levers = (*(NOZZLE if values["flow.source"] == "deposition" else ()), *MELT)
    printers = _effective(_of_printer(values), values)
    levers = tuple(printers.get(one.keys, one) for one in levers)
    return [
        step
        for lever in levers
        if lever.keys != (TEMPERATURE,) or _follows_temperature(values)
        for step in lever.steps(values)
    ]


def _follows_temperature(values: Mapping[str, Value]) -> bool:
    """Tell whether the melt's viscosity is known at another temperature.

    Vapor pressure alone would tell half of what a temperature does, and the wrong half.
    """
    return values["melt.law"] == "cross-wlf" or bool(values["melt.activation_temperature"])
