"""The table ``[voids]`` of a study."""

from __future__ import annotations

from typing import Literal

from fibermelt.errors import ConfigError
from fibermelt.study.parameters import Section, quantity, setting

__all__ = ["Voids"]


class Voids(Section):
    """The moisture in the melt, and what counts as nucleation."""

    material: Literal["abs-cf13", "pei", "pla"] = setting(
        "abs-cf13",
        "Material card that says how the melt holds moisture; fibermelt voids takes others too.",
        source="the paper, section 2",
    )
    moisture: float | Literal["from-card"] = quantity(
        "0.17 %",
        "",
        "Moisture over the mass of polymer (from card: as received).",
        words=("from-card",),
        ge=0,
        le=1,
        source="lowest of the ABS filaments, 0.17 to 0.75 wt%, of Materials 2024, 17, 1988",
    )
    temperature: float | Literal["from-card"] = quantity(
        "230 degC",
        "K",
        "Temperature of the melt, the same everywhere (from card: that of printing).",
        words=("from-card",),
        ge=273.16,
        le=647.096,
        source="the paper, section 2",
        hints={"ge": "water's triple point", "le": "water's critical point"},
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

    def refuse_impossible(self) -> None:
        """Refuse what the material's card does not allow.

        Raises
        ------
        ValueError
            If it does not: not of a study without voids, which needs no card.
        """
        from fibermelt.study.voids.melt import moist_melt  # noqa: PLC0415  lazy: NumPy

        try:
            moist_melt(self.material, self.moisture, self.temperature, self.threshold_rate)
        except ConfigError as error:
            raise ValueError(str(error)) from error
