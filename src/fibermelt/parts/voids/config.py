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
    layers: int = setting(
        10, "Number of layers of the profile from the bed to the free surface.", ge=2, le=1000
    )
