"""The paper's fiber: an ellipse in its cell, solved by finite elements."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from fibermelt.parts.bead.shape import FiberShape, Sizes

if TYPE_CHECKING:
    from fibermelt.engine.stages import Say
    from fibermelt.fiber.cell_data import CellNumerics
    from fibermelt.fiber.models import FiberModel
    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw
    from fibermelt.parts.bead.shape import Arrays

__all__ = ["SHAPE"]


class ConfinedEllipse(FiberShape):
    """An ellipse in a circular cell of radius ``M a/2``."""

    name = "confined-ellipse"
    meaning = "an ellipse in its cell"
    label = "ellipse in its cell"
    plural = "ellipses in their cells"
    rank = 0
    has_cell = True
    stored = ("aspect_ratio", "shape_factor", "surface_angle", "surface_basis")

    def model(self, sizes: Sizes, cell: float, numerics: CellNumerics | None) -> FiberModel:
        """Return the fiber in a Newtonian melt."""
        from fibermelt.fiber.cell import solve_cell  # noqa: PLC0415  lazy: the finite elements
        from fibermelt.fiber.models import confined_model  # noqa: PLC0415
        from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

        fiber = Ellipse(sizes.half_length, sizes.aspect_ratio)
        return confined_model(solve_cell(fiber, cell, numerics).response)

    def restored(self, stored: Arrays) -> FiberModel:
        """Return the fiber from the numbers of its cell."""
        from fibermelt.fiber.models import confined_model  # noqa: PLC0415  lazy: see the module
        from fibermelt.fiber.response import FiberResponse  # noqa: PLC0415

        ratio, factor = (float(stored[name]) for name in ("aspect_ratio", "shape_factor"))
        surface, basis = stored["surface_angle"], stored["surface_basis"]
        return confined_model(FiberResponse(ratio, factor, surface, basis))

    def solved(
        self, sizes: Sizes, cell: float, numerics: CellNumerics | None, say: Say
    ) -> dict[str, Any]:
        """Return the variables of the cell."""
        from fibermelt.fiber.cell import solve_cell  # noqa: PLC0415  lazy: the finite elements
        from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

        solution = solve_cell(Ellipse(sizes.half_length, sizes.aspect_ratio), cell, numerics)
        say(f"{solution.unknowns} unknowns, shape factor {solution.shape_factor:.6f}")
        stall_angle, error = solution.stall_angle, solution.error_estimate
        return {
            "aspect_ratio": sizes.aspect_ratio,
            "domain_size": solution.domain_size,
            "shape_factor": solution.shape_factor,
            "stall_angle": math.nan if stall_angle is None else stall_angle,
            "tip_pressure": solution.tip_pressure,
            "shape_factor_error": math.nan if error is None else error.shape_factor,
            "tip_pressure_error": math.nan if error is None else error.tip_pressure,
            "cell_unknowns": solution.unknowns,
            "surface_angle": solution.response.surface,
            "surface_basis": solution.response.basis,
            "cell_point": solution.points,
            "cell_triangle": solution.cells,
            "cell_edge": solution.element_edges,
            "cell_velocity": solution.velocity,
            "cell_pressure": solution.pressure,
        }

    def thinning(
        self,
        sizes: Sizes,
        law: ViscosityLaw,
        cell: float,
        numerics: CellNumerics,
        rates: tuple[float, float] | None = None,
    ) -> ThinningResponse:
        """Return the fiber's table, of its cell."""
        from fibermelt.fiber.cell import solve_thinning  # noqa: PLC0415  lazy: the finite elements
        from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415

        fiber = Ellipse(sizes.half_length, sizes.aspect_ratio)
        return solve_thinning(fiber, cell, law, numerics, rates)


SHAPE = ConfinedEllipse()
