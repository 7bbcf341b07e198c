"""One turn of a fiber in simple shear by the paper's own algorithm (its Fig. 8, 9 and Table 1)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from fibermelt.errors import ConvergenceError, refuse_no_count
from fibermelt.fiber.cell_data import CellSystem
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.jeffery import jeffery_period
from fibermelt.fiber.newton import FreeFiber, NewtonSolver, Rates
from fibermelt.fiber.newton_motion import runge_kutta_step
from fibermelt.fiber.orbit import Orbit, checked_shear

__all__ = ["orbit_newton"]

Array = NDArray[np.float64]

FEWEST_STEPS = 16
"""Steps in a turn below which the flip across the flow falls between two of them."""

LONGEST_TURN = 50
"""Periods of the unbounded fiber after which a turn is given up: ``B`` is then above 0.99998."""

ANGLE_TOLERANCE = 1e-12
"""Of the stall angle, and of the slowest orientation as far as its flat top allows [rad]."""


class _Shear:
    """The balanced fiber in the simple shear ``u_x = gamma_dot y``."""

    def __init__(self, free: FreeFiber, shear_rate: float) -> None:
        self.solver = free
        self.melt = np.array([0.0, 0.0, 0.0, shear_rate, 0.0, 0.0])

    def rate(self, fraction: float, state: Array, guess: Array) -> Rates:
        """Return velocity over ``a`` and spin, and the flow; the same at any ``fraction``."""
        del fraction  # the flow is steady
        return self.solver.motion(1.0, self.melt, float(state[2]), guess)

    def spin(self, angle: float) -> float:
        """Return the spin at an angle [1/s]."""
        return float(self.rate(0.0, np.array([0.0, 0.0, angle]), np.zeros(3))[0][2])


def orbit_newton(
    system: CellSystem | FreeFiber,
    shear_rate: float,
    viscosity: float,
    angle: float = 0.0,
    steps: int = 400,
) -> Orbit:
    """Return a fiber's orbit in simple shear as the paper's algorithm finds it.

    Whether it stalls is seen from its spin at the slowest orientation. A fiber that tumbles is
    followed in time until it has turned once, and its last step is cut by the cubic of the angle
    and its rate. One that stalls never turns: it is put at ``steps`` angles over half a turn.

    Parameters
    ----------
    system : CellSystem or FreeFiber
        The cell of `build_system`; of a melt that thins, `fibermelt.fiber.cell.ThinningFiber`.
    shear_rate : float
        ``gamma_dot`` [1/s] of ``u_x = gamma_dot y``, positive.
    viscosity : float
        ``mu`` [Pa s], positive; 1 in a melt that thins.
    angle : float
        Angle from the flow direction at the start [rad].
    steps : int
        Runge-Kutta steps in the period of the same fiber unbounded, or angles in half a turn. The
        extremes are those of the steps and of the surface points: both errors are of second order.

    Returns
    -------
    Orbit
        ``shape_factor`` from the spins along and across the flow.

    Raises
    ------
    ConfigError
        If the shear rate or the viscosity is not positive, the angle not finite, or the steps
        fewer than 16.
    ConvergenceError
        If a force balance fails, or the fiber has not turned after 50 periods of the unbounded
        one.
    """
    shear_rate, viscosity, angle = checked_shear(shear_rate, viscosity, angle)
    refuse_no_count("steps", steps, FEWEST_STEPS, "with fewer an orbit's peaks are missed")
    free = NewtonSolver(system) if isinstance(system, CellSystem) else system
    shear = _Shear(free, shear_rate)
    unbounded = jeffery_period(free.aspect_ratio, shear_rate)
    stall_angle = _stall_angle(shear)
    period = None
    if stall_angle is None:
        period, angles, pressure = _one_turn(shear, angle, unbounded / steps, LONGEST_TURN * steps)
    else:
        angles, pressure = _half_turn(shear, angle, steps)
    pressure *= viscosity
    spins = shear.spin(0.0), shear.spin(0.5 * math.pi)
    return Orbit(
        period=period,
        period_jeffery=unbounded,
        shape_factor=(spins[0] - spins[1]) / shear_rate,
        stalls=stall_angle is not None,
        stall_angle=stall_angle,
        **_extremes(free.surface, angles, pressure),
        steps=angles.size,
        solves=shear.solver.solves,
    )


def _extremes(surface: Array, angles: Array, pressure: Array) -> dict[str, float]:
    """Return the extremes of an `Orbit` by name, from angles (n,) and surface pressures (n, m)."""
    at, where = np.unravel_index(int(np.argmin(pressure)), pressure.shape)
    return {
        "max_pressure": float(pressure.max()),
        "min_pressure": float(pressure.min()),
        "tip_max": float(pressure[:, 0].max()),
        "tip_min": float(pressure[:, 0].min()),
        "angle_at_min": float(fold_angle(angles[at])),
        "where_at_min": float(fold_angle(surface[where])),
    }


def _stall_angle(shear: _Shear) -> float | None:
    """Return the angle [rad] to which the fiber is drawn, None if its spin never vanishes."""
    quarter = 0.25 * math.pi
    slowest = minimize_scalar(
        lambda at: -shear.spin(at),
        bounds=(-quarter, quarter),
        method="bounded",
        options={"xatol": ANGLE_TOLERANCE},
    )
    if slowest.fun > 0.0:
        return None
    top = float(slowest.x)
    return float(brentq(shear.spin, top, top + 2.0 * quarter, xtol=ANGLE_TOLERANCE))


def _pressure(shear: _Shear, angle: float) -> Array:
    """Return the surface pressure over mu at an angle [1/s], (m,)."""
    _, unknowns = shear.rate(0.0, np.array([0.0, 0.0, angle]), np.zeros(3))
    return shear.solver.surface_pressure(unknowns)


def _half_turn(shear: _Shear, start: float, steps: int) -> tuple[Array, Array]:
    """Return angles over half a turn [rad], and the surface pressure over mu at each, (n, m)."""
    angles = start - math.pi * np.arange(steps) / steps
    return angles, np.array([_pressure(shear, float(at)) for at in angles])


def _one_turn(
    shear: _Shear, start: float, step: float, most_steps: int
) -> tuple[float, Array, Array]:
    """Return the period [s], and angle [rad] and surface pressure over mu at every step of it."""
    state = np.array([0.0, 0.0, start])
    rates, unknowns = shear.rate(0.0, state, np.zeros(3))
    angles, pressures = [], []
    for taken in range(most_steps):
        angles.append(float(state[2]))
        pressures.append(shear.solver.surface_pressure(unknowns))
        new = runge_kutta_step(shear.rate, state, rates, step)
        new_rates, unknowns = shear.rate(0.0, new, rates)
        left = start - 2.0 * math.pi - angles[-1]
        if new[2] - angles[-1] <= left:
            part = _part_of_step(new[2] - angles[-1], step * rates[2], step * new_rates[2], left)
            return (taken + part) * step, np.array(angles), np.array(pressures)
        state, rates = new, new_rates
    msg = (
        f"fiber orbit: turned by {start - angles[-1]:.3g} rad after {LONGEST_TURN} periods of the "
        "unbounded fiber: its shape factor is too close to one, take another domain_size"
    )
    raise ConvergenceError(msg)


def _part_of_step(rise: float, first: float, last: float, goal: float) -> float:
    """Return the fraction of a step at which the cubic of an angle and its rates meets ``goal``."""
    bend, twist = 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise
    return float(brentq(lambda u: u * (first + u * (bend + u * twist)) - goal, 0.0, 1.0))
