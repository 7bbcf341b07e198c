"""A confined fiber in a melt that thins, balanced at every step as the paper's algorithm does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.cell.table import surface_nodes
from fibermelt.fiber.cell.thinning import THINNING_NUMERICS, ThinningCell
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.paths import strain_polar
from fibermelt.fiber.shape import Ellipse
from fibermelt.melt import ViscosityLaw
from fibermelt.threads import exclusive

if TYPE_CHECKING:
    from fibermelt.fiber.newton import Rates

__all__ = ["ThinningFiber"]

Array = NDArray[np.float64]


class ThinningFiber:
    """A fiber that `fibermelt.fiber.follow_newton` follows through a melt that thins.

    Its cell is solved by Newton's method at every stage of every step, the spin an unknown like
    the flow; pressures come in Pa, so that the viscosity to follow with is 1. Centred in its cell
    the fiber moves with the melt. A table (`solve_thinning`) must agree, at a thousandth of the
    cost.

    Parameters
    ----------
    fiber, domain_size, law, numerics
        As in `solve_thinning`.

    Raises
    ------
    ConfigError
        If the fiber does not fit into its cell.
    """

    @exclusive
    def __init__(
        self,
        fiber: Ellipse,
        domain_size: float,
        law: ViscosityLaw,
        numerics: CellNumerics = THINNING_NUMERICS,
    ) -> None:
        self._cell = ThinningCell(fiber, domain_size, law, numerics)
        self.aspect_ratio = fiber.aspect_ratio
        self.surface = surface_nodes(self._cell.grid, numerics.order)
        self.solves = self.iterations = 0

    @property
    def unknowns(self) -> int:
        """Return the number of velocity and pressure unknowns."""
        return self._cell.unknowns

    @exclusive
    def motion(self, half_length: float, melt: Array, angle: float, guess: Array) -> Rates:
        """Return velocity and spin, and the surface pressure [Pa], as `FreeFiber.motion` says."""
        del half_length, guess  # each solve starts from the one before
        gradient = melt[2:].reshape(2, 2)
        size, double = strain_polar(gradient)
        answer = self._cell.answer(2.0 * float(size), float(double) - 2.0 * angle)
        self.solves += answer.steps
        self.iterations += answer.steps
        spin = 0.5 * (gradient[1, 0] - gradient[0, 1]) + float(size) * answer.spin
        stress = float(self._cell.law.viscosity_at(2.0 * size)) * float(size)
        return np.array([melt[0], melt[1], spin]), stress * answer.pressure

    def surface_pressure(self, unknowns: Array) -> Array:
        """Return the pressure at the surface points [Pa]: the unknowns of `motion` are these."""
        return unknowns
