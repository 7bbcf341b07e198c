"""What a study may not say of its process, and what a person should know of what was made of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from fibermelt.engine.parameters import declarations, flatten
from fibermelt.errors import ConfigError
from fibermelt.parts.flow.config import Flow
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.melt.melt import melt_of
from fibermelt.parts.process.config import Process
from fibermelt.parts.process.slot import SLOT, lend, printed_flow, wall_rate_ratio
from fibermelt.units import MM

if TYPE_CHECKING:
    from fibermelt.engine.parts import Lent
    from fibermelt.engine.tables import Tables

__all__ = ["process_notes", "refuse_process"]

OF_FLOW = ("flow_rate", "mass_flow", "bead_width")
"""Keys that tell the flow, which is a speed in a nozzle of known diameter only."""

SAME_FLOW = 0.1
"""Part by which a volume and a mass of the flow, or the flow and the bead's section, may differ and
be one: densities of a melt are often those of its solid, 8 to 10 % more."""

LARGEST_SURPLUS = 2.0
"""Flow over that of the bead, or its inverse, beyond which one of them is a slip."""

ONE_LAYER = (0.9, 1.1)
"""Height of the bead over the gap where a layer is printed: below, the strand is drawn down and
leaves the nozzle's lips behind; above, the melt has to go beside, which the plane has not."""

SAME_CONTENT = 0.01
"""Weight of fibers over that of the melt by which study and card may differ."""

SLOWEST_THINNING = 1.01
"""Ratio of wall rates below which nobody needs to know of it."""


def refuse_process(study: Tables) -> None:
    """Refuse what has no effect, and what contradicts itself.

    Raises
    ------
    ConfigError
        The key, the value, the bound and the way out.
    """
    process = study.table(Process)
    source, given = study.table(Flow).source, _given(process)
    if not given:
        return
    if source == "deposition-3d":
        msg = (
            f"process.{given[0]}: lends [flow] a slot in the plane for a round nozzle, and "
            'flow.source = "deposition-3d" takes the nozzle as it is: say flow.capillary_width and '
            "the rest of [flow] in its place"
        )
        raise ConfigError(msg)
    if source != "deposition":
        msg = (
            f'process.{given[0]}: is not read with flow.source = "{source}", a flow that is there '
            "already: leave it away"
        )
        raise ConfigError(msg)
    idle = [name for name in OF_FLOW if name in given and process.nozzle_diameter is None]
    if idle:
        msg = (
            f"process.nozzle_diameter: missing: process.{idle[0]} is of a flow, which gives the "
            "speed in a nozzle of known diameter; say it, or flow.inlet_speed in place of the flow"
        )
        raise ConfigError(msg)
    flow = printed_flow(process, lambda: study.table(Melt).density)
    if flow is None and process.bead_width is not None:
        lacking = [name for name in ("layer_height", "print_speed") if name not in given]
        msg = (
            f"process.{lacking[0]}: missing: process.bead_width gives the flow together with "
            "process.layer_height and process.print_speed; say it, or process.flow_rate"
        )
        raise ConfigError(msg)
    _refuse_two_flows(process, study.table(Melt).density)
    least, most = _surplus(study)
    if not most >= 1 / LARGEST_SURPLUS or not least <= LARGEST_SURPLUS:
        key = flow.by[0] if flow else ""
        msg = (
            f"process.{key} = {getattr(process, key):g}: is {least:.3g} times the bead's "
            "process.layer_height x process.bead_width x process.print_speed: must be from "
            f"{1 / LARGEST_SURPLUS:g} to {LARGEST_SURPLUS:g}; correct one of these"
        )
        raise ConfigError(msg)


def _given(process: Process) -> list[str]:
    """Return the keys of the flow that the table has."""
    return [
        name
        for name in type(process).model_fields
        if not name.startswith("fiber_") and getattr(process, name) is not None
    ]


def _refuse_two_flows(process: Process, density: float | None) -> None:
    """Refuse a volume and a mass of the melt that are not of one flow."""
    if process.flow_rate is None or process.mass_flow is None or density is None:
        return
    by_mass = process.mass_flow / density
    if abs(by_mass / process.flow_rate - 1) <= SAME_FLOW:
        return
    msg = (
        f"process.mass_flow = {process.mass_flow:g} kg/s: is {by_mass:.4g} m^3/s at melt.density = "
        f"{density:g} kg/m^3, and process.flow_rate = {process.flow_rate:g} m^3/s: must agree "
        f"within {100 * SAME_FLOW:g} %; leave one of them away"
    )
    raise ConfigError(msg)


def _surplus(study: Tables) -> tuple[float, float]:
    """Return the flow over that of a bead of rectangular section, and of one with round sides.

    Both are 1 where one of them is not known. The sides of a printed bead are between the two: a
    section ``h w`` and one ``h w - (1 - pi/4) h^2``, with half circles for sides.
    """
    process = study.table(Process)
    flow = printed_flow(process, lambda: study.table(Melt).density)
    h, w, speed = process.layer_height, process.bead_width, process.print_speed
    if flow is None or h is None or w is None or speed is None or len(flow.by) > 1:
        return 1.0, 1.0
    full = flow.rate / (h * w * speed)
    return full, full / (1 - (1 - math.pi / 4) * min(1.0, h / w))


def process_notes(study: Tables) -> list[str]:
    """Tell what was made of the process, and what the plane cannot keep of it."""
    process, flow = study.table(Process), study.table(Flow)
    if process == Process():
        return []
    lent, values = _lent(study), flatten(study)
    notes = [*_nozzle(study, lent), *_printed(study)]
    if process.layer_height is not None and flow.source == "deposition":
        notes += _layer(flow)
    notes += _content(study, lent)
    units = {item.key: item.unit for item in declarations(type(study))}
    notes += [
        f"{key} = {values[key]:.4g} {units[key]}".rstrip() + f" is said, and wins over the "
        f"{one.value:.4g} that {' and '.join(one.by)} would give"
        for key, one in lent.items()
        if values[key] != one.value
    ]
    return notes


def _lent(study: Tables) -> dict[str, Lent]:
    """Return what the process gives, of a study as read."""
    return lend(
        {"process": study.table(Process), "flow": study.table(Flow), "melt": study.table(Melt)}
    )


def _nozzle(study: Tables, lent: Mapping[str, Lent]) -> list[str]:
    """Tell the slot that stands for the round nozzle, and what it does not keep."""
    process, flow = study.table(Process), study.table(Flow)
    diameter = process.nozzle_diameter
    if diameter is None:
        return []
    notes = [
        f"the round nozzle of {MM * diameter:.4g} mm is a slot {MM * SLOT * diameter:.4g} mm wide, "
        "which has its mean speed and, of a Newtonian melt, its rate at the wall; along it the "
        "pressure falls by 2/3 as much, and what [flow] does not say of the nozzle above it has "
        "the proportions of the paper's"
    ]
    melt = study.table(Melt)
    if not melt.missing:
        law = melt_of(melt).law
        speed = flow.inlet_speed * flow.inlet_width / (SLOT * diameter)
        ratio = 1.0 if law.is_newtonian else wall_rate_ratio(law, diameter, speed)
        if ratio > SLOWEST_THINNING:
            notes.append(
                f"in a melt that thins the rate at the slot's wall is {ratio:.3g} times that at "
                "the round nozzle's"
            )
    defaults = Flow()
    assumed = [
        f"flow.{name} ({ways})"
        for name, ways in {
            "gap": "process.layer_height",
            "bed_speed": "process.print_speed",
            "inlet_speed": "process.flow_rate, process.mass_flow or process.bead_width",
        }.items()
        if getattr(flow, name) == getattr(defaults, name) and f"flow.{name}" not in lent
    ]
    if assumed:
        notes.append(
            f"{', '.join(assumed)} {'is' if len(assumed) == 1 else 'are'} the paper's: is this "
            "meant?"
        )
    return notes


def _printed(study: Tables) -> list[str]:
    """Tell the flow, what it is from, and whether the bead has room for it."""
    process = study.table(Process)
    flow = printed_flow(process, lambda: study.table(Melt).density)
    if flow is None or process.nozzle_diameter is None:
        return []
    notes = [
        f"the flow is {MM**3 * flow.rate:.4g} mm^3/s by {' x '.join(flow.by)}, "
        f"{MM * flow.mean_speed(process.nozzle_diameter):.4g} mm/s in the nozzle; the bead's width "
        "has no place in the plane"
    ]
    least, most = _surplus(study)
    if least > 1 + SAME_FLOW or most < 1 - SAME_FLOW:
        notes.append(
            f"the flow is {least:.3g} times layer height x bead width x print speed, {most:.3g} "
            f"times that of a bead with round sides: more than {100 * SAME_FLOW:g} % "
            f"{'more' if least > 1 else 'less'} than the bead takes"
        )
    return notes


def _layer(flow: Flow) -> list[str]:
    """Tell the height of the bead in the plane, beside that of the layer."""
    height, ratio = flow.bead_height, flow.bead_height / flow.gap
    low, high = ONE_LAYER
    told = (
        f"the bead in the plane is {MM * height:.4g} mm high, {ratio:.3g} of the gap of "
        f"{MM * flow.gap:.4g} mm: it has the nozzle's mean speed, and leaves no melt to the sides"
    )
    if ratio > high:
        told += (
            f"; above {high:g} the melt is pressed up the nozzle, where in a printed bead it goes "
            "to the sides: print narrower, or raise the layer"
        )
    if ratio < low:
        told += (
            f"; below {low:g} the strand is drawn down, and does not fill the layer: print wider, "
            "or lower the layer"
        )
    return [told]


def _content(study: Tables, lent: Mapping[str, Lent]) -> list[str]:
    """Tell the fiber content by volume, and a card of a melt that has another."""
    process, melt = study.table(Process), study.table(Melt)
    weight, found = process.fiber_weight_fraction, lent.get("interaction.volume_fraction")
    if weight is None or found is None:
        return []
    notes = [
        f"{100 * weight:.3g} % of fibers by weight are {100 * found.value:.3g} % by volume: "
        f"{process.fiber_density:g} kg/m^3 in a melt of {melt.density:g} kg/m^3"
    ]
    known = 1 - melt.card.melt.polymer_fraction
    if abs(weight - known) > SAME_CONTENT:
        notes.append(
            f'the card melt.material = "{melt.material}" is of a melt with {100 * known:.3g} % of '
            f"fibers by weight, process.fiber_weight_fraction = {100 * weight:.3g} %: viscosity, "
            "density and what holds moisture are the card's; take a card of this melt"
        )
    return notes
