"""A study, as a value: every parameter of the chain in SI, declared once with its source."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from fibermelt.errors import ConfigError
from fibermelt.study.config.fiber import FROM_CONTENT, Fiber
from fibermelt.study.config.flow import Flow, Streamlines
from fibermelt.study.config.interaction import Interaction
from fibermelt.study.config.melt import Melt
from fibermelt.study.config.numerics import Numerics
from fibermelt.study.config.parts import PartName, What
from fibermelt.study.config.sensitivity import Sensitivity
from fibermelt.study.melt import refuse_incomplete, refuse_unphysical
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


WITHOUT_VISCOSITY = frozenset({"interaction", "verification", "claims"})
"""Parts that ask no viscosity of the melt."""


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
    def _melted(self) -> Self:
        """Refuse a melt that parts of the study cannot do with, before the flow is computed."""
        try:
            if not WITHOUT_VISCOSITY.issuperset(self.study.parts):
                refuse_incomplete(self.melt)
                refuse_unphysical(self.melt, self._fastest)
            if "voids" in self.study.parts:
                self._moisture()
        except ConfigError as error:
            raise ValueError(str(error)) from error
        return self

    @property
    def _fastest(self) -> float:
        """Return the highest rate of deformation that the flow's mesh resolves at a lip [1/s]."""
        speed = max(self.flow.bed_speed, self.flow.inlet_speed)
        return speed / (self.numerics.lip_edge * self.flow.capillary_width)

    def _moisture(self) -> None:
        """Refuse a moisture that the card does not know, or does not allow."""
        from fibermelt.study.voids.melt import moist_melt  # noqa: PLC0415  lazy: NumPy

        moist_melt(self.melt.card, self.voids.moisture, self.melt.temperature)

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
