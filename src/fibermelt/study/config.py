"""A study, as a value: every parameter of the chain in SI, declared once with its source."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from fibermelt.engine.parameters import Section
from fibermelt.errors import ConfigError
from fibermelt.paper.config import Sensitivity
from fibermelt.parts.bead.config import FROM_CONTENT, Fiber
from fibermelt.parts.flow.config import Flow, Streamlines
from fibermelt.parts.flow.field_table import ImportedField
from fibermelt.parts.flow.paths_table import STATIONS, Paths
from fibermelt.parts.interaction.config import Interaction
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.melt.melt import (
    melt_of,
    refuse_incomplete,
    refuse_unphysical,
    thins,
    values_of,
)
from fibermelt.parts.numerics import Numerics
from fibermelt.parts.thinning.config import Thinning
from fibermelt.parts.voids.config import Voids
from fibermelt.study.what import PartName, What

__all__ = [
    "FROM_CONTENT",
    "Config",
    "Fiber",
    "Flow",
    "ImportedField",
    "Interaction",
    "Melt",
    "Numerics",
    "PartName",
    "Paths",
    "Sensitivity",
    "Streamlines",
    "Thinning",
    "Voids",
    "What",
]


WITHOUT_VISCOSITY = frozenset({"interaction", "verification", "claims"})
"""Parts that ask no viscosity of the melt."""


USUAL_RATE = 1e3
"""Rate [1/s] that a flow may have that is not known before its file is read."""

DEPOSITION_PARTS = ("dimensions", "thinning", "claims")
"""Parts about the paper's bead, its nozzle and its mesh."""

NEWTONIAN_PARTS = ("orbits", "dimensions", "thinning")
"""Parts that begin with a Newtonian melt: the paper's section 2.3, and what thinning changes."""


class Config(Section):
    """A study: what `fibermelt run` is given, resolved."""

    study: What = Field(default_factory=What)
    flow: Flow = Field(default_factory=Flow)
    field: ImportedField = Field(default_factory=ImportedField)
    paths: Paths = Field(default_factory=Paths)
    melt: Melt = Field(default_factory=Melt)
    fiber: Fiber = Field(default_factory=Fiber)
    streamlines: Streamlines = Field(default_factory=Streamlines)
    interaction: Interaction = Field(default_factory=Interaction)
    sensitivity: Sensitivity = Field(default_factory=Sensitivity)
    thinning: Thinning = Field(default_factory=Thinning)
    voids: Voids = Field(default_factory=Voids)
    numerics: Numerics = Field(default_factory=Numerics)

    @model_validator(mode="after")
    def _melted(self) -> Self:
        """Refuse a melt that parts of the study cannot do with, before the flow is computed."""
        try:
            if not WITHOUT_VISCOSITY.issuperset(self.study.parts):
                refuse_incomplete(self.melt)
                refuse_unphysical(self.melt, self._fastest if self._is_solved else USUAL_RATE)
            if "voids" in self.study.parts:
                self._moisture()
        except ConfigError as error:
            raise ValueError(str(error)) from error
        return self

    @property
    def _is_solved(self) -> bool:
        """Return whether the flow is the one of `[flow]`."""
        return self.flow.source == "deposition"

    @property
    def _fastest(self) -> float:
        """Return the highest rate of deformation that the flow's mesh resolves at a lip [1/s]."""
        speed = max(self.flow.bed_speed, self.flow.inlet_speed)
        return speed / (self.numerics.lip_edge * self.flow.capillary_width)

    def _moisture(self) -> None:
        """Refuse a moisture that the card does not know, or does not allow."""
        from fibermelt.parts.voids.melt import moist_melt  # noqa: PLC0415  lazy: NumPy

        moist_melt(self.melt.card, self.voids.moisture, self.melt.temperature)

    @model_validator(mode="after")
    def _thinned(self) -> Self:
        """Refuse what has no answer in a melt that thins."""
        if self.melt.missing or not thins(values_of(self)):
            return self
        melt = f'in a melt that thins, melt.law = "{self.melt.law}"'
        known = [name for name in NEWTONIAN_PARTS if name in self.study.parts]
        if known:
            rest = ", ".join(f'"{name}"' for name in self.study.parts if name not in known)
            named = " and ".join(f'"{name}"' for name in known)
            msg = (
                f"study.parts: {named} has no answer {melt}: say study.parts = [{rest}], or "
                'melt.law = "newtonian" and melt.viscosity'
            )
            raise ValueError(msg)
        fiber = self.fiber
        local = 'fiber.melt = "local-viscosity", an approximation'
        if fiber.melt == "local-viscosity":
            if fiber.path == "newton":
                msg = (
                    f'fiber.path = "newton" with fiber.melt = "local-viscosity": has no answer '
                    f'{melt}: take fiber.path = "superposition"'
                )
                raise ValueError(msg)
            return self
        if fiber.directions == "equal-area":
            msg = (
                f'fiber.directions = "equal-area": has no answer {melt}, where fibers are known in '
                f'the plane of the flow: take "in-plane", or {local}'
            )
            raise ValueError(msg)
        if fiber.model == "ellipsoid":
            msg = f'fiber.model = "ellipsoid": has no answer {melt}: take "spheroid", or {local}'
            raise ValueError(msg)
        if fiber.model == "spheroid":
            self._spheroid(local)
        if self.numerics.cell_mesh == "paper":
            msg = (
                f'numerics.cell_mesh = "paper": is too coarse for a fiber {melt}: take "graded", '
                f"or {local}"
            )
            raise ValueError(msg)
        return self

    def _spheroid(self, local: str) -> None:
        """Refuse spheroids beyond the table of those in a melt that thins."""
        from fibermelt.fiber.spheroid import Spheroid  # noqa: PLC0415  lazy: NumPy
        from fibermelt.fiber.thinning_spheroid import (  # noqa: PLC0415
            unbounded_thinning_spheroid,
        )

        try:
            unbounded_thinning_spheroid(Spheroid(1.0, self.fiber.aspect_ratio), melt_of(self).law)
        except ConfigError as error:
            msg = f'{error}; or take fiber.model = "ellipse", or {local}'
            raise ValueError(msg) from error

    @model_validator(mode="after")
    def _sources(self) -> Self:
        """Refuse a flow without its file, a file without its flow, and what has no answer there."""
        source, given = self.flow.source, {"field": self.field.file, "histories": self.paths.file}
        keys = {"field": "field.file", "histories": "paths.file"}
        for name, file in given.items():
            if name == source and not file:
                msg = f'{keys[name]}: missing: flow.source = "{source}" reads the flow from it'
                raise ValueError(msg)
            if name != source and file:
                msg = (
                    f'{keys[name]} = "{file}": is not read with flow.source = "{source}": say '
                    f'flow.source = "{name}", or leave it away'
                )
                raise ValueError(msg)
        default = Paths()
        read = {
            "field": tuple(Paths.model_fields),
            "histories": ("file", "content", *STATIONS),
            "deposition": ("file", "content"),
        }
        idle = [
            name
            for name in Paths.model_fields
            if name not in read[source] and getattr(self.paths, name) != getattr(default, name)
        ]
        if idle:
            msg = (
                f'paths.{idle[0]}: is not read with flow.source = "{source}": leave it away, or '
                'say flow.source = "field"'
            )
            raise ValueError(msg)
        points, usual = self.streamlines.points, type(self.streamlines)().points
        if source == "histories" and points != usual:
            msg = (
                f'streamlines.points = {points}: is not read with flow.source = "histories": a '
                "path keeps the points that its table gives it; leave it away"
            )
            raise ValueError(msg)
        known = [name for name in DEPOSITION_PARTS if name in self.study.parts]
        if source != "deposition" and known:
            msg = (
                f'study.parts: "{known[0]}" is about the deposition flow, and flow.source = '
                f'"{source}": leave it away'
            )
            raise ValueError(msg)
        return self

    @model_validator(mode="after")
    def _scales(self) -> Self:
        """Refuse a fiber that sees the walls: every model takes the flow for a uniform gradient."""
        if not self._is_solved:
            return self
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
