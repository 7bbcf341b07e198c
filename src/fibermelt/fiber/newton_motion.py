"""A fiber followed along its history by the paper's own algorithm (section 2.2).

A force and torque balance (`fibermelt.fiber.newton`) at every stage of the classical fourth-order
Runge-Kutta step for angle and position. What comes out answers to the same names as `Motion` and
`SurfacePressure` do, so that `extremes` and `angle_to_stream` take either path; but the extremes
over the surface are those of its points, as in the paper, and nothing is continuous.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import Unchanging, real_array
from fibermelt.errors import ConfigError
from fibermelt.fiber.cell_data import CellSystem
from fibermelt.fiber.checks import checked_positive
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.motion import checked_angles
from fibermelt.fiber.newton import FreeFiber, NewtonSolver, Rates
from fibermelt.fiber.paths import checked_path
from fibermelt.fiber.shape import Ellipse
from fibermelt.history import FlowHistory
from fibermelt.interpolation import PathInterpolant

__all__ = ["NewtonMotion", "follow_newton", "runge_kutta_step"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NewtonMotion(Unchanging):
    """Fibers followed by the paper's algorithm: their motion, and the pressure on their surface.

    Pressures are relative to the streamline's [Pa]; extremes are over the surface points.

    Parameters
    ----------
    time : (n,) array
        Times of the steps [s].
    initial_angles : (n_angles,) array
        Angles at the start [rad] from the x axis.
    angle, spin : (n_angles, n) array
        Angle [rad], continuous in time, and its rate [1/s].
    position, velocity : (n_angles, n, 2) array
        The fiber's centre [m] and its velocity [m/s].
    surface : (m,) array
        Eccentric angles of the surface points [rad].
    surface_pressure : (n_angles, n, m) array
        Pressure there.
    iterations : int
        Newton-Raphson corrections in all.
    solves : int
        Linear solves in all.
    path : FlowHistory
        What the fibers were followed along.
    """

    time: Array
    initial_angles: Array
    angle: Array
    spin: Array
    position: Array
    velocity: Array
    surface: Array
    surface_pressure: Array
    iterations: int
    solves: int
    path: FlowHistory = field(repr=False)

    @cached_property
    def lowest(self) -> Array:
        """Return the lowest pressure over the surface points [Pa], (n_angles, n)."""
        return np.asarray(self.surface_pressure.min(axis=-1))

    @cached_property
    def highest(self) -> Array:
        """Return the highest pressure over the surface points [Pa], (n_angles, n)."""
        return np.asarray(self.surface_pressure.max(axis=-1))

    @property
    def tip(self) -> Array:
        """Return the pressure at the fiber's tip [Pa], (n_angles, n)."""
        return np.asarray(self.surface_pressure[..., 0])

    @cached_property
    def where_lowest(self) -> Array:
        """Return the eccentric angle of the lowest pressure [rad] in (-pi/2, pi/2], 0 the tip."""
        return fold_angle(self.surface[np.argmin(self.surface_pressure, axis=-1)])

    @cached_property
    def where_highest(self) -> Array:
        """Return the eccentric angle of the highest pressure [rad] in (-pi/2, pi/2], 0 the tip."""
        return fold_angle(self.surface[np.argmax(self.surface_pressure, axis=-1)])

    def where_at(self, index: NDArray[np.intp]) -> Array:
        """Return the eccentric angles [rad] of the extremes at given points of the path.

        Parameters
        ----------
        index : (n_angles, ..., 2) integer array
            Points of the path, last axis: for the lowest, for the highest.
        """
        flat = index.reshape(*index.shape[:1], -1, 2)
        low = np.take_along_axis(self.where_lowest, flat[..., 0], axis=-1)
        high = np.take_along_axis(self.where_highest, flat[..., 1], axis=-1)
        return np.stack([low, high], axis=-1).reshape(index.shape)


def follow_newton(
    system: CellSystem | FreeFiber,
    fiber: Ellipse,
    history: FlowHistory,
    viscosity: float,
    initial_angles: ArrayLike,
) -> NewtonMotion:
    """Follow fibers along a history by the paper's algorithm, one step per interval.

    Parameters
    ----------
    system : CellSystem or FreeFiber
        The cell of `build_system`; of a melt that thins, `fibermelt.fiber.cell.ThinningFiber`.
    fiber : Ellipse
        The fiber that it was built for (its half-length scales the translation).
    history : FlowHistory
        The path; each of its intervals is one Runge-Kutta step, so its points set the accuracy.
    viscosity : float
        ``mu`` [Pa s]; of a melt that thins the unit of its law's stresses, 1.
    initial_angles : float or (n_angles,) array
        Angles from the x axis at the start [rad]; each takes the whole cost again, four to eight
        linear solves a step.

    Raises
    ------
    ConfigError
        If the fiber's aspect ratio is not the system's, the history is none, or a viscosity or an
        angle is not usable.
    ConvergenceError
        If a force balance fails.
    """
    solver = NewtonSolver(system) if isinstance(system, CellSystem) else system
    _refuse_another_fiber(solver.aspect_ratio, fiber)
    checked_path(history)
    viscosity = checked_positive("melt.viscosity", viscosity, "Pa s", "817")
    angles = checked_angles(np.atleast_1d(real_array("initial_angles", initial_angles)))
    runs = [_follow_one(solver, fiber, history, float(angle)) for angle in angles]
    states, rates, pressures = (np.stack(parts) for parts in zip(*runs, strict=True))
    return NewtonMotion(
        time=history.time,
        initial_angles=angles,
        angle=states[..., 2],
        spin=rates[..., 2],
        position=states[..., :2],
        velocity=rates[..., :2],
        surface=solver.surface,
        surface_pressure=viscosity * pressures,
        iterations=solver.iterations,
        solves=solver.solves,
        path=history,
    )


def _follow_one(
    solver: FreeFiber, fiber: Ellipse, history: FlowHistory, angle: float
) -> tuple[Array, Array, Array]:
    """Return position and angle, their rates, and the surface pressure over mu at every step."""
    n = len(history)
    melt = PathInterpolant(
        history.time,
        np.concatenate([history.velocity[:, :2], history.plane_gradient.reshape(n, 4)], axis=1),
    )

    def rate(interval: int, fraction: float, at: Array, guess: Array) -> Rates:
        values = melt((interval,), fraction)
        return solver.motion(fiber.half_length, values, float(at[2]), guess)

    state = np.array([*history.position[0, :2], angle])
    guess = np.array([*history.velocity[0, :2], 0.0])
    states, rates, pressures = np.empty((n, 3)), np.empty((n, 3)), []
    for i in range(n):
        states[i] = state
        rates[i], unknowns = rate(min(i, n - 2), float(i == n - 1), state, guess)
        pressures.append(solver.surface_pressure(unknowns))
        guess = rates[i]
        if i < n - 1:
            step = float(history.time[i + 1] - history.time[i])
            state = runge_kutta_step(partial(rate, i), state, guess, step)
    return states, rates, np.array(pressures)


def runge_kutta_step(
    rate: Callable[[float, Array, Array], Rates], state: Array, first: Array, step: float
) -> Array:
    """Return the state after one classical fourth-order Runge-Kutta step.

    Parameters
    ----------
    rate
        Rates at a fraction of the step [0, 1] and a state, from a guess (the last stage's rates).
    state, first : (k,) array
        State at the start and its rate.
    step : float
        Length of the step [s].
    """
    second, _ = rate(0.5, state + 0.5 * step * first, first)
    third, _ = rate(0.5, state + 0.5 * step * second, second)
    fourth, _ = rate(1.0, state + step * third, third)
    new: Array = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return new


def _refuse_another_fiber(aspect_ratio: float, fiber: Ellipse) -> None:
    """Refuse a fiber that the cell was not built for (`ConfigError`)."""
    if fiber.aspect_ratio != aspect_ratio:
        msg = (
            f"fiber.aspect_ratio = {fiber.aspect_ratio:g}, but the cell was built for "
            f"{aspect_ratio:g}: build the system again"
        )
        raise ConfigError(msg)
