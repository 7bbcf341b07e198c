"""A prolate spheroid in a melt without end: in closed form, or by a table where it thins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.parts.bead.shape import FiberShape, Sizes

if TYPE_CHECKING:
    from fibermelt.fiber.cell_data import CellNumerics
    from fibermelt.fiber.models import FiberModel
    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw

__all__ = ["SHAPE"]


class UnboundedSpheroid(FiberShape):
    """A spheroid; its table is in three dimensions and for a local index, errors as told there."""

    name = "spheroid"
    meaning = "a spheroid without a cell"
    label = "spheroid, unbounded"
    plural = "unbounded spheroids"
    rank = 2
    in_space = True
    table_bounds = (0.2, 0.2)

    def model(self, sizes: Sizes, cell: float, numerics: CellNumerics | None) -> FiberModel:
        """Return the fiber in a Newtonian melt."""
        from fibermelt.fiber.models import unbounded_model  # noqa: PLC0415  lazy: see the module
        from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

        return unbounded_model("spheroid", Ellipse(sizes.half_length, sizes.aspect_ratio))

    def thinning(
        self,
        sizes: Sizes,
        law: ViscosityLaw,
        cell: float,
        numerics: CellNumerics,
        rates: tuple[float, float] | None = None,
    ) -> ThinningResponse:
        """Return the fiber's table, which is shipped."""
        from fibermelt.fiber.spheroid import Spheroid  # noqa: PLC0415  lazy: see the module
        from fibermelt.fiber.thinning_spheroid import unbounded_thinning_spheroid  # noqa: PLC0415

        spheroid = Spheroid(sizes.half_length, sizes.aspect_ratio)
        return unbounded_thinning_spheroid(spheroid, law, rates)

    def refuse_in_melt(self, sizes: Sizes, law: ViscosityLaw) -> None:
        """Refuse aspect ratios and indices beyond the table."""
        from fibermelt.fiber.spheroid import Spheroid  # noqa: PLC0415  lazy: see the module
        from fibermelt.fiber.thinning_spheroid import unbounded_thinning_spheroid  # noqa: PLC0415

        unbounded_thinning_spheroid(Spheroid(1.0, sizes.aspect_ratio), law)


SHAPE = UnboundedSpheroid()
