"""The table ``[sensitivity]``."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from fibermelt.engine.parameters import Section, quantity
from fibermelt.parts.sources import TABLE_1, VERIFIED

__all__ = ["Sensitivity"]


class Sensitivity(Section):
    """One fiber in simple shear: what is varied, and the cell that it turns in."""

    aspect_ratios: tuple[float, ...] = quantity(
        [1.0, 3.0, 6.0, 8.0, 10.0], "", "Aspect ratios.", ge=1, le=50, source=TABLE_1
    )
    shear_rates: tuple[float, ...] = quantity(
        ["0.25 1/s", "0.5 1/s", "1 1/s", "2 1/s", "5 1/s"],
        "1/s",
        "Shear rates.",
        gt=0,
        source=TABLE_1,
    )
    viscosities: tuple[float, ...] = quantity(
        ["200 Pa s", "400 Pa s", "817 Pa s", "1600 Pa s"],
        "Pa s",
        "Viscosities.",
        ge=1e-6,
        le=1e12,
        source="chosen: the paper varies the viscosity but states no values in its text",
    )
    shear_rate: float = quantity(
        "1 1/s", "1/s", "Shear rate while something else is varied.", gt=0, source=TABLE_1
    )
    domain_size: float = quantity(
        28.0,
        "",
        "Domain-size factor M of the cell that the fiber turns in.",
        gt=2,
        ge=2.01,
        le=200,
        source="chosen: gives the periods of the paper's finite elements (Table 1) at aspect "
        "ratios of 6, 8 and 10 within 0.2 %; the paper does not state its own",
        hints={"gt": "the fiber would be larger than its cell", "ge": VERIFIED, "le": VERIFIED},
    )

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        """Refuse no aspect ratio, and what is listed twice."""
        if not self.aspect_ratios:
            msg = "sensitivity.aspect_ratios = []: at least one, such as [6]"
            raise ValueError(msg)
        for name in ("aspect_ratios", "shear_rates", "viscosities"):
            values = getattr(self, name)
            if len(set(values)) < len(values):
                msg = f"sensitivity.{name}: lists a value twice: name each once"
                raise ValueError(msg)
        return self
