"""The table ``[voids]`` of a study."""

from __future__ import annotations

from typing import Literal

from fibermelt.engine.parameters import Section, quantity, setting

__all__ = ["Voids"]


class Voids(Section):
    """The moisture in the melt, and what counts as nucleation."""

    moisture: float | Literal["from-card"] = quantity(
        "0.17 %",
        "",
        "Moisture over the mass of polymer (from card: as received).",
        words=("from-card",),
        ge=0,
        le=1,
        source="lowest of the ABS filaments, 0.17 to 0.75 wt%, of Materials 2024, 17, 1988",
    )
    threshold_rate: float = quantity(
        "1 1/(m^3 s)",
        "1/(m^3 s)",
        "Rate of nucleation that counts as its onset.",
        gt=0,
        ge=1e-30,
        le=1e30,
        source="the paper, Appendix I: J >= 1",
    )
    nucleus_radius: float = quantity(
        "1 um",
        "m",
        "Radius of a nucleus in its crevice at a fiber's tip.",
        gt=0,
        ge=1e-9,
        le=1e-4,
        source="assumed, 0.1 to 5 um: pits of a broken end, gaps of its sizing; none was measured",
    )
    nucleated_tips: float = quantity(
        1.0,
        "",
        "Share of the fibers' tips that hold a nucleus.",
        gt=0,
        le=1,
        source="assumed, 0.01 to 1: every tip, the most there can be",
    )
    bed_time: float = quantity(
        "1 s",
        "s",
        "Time on the bed, after the swell, at which the void content is told again.",
        gt=0,
        ge=1e-6,
        le=1e5,
        source="assumed, 0.05 to 10 s: a bead h high is cold after h^2/(10 alpha), with alpha = "
        "8e-8 m2/s of ABS after 0.05 s if it is 0.2 mm high, after 10 s if it is 3 mm",
    )
    layers: int = setting(
        10, "Number of layers of the profile from the bed to the free surface.", ge=2, le=1000
    )
