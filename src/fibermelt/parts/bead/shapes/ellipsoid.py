"""An ellipsoid of three axes in a melt without end, in closed form."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from fibermelt.parts.bead.shape import FiberShape, Sizes

if TYPE_CHECKING:
    from fibermelt.engine.stages import Say
    from fibermelt.fiber.cell_data import CellNumerics
    from fibermelt.fiber.models import FiberModel
    from fibermelt.parts.bead.shape import Arrays

__all__ = ["SHAPE"]


class UnboundedEllipsoid(FiberShape):
    """An ellipsoid whose third axis is across the flow while it lies in its plane."""

    name = "ellipsoid"
    meaning = "an ellipsoid of three axes without a cell"
    label = "ellipsoid, unbounded"
    plural = "unbounded ellipsoids of three axes"
    rank = 3
    in_space = True
    has_thickness = True
    thins = False
    instead = "spheroid"
    stored = ("aspect_ratio", "thickness_ratio")

    def model(self, sizes: Sizes, cell: float, numerics: CellNumerics | None) -> FiberModel:
        """Return the fiber in a Newtonian melt; without a thickness it is a spheroid."""
        from fibermelt.fiber.ellipsoid import Ellipsoid  # noqa: PLC0415  lazy: see the module
        from fibermelt.fiber.models import unbounded_model  # noqa: PLC0415

        ratio, a = sizes.aspect_ratio, sizes.half_length
        return unbounded_model("ellipsoid", Ellipsoid((a, a / ratio, a / _thickness(sizes))))

    def restored(self, stored: Arrays) -> FiberModel:
        """Return the fiber from its two ratios."""
        sizes = Sizes(1.0, *(float(stored[name]) for name in self.stored))
        return self.model(sizes, math.nan, None)

    def solved(
        self, sizes: Sizes, cell: float, numerics: CellNumerics | None, say: Say
    ) -> dict[str, Any]:
        """Return the variables of the fiber, its thickness among them."""
        return {
            **super().solved(sizes, cell, numerics, say),
            "thickness_ratio": _thickness(sizes),
        }


def _thickness(sizes: Sizes) -> float:
    """Return length over thickness [-]."""
    return sizes.aspect_ratio if sizes.thickness_ratio is None else sizes.thickness_ratio


SHAPE = UnboundedEllipsoid()
