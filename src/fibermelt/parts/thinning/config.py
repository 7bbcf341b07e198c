"""The table ``[thinning]``."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from fibermelt.engine.parameters import Section, quantity
from fibermelt.parts.sources import PAPER_2

__all__ = ["Thinning"]


class Thinning(Section):
    """What thinning does: power laws that have the melt's viscosity at one rate."""

    indices: tuple[float, ...] = quantity(
        [0.8, 0.7, 0.5, 0.35, 0.25],
        "",
        "Indices of the power laws, falling; the Newtonian melt stands before them.",
        gt=0,
        ge=0.25,
        lt=1,
        source="chosen: the material cards have 0.24 to 0.5",
        hints={"ge": "the least that the table of spheroids has"},
    )
    rate: float = quantity(
        "100 1/s",
        "1/s",
        "Rate of deformation at which all have the melt's viscosity.",
        gt=0,
        source=PAPER_2,
    )

    @model_validator(mode="after")
    def _falling(self) -> Self:
        """Refuse no index, and indices that do not fall."""
        if not self.indices or any(
            b >= a for a, b in zip(self.indices, self.indices[1:], strict=False)
        ):
            msg = f"thinning.indices = {list(self.indices)}: must fall, such as [0.7, 0.35]"
            raise ValueError(msg)
        return self
