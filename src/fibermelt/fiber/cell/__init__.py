"""The confined fiber: Stokes flow between an ellipse and the circle around it (NGSolve).

The paper's micro-model (section 2.2, Fig. 5): no slip on the fiber, far field ``u = D x`` on the
circle of radius ``R = M a/2`` in the fiber's axes (Eq. 5 without rotation and translation, which
do nothing to the pressure), rigid and torque-free fiber. Curved quadrilaterals, or the paper's own
triangles, velocity of order k, continuous pressure of order k - 1 (Taylor and Hood), interior
unknowns condensed.

This package is the only place of the fiber's side that loads the finite elements; what it returns
(`fibermelt.fiber.cell_data`) does without them.
"""

from fibermelt.fiber.cell.free import ThinningFiber
from fibermelt.fiber.cell.solve import solve_cell
from fibermelt.fiber.cell.spheroid import solve_thinning_spheroid
from fibermelt.fiber.cell.system import build_system
from fibermelt.fiber.cell.table import solve_thinning
from fibermelt.fiber.cell.thinning import thinning_flow_around, thinning_surroundings

__all__ = [
    "ThinningFiber",
    "build_system",
    "solve_cell",
    "solve_thinning",
    "solve_thinning_spheroid",
    "thinning_flow_around",
    "thinning_surroundings",
]
