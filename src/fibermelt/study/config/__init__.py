"""A study, as a value: every parameter of the chain in SI, declared once with its source."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from fibermelt.study.config.fiber import FROM_CONTENT, Fiber
from fibermelt.study.config.flow import Flow, Melt, Streamlines
from fibermelt.study.config.interaction import Interaction
from fibermelt.study.config.numerics import Numerics
from fibermelt.study.config.parts import PartName, What
from fibermelt.study.config.sensitivity import Sensitivity
from fibermelt.study.parameters import Section
from fibermelt.study.voids.config import Voids

__all__ = [
    "FROM_CONTENT",
    "Config",
    "Fiber",
    "Flow",
    "Interaction",
    "Melt",
    "Numerics",
    "PartName",
    "Sensitivity",
    "Streamlines",
    "Voids",
    "What",
]


class Config(Section):
    """A study: what `fibermelt run` is given, resolved."""

    study: What = Field(default_factory=What)
    flow: Flow = Field(default_factory=Flow)
    melt: Melt = Field(default_factory=Melt)
    fiber: Fiber = Field(default_factory=Fiber)
    streamlines: Streamlines = Field(default_factory=Streamlines)
    interaction: Interaction = Field(default_factory=Interaction)
    sensitivity: Sensitivity = Field(default_factory=Sensitivity)
    voids: Voids = Field(default_factory=Voids)
    numerics: Numerics = Field(default_factory=Numerics)

    @model_validator(mode="after")
    def _moisture(self) -> Self:
        """Refuse what the material's card does not allow, before the flow is computed."""
        if "voids" in self.study.parts:
            self.voids.refuse_impossible()
        return self

    @model_validator(mode="after")
    def _scales(self) -> Self:
        """Refuse a fiber that sees the walls: every model takes the flow for a uniform gradient."""
        width, half_length = self.flow.capillary_width, self.fiber.half_length
        if self.fiber.model != "confined-ellipse" and 2 * half_length >= width:
            msg = (
                f"fiber.half_length = {half_length:g} m is too long: the fiber does not fit across "
                f"the capillary, flow.capillary_width = {width:g} m; shorten the fiber"
            )
            raise ValueError(msg)
        if self.fiber.model != "confined-ellipse" or self.fiber.domain_size == "from-content":
            return self
        cell = self.fiber.domain_size * half_length
        if cell >= width:
            msg = (
                f"fiber.half_length = {half_length:g} m is too long: its cell is {cell:g} m "
                f"across (fiber.domain_size = {self.fiber.domain_size:g} half-lengths), "
                f"flow.capillary_width = {width:g} m; shorten the fiber or lower fiber.domain_size"
            )
            raise ValueError(msg)
        return self
