"""The paper's own algorithm: Newton-Raphson on the force and the torque on the fiber.

Section 2.2, Eq. 5-22. The cell turns with the fiber, so its matrix is factorised once. The far
field of the moment is put on the cell's edge (Eq. 5), the fiber is given a trial velocity (Eq. 8),
the free unknowns are solved for (Eq. 13), the nodal reactions (Eq. 14) are summed to force and
torque (Eq. 18), and the velocity is corrected by the Jacobian of Eq. 19-22 until they vanish
(Eq. 15). What follows fibers by it is in `fibermelt.fiber.newton_motion`.

For a Newtonian melt it must agree with superposition to solver precision at thousands of times
the cost; it is kept as the reference, and as the way that a melt with another law will need.
Eq. 5 and 6 as printed rotate by the transpose; here local components are
``(u.e_x', u.e_y')`` with ``e_x' = (cos theta, sin theta)`` along the fiber. Velocities are taken
relative to the melt's at the fiber's centre (Stokes flow knows no frame at rest): ``|u|/a`` is
thousands of times ``|L|``, and would cost as many digits of the pressure.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConvergenceError
from fibermelt.fiber.cell_data import CellSystem

__all__ = ["FreeFiber", "NewtonSolver", "Rates"]

Array = NDArray[np.float64]

BALANCE_TOLERANCE = 1e-11
"""Force and torque over what the velocities at hand would cause: solver precision, as no
iteration on a linear problem can do better."""

MOST_ITERATIONS = 8
"""A linear problem takes one correction; more say that the solver has lost its digits."""

Rates = tuple[Array, Array]
"""The fiber's velocity and spin, and the cell's unknowns that go with them."""


class FreeFiber(Protocol):
    """A fiber that force and torque are balanced on at every step, in whichever melt."""

    solves: int
    """Linear solves so far."""
    iterations: int
    """Corrections by Newton-Raphson so far."""
    aspect_ratio: float
    """``r_e`` [-]."""
    surface: Array
    """Eccentric angles of the surface points [rad], (m,), the tip first."""

    @property
    def unknowns(self) -> int:
        """Return the number of unknowns of a solve."""

    def motion(self, half_length: float, melt: Array, angle: float, guess: Array) -> Rates:
        """Return velocity [m/s] and spin [1/s] in the axes of the flow, and the cell's unknowns.

        Parameters
        ----------
        half_length : float
            ``a`` [m]: it scales the fiber's velocity relative to the melt.
        melt : (6,) array
            Velocity [m/s] and velocity gradient row by row [1/s] of the melt at its centre.
        angle : float
            The fiber's angle from the x axis [rad].
        guess : (3,) array
            Trial velocity [m/s] and spin [1/s] to start from: the last step's.

        Raises
        ------
        ConvergenceError
            If force and torque do not vanish.
        """

    def surface_pressure(self, unknowns: Array) -> Array:
        """Return the pressure at the surface points over the viscosity of `follow_newton`, (m,)."""


class NewtonSolver:
    """Force- and torque-free velocity of the fiber in its cell for a given far field.

    Parameters
    ----------
    system : CellSystem
        The cell's matrix with its partition; unit viscosity, lengths over ``a``.
    """

    def __init__(self, system: CellSystem) -> None:
        self.system = system
        self.aspect_ratio, self.surface = system.response.aspect_ratio, system.response.surface
        free, edge, fiber = system.free, system.edge, system.fiber
        rows = system.matrix[free]
        self._free_edge, self._free_fiber = rows[:, edge], rows[:, fiber]
        self._reaction_rows = system.matrix[fiber]
        self.solves = 0
        self.iterations = 0
        self._jacobian = self._build_jacobian()

    def _build_jacobian(self) -> Array:
        """Return ``dR/dX_dot`` (Eq. 19, 22): constant, as the matrix is."""
        modes = self.system.fiber_modes
        none = np.zeros(self.system.edge_modes.shape[1])
        columns = [self._reaction(none, unit)[0] for unit in np.eye(modes.shape[1])]
        return np.stack(columns, axis=-1)

    def _reaction(self, far_field: Array, rates: Array) -> tuple[Array, Array]:
        """Return force and torque on the fiber (Eq. 18) and all unknowns (Eq. 13, 14)."""
        system = self.system
        unknowns = np.zeros(system.matrix.shape[0])
        unknowns[system.edge] = system.edge_modes @ far_field
        unknowns[system.fiber] = system.fiber_modes @ rates
        load = self._free_edge @ unknowns[system.edge] + self._free_fiber @ unknowns[system.fiber]
        unknowns[system.free] = system.solve(-load)
        self.solves += 1
        balance: Array = -(system.fiber_modes.T @ (self._reaction_rows @ unknowns))
        return balance, unknowns

    def solve(self, far_field: Array, guess: Array) -> Rates:
        """Return the fiber's velocity and the flow at which force and torque vanish (Eq. 15).

        Parameters
        ----------
        far_field : (6,) array
            Velocity over ``a`` and gradient row by row, in the fiber's axes [1/s].
        guess : (3,) array
            Trial velocity over ``a`` and spin, in the fiber's axes [1/s].

        Raises
        ------
        ConvergenceError
            If force and torque do not vanish within `MOST_ITERATIONS` corrections.
        """
        rates = guess.copy()
        size = np.linalg.norm(self._jacobian) * np.linalg.norm(far_field)
        for _ in range(MOST_ITERATIONS):
            balance, unknowns = self._reaction(far_field, rates)
            if np.linalg.norm(balance) <= BALANCE_TOLERANCE * size:
                return rates, unknowns
            rates = rates - np.linalg.solve(self._jacobian, balance)
            self.iterations += 1
        msg = (
            f"fiber force balance: |R| = {np.linalg.norm(balance):.1e} after {MOST_ITERATIONS} "
            f"corrections, bound {BALANCE_TOLERANCE * size:.1e}: use a lower order in the cell"
        )
        raise ConvergenceError(msg)

    @property
    def unknowns(self) -> int:
        """Return the number of unknowns of a solve."""
        return int(self.system.free.size)

    def motion(self, half_length: float, melt: Array, angle: float, guess: Array) -> Rates:
        """Return how the fiber moves in the axes of the flow, from a solve in its own (Eq. 16, 17).

        As `FreeFiber.motion` says.
        """
        c, s = np.cos(angle), np.sin(angle)
        to_local = np.array([[c, s], [-s, c]])
        gradient = to_local @ melt[2:].reshape(2, 2) @ to_local.T
        far_field = np.concatenate([np.zeros(2), gradient.ravel()])
        trial = np.array([*(to_local @ (guess[:2] - melt[:2]) / half_length), guess[2]])
        local, unknowns = self.solve(far_field, trial)
        velocity = melt[:2] + half_length * (to_local.T @ local[:2])
        return np.array([*velocity, local[2]]), unknowns

    def surface_pressure(self, unknowns: Array) -> Array:
        """Return the pressure at the surface points over ``mu``, level as the system's [1/s]."""
        level = float(self.system.pressure_level @ unknowns)
        pressure: Array = self.system.surface_pressure @ unknowns - level
        return pressure
