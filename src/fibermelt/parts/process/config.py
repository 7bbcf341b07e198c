"""The table ``[process]``."""

from __future__ import annotations

from fibermelt.engine.parameters import Section, quantity

__all__ = ["Process"]


class Process(Section):
    """What a printer is set to. It gives what [flow] and [interaction] do not say themselves."""

    nozzle_diameter: float | None = quantity(
        None,
        "m",
        "Diameter of the round nozzle at its exit; the capillary is the slot of its mean speed and "
        "its rate at the wall, 0.75 of it wide, and the nozzle above has the paper's proportions.",
        gt=0,
        le=1,
        example="7.6 mm",
    )
    layer_height: float | None = quantity(
        None,
        "m",
        "Height of a layer: the nozzle's distance from the bed.",
        gt=0,
        le=1,
        example="3.8 mm",
    )
    bead_width: float | None = quantity(
        None,
        "m",
        "Width of the bead that is laid. Times layer_height and print_speed it is the flow, where "
        "neither flow_rate nor mass_flow is given; nothing else in the plane has a width.",
        gt=0,
        le=1,
        example="8.4 mm",
    )
    print_speed: float | None = quantity(
        None, "m/s", "Speed of the nozzle over the bed.", gt=0, le=100, example="101.6 mm/s"
    )
    flow_rate: float | None = quantity(
        None,
        "m^3/s",
        "Volume of melt that leaves the nozzle in a time.",
        gt=0,
        le=1,
        example="3.2 cm^3/s",
    )
    mass_flow: float | None = quantity(
        None,
        "kg/s",
        "Mass of it; melt.density makes it a volume.",
        gt=0,
        le=1e3,
        example="14 kg/h",
    )
    fiber_weight_fraction: float | None = quantity(
        None,
        "",
        "Fiber content by weight; it gives that by volume.",
        gt=0,
        lt=1,
        example="20 %",
    )
    fiber_density: float = quantity(
        "1780 kg/m^3",
        "kg/m^3",
        "Density of the fibers, for their content by volume.",
        gt=0,
        le=1e5,
        source="carbon fiber: 13 % by weight in the paper's melt are then its 8.4 % by volume",
    )
