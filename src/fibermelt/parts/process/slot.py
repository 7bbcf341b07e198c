"""From a round nozzle and a printed bead to the planar study: what ``[process]`` lends.

A Newtonian melt of mean speed ``U`` has at the wall of a pipe of diameter ``d`` the rate
``8 U/d``, between plates ``W`` apart ``6 U/W``: both are the same for ``W = 0.75 d``. Of a power
law they are ``(8 U/d) (3n + 1)/(4n)`` and ``(6 U/W) (2n + 1)/(3n)`` (Bird, Armstrong and Hassager,
Dynamics of Polymeric Liquids 1, 1987, section 4.2), so that ``W/d = (2n + 1)/(3n + 1)``: 0.8 at
n = 1/2, and never more than 1. The slot is 0.75 wide by any law, so that a study of another melt is
one of the same nozzle; `wall_rate_ratio` tells what is off.

At equal wall stress the pressure falls by ``2 tau/W`` in the slot and by ``4 tau/d`` in the pipe:
by 2/3 of it, whatever the law.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from fibermelt.engine.parts import Lent
from fibermelt.errors import ConfigError
from fibermelt.flow.problem import Nozzle
from fibermelt.melt import ViscosityLaw
from fibermelt.melt.slit import SlitFlow
from fibermelt.parts.flow.config import Flow
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.process.config import Process
from fibermelt.units import parse

__all__ = ["SLOT", "Printed", "lend", "printed_flow", "wall_rate_ratio"]

SLOT = 0.75
"""Width of the slot over the diameter of the round nozzle."""

PROPORTIONS = ("inlet_width", "inlet_length", "taper_length", "capillary_length", "outlet")
"""Lengths of the nozzle that are the paper's over the capillary's width."""

PAPER = Nozzle()


@dataclass(frozen=True)
class Printed:
    """How much melt leaves the nozzle.

    Parameters
    ----------
    rate : float
        Volume in a time [m3/s].
    by : tuple of str
        The keys of ``[process]`` that say so.
    """

    rate: float
    by: tuple[str, ...]

    def mean_speed(self, diameter: float) -> float:
        """Return the mean speed [m/s] in a round nozzle, ``4 Q / (pi d^2)``."""
        return self.rate / (math.pi * diameter**2 / 4)


def printed_flow(process: Process, density: Callable[[], float | None]) -> Printed | None:
    """Return how much melt leaves the nozzle by mass balance; None where nothing tells.

    ``flow_rate`` as it is; else ``mass_flow`` over the melt's density; else layer height times
    bead width times print speed, a bead of rectangular section.

    Parameters
    ----------
    process : Process
        The table.
    density : callable
        Returns that of the melt with its fibers [kg/m3], None where it is not known.
    """
    if process.flow_rate is not None:
        return Printed(process.flow_rate, ("flow_rate",))
    if process.mass_flow is not None:
        known = density()
        return None if known is None else Printed(process.mass_flow / known, ("mass_flow",))
    bead = (process.layer_height, process.bead_width, process.print_speed)
    if None in bead:
        return None
    return Printed(
        math.prod(size for size in bead if size is not None),
        ("layer_height", "bead_width", "print_speed"),
    )


def wall_rate_ratio(law: ViscosityLaw, diameter: float, speed: float) -> float:
    """Return the rate at the slot's wall over that at the round nozzle's wall.

    ``(2n + 1)/(3n + 1) / 0.75``, with the index ``n`` of the power law that touches the law at the
    slot's wall: exact of a power law, 1 of a Newtonian melt, and never more than 4/3.

    Parameters
    ----------
    law : ViscosityLaw
        Of the melt.
    diameter, speed : float
        Of the round nozzle [m], and the mean speed in both [m/s].
    """
    n = float(law.index_at(SlitFlow(law, SLOT * diameter, speed).wall_rate))
    return (2 * n + 1) / (3 * n + 1) / SLOT


def lend(tables: Mapping[str, Any]) -> dict[str, Lent]:
    """Return what ``[process]`` gives of ``[flow]`` and ``[interaction]``, by key.

    The mean speed in the slot is that in the nozzle, so that the bead in the plane is as high as
    mass balance makes it there, ``U W / V``. Where ``[flow]`` says the inlet's width itself, its
    speed follows from that: the flow is the same.

    Parameters
    ----------
    tables : mapping
        A study as written, or as read.
    """
    process = _read(Process, tables.get("process"))
    if process is None:
        return {}

    def density() -> float | None:
        known = _read(Melt, tables.get("melt", {}))
        return None if known is None else known.density

    lent: dict[str, Lent] = {}

    def give(key: str, value: float, *by: str) -> None:
        lent[key] = Lent(value, tuple(f"process.{name}" for name in by))

    if process.nozzle_diameter is not None:
        slot = SLOT * process.nozzle_diameter
        give("flow.capillary_width", slot, "nozzle_diameter")
        for name in PROPORTIONS:
            length = getattr(PAPER, name) / PAPER.capillary_width * slot
            give(f"flow.{name}", length, "nozzle_diameter")
        inlet = _inlet(tables.get("flow")) or lent["flow.inlet_width"].value
        if (flux := printed_flow(process, density)) is not None:
            mean = flux.mean_speed(process.nozzle_diameter)
            give("flow.inlet_speed", mean * slot / inlet, *flux.by, "nozzle_diameter")
    if process.layer_height is not None:
        give("flow.gap", process.layer_height, "layer_height")
    if process.print_speed is not None:
        give("flow.bed_speed", process.print_speed, "print_speed")
    if process.fiber_weight_fraction is not None and (known := density()) is not None:
        content = process.fiber_weight_fraction * known / process.fiber_density
        by = ("fiber_weight_fraction", "fiber_density")
        give("interaction.volume_fraction", content, *by)
    return lent


def _read(kind: Any, table: Any) -> Any:
    """Return a table that is not at fault; None where it is, or where there is none."""
    if table is None or isinstance(table, kind):
        return table
    try:
        return kind.model_validate(table)
    except ValidationError:
        return None


def _inlet(flow: Any) -> float | None:
    """Return the width of the inlet [m] that ``[flow]`` says itself, if it is one."""
    if isinstance(flow, Flow):
        return flow.inlet_width
    try:
        width = parse(flow["inlet_width"], "m")
    except (ConfigError, KeyError, TypeError):
        return None
    return width if width > 0 else None
