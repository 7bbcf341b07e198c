"""An ellipse in a melt without end, in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.parts.bead.shape import FiberShape, Sizes

if TYPE_CHECKING:
    from fibermelt.fiber.cell_data import CellNumerics
    from fibermelt.fiber.models import FiberModel
    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw

__all__ = ["SHAPE"]


class UnboundedEllipse(FiberShape):
    """An ellipse; in a melt that thins, in a cell so large that it is hardly felt."""

    name = "ellipse"
    meaning = "an ellipse without a cell"
    label = "ellipse, unbounded"
    plural = "unbounded ellipses"
    rank = 1

    def model(self, sizes: Sizes, cell: float, numerics: CellNumerics | None) -> FiberModel:
        """Return the fiber in a Newtonian melt."""
        from fibermelt.fiber.models import unbounded_model  # noqa: PLC0415  lazy: see the module
        from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

        return unbounded_model("ellipse", Ellipse(sizes.half_length, sizes.aspect_ratio))

    def thinning(
        self,
        sizes: Sizes,
        law: ViscosityLaw,
        cell: float,
        numerics: CellNumerics,
        rates: tuple[float, float] | None = None,
    ) -> ThinningResponse:
        """Return the fiber's table, of a large cell."""
        from fibermelt.fiber.cell import solve_thinning  # noqa: PLC0415  lazy: the finite elements
        from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415
        from fibermelt.fiber.thinning import UNBOUNDED_SIZE  # noqa: PLC0415

        fiber = Ellipse(sizes.half_length, sizes.aspect_ratio)
        return solve_thinning(fiber, UNBOUNDED_SIZE, law, numerics, rates)


SHAPE = UnboundedEllipse()
