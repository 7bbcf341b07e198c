"""The paper's own algorithm: Newton-Raphson on force and torque at every Runge-Kutta stage.

Section 2.2, Eq. 5-22. The cell turns with the fiber, so its matrix is factorised once. At each
stage the far field of the moment is put on the cell's edge (Eq. 5), the fiber is given a trial
velocity (Eq. 8), the free unknowns are solved for (Eq. 13), the nodal reactions (Eq. 14) are summed
to force and torque (Eq. 18), and the velocity is corrected by the Jacobian of Eq. 19-22 until they
vanish (Eq. 15). Angle and position then go on by the classical fourth-order Runge-Kutta step.

For a Newtonian melt it must agree with superposition to solver precision at thousands of times
the cost; it is kept as the reference, and as the way that a melt with another law will need.
Eq. 5 and 6 as printed rotate by the transpose; here local components are
``(u.e_x', u.e_y')`` with ``e_x' = (cos theta, sin theta)`` along the fiber. Velocities are taken
relative to the melt's at the fiber's centre (Stokes flow knows no frame at rest): ``|u|/a`` is
thousands of times ``|L|``, and would cost as many digits of the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber.cell_data import CellSystem
from fibermelt.fiber.magnus import PathInterpolant
from fibermelt.fiber.shape import Ellipse
from fibermelt.history import FlowHistory

__all__ = ["NewtonMotion", "NewtonSolver", "follow_newton"]

Array = NDArray[np.float64]

BALANCE_TOLERANCE = 1e-11
"""Force and torque over what the velocities at hand would cause: solver precision, as no
iteration on a linear problem can do better."""

MOST_ITERATIONS = 8
"""A linear problem takes one correction; more say that the solver has lost its digits."""

Rates = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class NewtonMotion:
    """A fiber followed by the paper's algorithm.

    Parameters
    ----------
    time : (n,) array
        Times of the steps [s].
    angle, spin : (n,) array
        Angle [rad] and its rate [1/s].
    position, velocity : (n, 2) array
        The fiber's centre [m] and its velocity [m/s].
    surface_pressure : (n, m) array
        Pressure at the surface points, relative to the streamline's [Pa].
    lowest, highest : (n,) array
        Its extremes over these points [Pa].
    iterations : int
        Newton-Raphson corrections in all.
    solves : int
        Linear solves in all.
    """

    time: Array
    angle: Array
    spin: Array
    position: Array
    velocity: Array
    surface_pressure: Array
    lowest: Array
    highest: Array
    iterations: int
    solves: int


class NewtonSolver:
    """Force- and torque-free velocity of the fiber in its cell for a given far field.

    Parameters
    ----------
    system : CellSystem
        The cell's matrix with its partition; unit viscosity, lengths over ``a``.
    """

    def __init__(self, system: CellSystem) -> None:
        self.system = system
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

    def surface_pressure(self, unknowns: Array) -> Array:
        """Return the pressure at the surface points over ``mu``, level as the system's [1/s]."""
        level = float(self.system.pressure_level @ unknowns)
        pressure: Array = self.system.surface_pressure @ unknowns - level
        return pressure


def follow_newton(
    system: CellSystem,
    fiber: Ellipse,
    history: FlowHistory,
    viscosity: float,
    initial_angle: float,
) -> NewtonMotion:
    """Follow one fiber along its history by the paper's algorithm, one step per interval.

    Parameters
    ----------
    system : CellSystem
        The cell of `build_system`.
    fiber : Ellipse
        The fiber that it was built for (its half-length scales the translation).
    history : FlowHistory
        The path; each of its intervals is one Runge-Kutta step, so its points set the accuracy.
    viscosity : float
        ``mu`` [Pa s].
    initial_angle : float
        Angle from the x axis at the start [rad].

    Raises
    ------
    ConfigError
        If the fiber's aspect ratio is not the system's.
    ConvergenceError
        If a force balance fails.
    """
    if fiber.aspect_ratio != system.response.aspect_ratio:
        msg = (
            f"fiber.aspect_ratio = {fiber.aspect_ratio:g}, but the cell was built for "
            f"{system.response.aspect_ratio:g}: build the system again"
        )
        raise ConfigError(msg)
    solver = NewtonSolver(system)
    n = len(history)
    melt = PathInterpolant(
        history.time, np.concatenate([history.velocity, history.gradient.reshape(n, 4)], axis=1)
    )
    state = np.array([*history.position[0], initial_angle])
    states, rates, pressures = np.empty((n, 3)), np.empty((n, 3)), []
    guess = np.array([*history.velocity[0], 0.0])

    def rate(interval: int, fraction: float, at: Array) -> Rates:
        values = melt((interval,), fraction)
        return _rates(solver, fiber, values, float(at[2]), guess)

    for i in range(n):
        interval, start = min(i, n - 2), float(i == n - 1)
        first, unknowns = rate(interval, start, state)
        states[i], rates[i] = state, first
        pressures.append(viscosity * solver.surface_pressure(unknowns))
        guess = first
        if i == n - 1:
            break
        h = history.time[i + 1] - history.time[i]
        second, _ = rate(i, 0.5, state + 0.5 * h * first)
        third, _ = rate(i, 0.5, state + 0.5 * h * second)
        fourth, _ = rate(i, 1.0, state + h * third)
        state = state + h / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    surface = np.array(pressures)
    return NewtonMotion(
        time=history.time,
        angle=states[:, 2],
        spin=rates[:, 2],
        position=states[:, :2],
        velocity=rates[:, :2],
        surface_pressure=surface,
        lowest=surface.min(axis=1),
        highest=surface.max(axis=1),
        iterations=solver.iterations,
        solves=solver.solves,
    )


def _rates(solver: NewtonSolver, fiber: Ellipse, melt: Array, angle: float, guess: Array) -> Rates:
    """Return velocity and spin in the axes of the flow, from a solve in the fiber's axes."""
    a = fiber.half_length
    c, s = np.cos(angle), np.sin(angle)
    to_local = np.array([[c, s], [-s, c]])
    gradient = to_local @ melt[2:].reshape(2, 2) @ to_local.T
    far_field = np.concatenate([np.zeros(2), gradient.ravel()])
    trial = np.array([*(to_local @ (guess[:2] - melt[:2]) / a), guess[2]])
    local, unknowns = solver.solve(far_field, trial)
    return np.array([*(melt[:2] + a * (to_local.T @ local[:2])), local[2]]), unknowns
