"""Steady orientation in a homogeneous flow by Newton-Raphson and continuation in the diffusion.

The paper's Eq. 27-28 with the exact Jacobian of Eq. 29. With much diffusion the steady state is
nearly isotropic and Newton finds it from there; the diffusion is then lowered to the one asked
for, each state predicted along the tangent of the branch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.orientation.flows import checked_gradient, shear_rate, strain_and_spin
from fibermelt.orientation.kinetics import ClosureLike, OrientationModel, checked_law
from fibermelt.orientation.tensors import (
    checked_orientation,
    isotropic,
    out_of_range,
    pack,
    preferred_angle,
    principal,
    unpack,
)

__all__ = ["SteadyState", "steady_state"]

Array = NDArray[np.float64]

RESIDUAL_TOLERANCE = 1e-12
"""Largest ``|a_dot|/gamma_dot`` of a steady state: a few hundred roundings of terms of order 1.
With a diffusion above one, times that: so large are its terms."""

ON_THE_WAY = 1e-6
"""The same for states that only predict the next."""

MOST_ITERATIONS = 10
"""Newton steps at one diffusion: quadratic from a good prediction, 3 or 4 are usual."""

FIRST_STRENGTH = 3.0
"""Diffusion over shear rate to start with: ``|a - I/3|`` is then below 0.03."""

FIRST_STEP, LARGEST_STEP, SMALLEST_STEP = math.log(3.0), math.log(10.0), 1e-3
"""Steps in the logarithm of the diffusion; below the last the branch has ended."""

LARGEST_CORRECTION, ALWAYS_FINE = 0.2, 1e-5
"""Correction of a prediction over the predicted change, and what is small anyway: a branch that
bends more within a step may have been left for another."""

CROSSING_STEP = 0.02
"""Largest step over which the number of growing changes may differ: a bifurcation, not a jump."""

EASY = 3
"""Newton steps up to which the next step in the diffusion is made longer."""

PHYSICAL_TOLERANCE = 1e-10
"""Eigenvalues outside [0, 1] by less are rounding and residual, not a closure's fault."""

NEUTRAL = 1e-9
"""Growth rates over ``gamma_dot`` up to this are neutral: a state with one is not stable."""


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A steady orientation tensor and what is known of it.

    Parameters
    ----------
    a : (3, 3) array
        The tensor [-].
    residual : float
        Largest component of ``|a_dot|/gamma_dot`` [-].
    iterations : int
        Newton steps at the diffusion asked for.
    continuation : int
        States on the way there, rejected predictions included.
    angle : float
        Preferred direction in the plane of 1 and 2 [rad] (the paper's Eq. 31).
    eigenvalues : (3,) array
        Of ``a``, descending.
    violation : float
        How far they leave [0, 1], 0 where they do not.
    is_physical : bool
        Whether they stay inside, rounding apart: no closure promises it.
    growth : (5,) array
        Real parts of the Jacobian's eigenvalues over ``gamma_dot`` [-], descending.
    is_stable : bool
        Whether every small change dies away.
    """

    a: Array
    residual: float
    iterations: int
    continuation: int
    angle: float
    eigenvalues: Array
    violation: float
    is_physical: bool
    growth: Array
    is_stable: bool


@dataclass(frozen=True, eq=False)
class _Point:
    """A state that Newton has reached: components, residual, steps, Jacobian over the rate."""

    v: Array
    residual: float
    iterations: int
    jacobian: Array


@dataclass(frozen=True, eq=False)
class _Problem:
    """One model, flow and closure; rates over ``gamma_dot``."""

    model: OrientationModel
    L: Array
    shear_rate: float
    closure: ClosureLike

    def newton(self, model: OrientationModel, v: Array, tolerance: float) -> _Point | None:
        """Return the root near ``v``, or None if `MOST_ITERATIONS` do not reach it."""
        for iteration in range(MOST_ITERATIONS + 1):
            a = unpack(v)
            try:
                rate = model.rate(a, self.L, self.closure) / self.shear_rate
                jacobian = model.jacobian(a, self.L, self.closure) / self.shear_rate
            except ConfigError:  # a closure that is defined for true tensors only
                return None
            residual = float(np.max(np.abs(rate)))
            if residual <= tolerance:
                return _Point(v, residual, iteration, jacobian)
            try:
                correction = _solved(jacobian, pack(rate))
            except np.linalg.LinAlgError:
                return None
            v = v - correction
            if not np.all(np.abs(v) <= 2.0):  # components of a tensor in range are within 1
                return None
        return None

    @property
    def tolerance(self) -> float:
        """Return the residual [-] at which a state is steady: the diffusion's terms round, too."""
        return RESIDUAL_TOLERANCE * max(1.0, self.model.strength)

    def tangent(self, model: OrientationModel, point: _Point) -> Array:
        """Return ``d v/d log(diffusion)``: the rate is linear in the diffusion."""
        a = unpack(point.v)
        doubled = model.scaled(2.0).rate(a, self.L, self.closure)
        once = model.rate(a, self.L, self.closure)
        return -_solved(point.jacobian, pack(doubled - once) / self.shear_rate)


def steady_state(
    model: OrientationModel, L: ArrayLike, closure: ClosureLike, start: ArrayLike | None = None
) -> SteadyState:
    """Return the steady orientation of a model with a closure in a homogeneous flow.

    Parameters
    ----------
    model : OrientationModel
        With diffusion, unless ``start`` is given: without it there may be no steady state, or many.
    L : (3, 3) or (2, 2) array_like
        Velocity gradient [1/s], without trace; a planar one is embedded.
    closure : ClosureLike
        What closes the fourth moment.
    start : (3, 3) array_like, optional
        Where Newton begins; by default continuation from nearly isotropic finds a start.

    Returns
    -------
    SteadyState
        With residual at most 1e-12, times the diffusion's strength if that is above one, found in
        at most 10 steps at the model's own diffusion. A state that fibers cannot have (eigenvalues
        outside [0, 1]) is returned and says so, as is one that is not stable.

    Raises
    ------
    ConfigError
        If nothing is strained, ``start`` is no orientation tensor, the model has no diffusion and
        there is no ``start``, or its diffusion is negative in this flow where there are no fibers.
    HistoryError
        If ``L`` has a trace or is not finite.
    ConvergenceError
        If the branch from isotropy ends before the diffusion asked for, or Newton fails from
        ``start``.

    Notes
    -----
    The retardation of RSC and ARD-RSC does not move the steady state: Newton solves without it,
    stability is told with it. pARD and MRD in flows with an axis have a steady state with
    coincident eigenvalues, where those laws jump: stability there is along changes that keep
    them together.
    """
    checked_law(model, closure)
    problem = _Problem(model.without_retardation(), *_checked_flow(L), closure)
    model.refuse_flow(strain_and_spin(problem.L)[0])
    if start is None:
        point, steps = _continued(problem)
    else:
        first = checked_orientation(start, "start")
        found = problem.newton(problem.model, pack(first), problem.tolerance)
        if found is None:
            msg = (
                f"steady state of {model.name} with closure {closure.name}, "
                f"C_I = {model.strength:.4g}: Newton does not reach {problem.tolerance:g} in "
                f"{MOST_ITERATIONS} steps from the start given: leave it out, or give a nearer one"
            )
            raise ConvergenceError(msg)
        point, steps = found, 0
    return _described(problem, model, point, steps)


def _checked_flow(L: ArrayLike) -> tuple[Array, float]:
    """Return a velocity gradient and its ``gamma_dot`` [1/s]; refuse one that strains nothing."""
    gradient = checked_gradient(L)
    if gradient.shape != (3, 3):
        msg = f"steady state: L has shape {gradient.shape}, expected one gradient (3, 3)"
        raise ConfigError(msg)
    rate = float(shear_rate(strain_and_spin(gradient)[0]))
    if rate == 0.0:
        msg = "steady state: L strains nothing, every orientation is steady: give a flow"
        raise ConfigError(msg)
    return gradient, rate


def _continued(problem: _Problem) -> tuple[_Point, int]:
    """Return the state on the branch that comes from isotropy, and the states it took."""
    target = problem.model
    if target.strength == 0.0:
        msg = (
            f"steady state: {target.name} has no diffusion, so none that all starts lead to: give "
            "start, or take a model with interaction"
        )
        raise ConfigError(msg)
    level = max(math.log(FIRST_STRENGTH / target.strength), 0.0)
    tolerance = problem.tolerance if level == 0.0 else ON_THE_WAY
    model = target.scaled(math.exp(level))
    point = problem.newton(model, pack(isotropic()), tolerance)
    if point is None:
        raise ConvergenceError(_no_branch(problem, model, pack(isotropic())))
    step, states = FIRST_STEP, 1
    while level > 0.0:
        lower = max(level - step, 0.0)
        guess = point.v + (lower - level) * problem.tangent(model, point)
        trial = target.scaled(math.exp(lower)) if lower > 0.0 else target
        found = problem.newton(trial, guess, ON_THE_WAY if lower > 0.0 else problem.tolerance)
        states += 1
        if found is None or _strays(found, point, guess, level - lower):
            step *= 0.5
            if step < SMALLEST_STEP:
                raise ConvergenceError(_no_branch(problem, model, point.v))
            continue
        if found.iterations <= EASY:
            step = min(1.5 * step, LARGEST_STEP)
        model, point, level = trial, found, lower
    return point, states


def _strays(found: _Point, before: _Point, guess: Array, step: float) -> bool:
    """Return whether a state may lie on another branch than the one before."""
    change = np.max(np.abs(unpack(guess) - unpack(before.v)))
    correction = np.max(np.abs(unpack(found.v) - unpack(guess)))
    if correction > LARGEST_CORRECTION * change + ALWAYS_FINE:
        return True
    return step > CROSSING_STEP and _growing(found) != _growing(before)


def _growing(point: _Point) -> int:
    """Return how many independent changes of a state grow."""
    return int(np.count_nonzero(np.linalg.eigvals(point.jacobian).real > 0.0))


def _solved(matrix: Array, right: Array) -> Array:
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)


def _described(
    problem: _Problem, model: OrientationModel, point: _Point, steps: int
) -> SteadyState:
    """Return the state with its eigenvalues and stability."""
    a = unpack(point.v)
    jacobian = point.jacobian
    if model.retardation != 1.0:
        jacobian = model.jacobian(a, problem.L, problem.closure) / problem.shear_rate
    growth = np.sort(np.linalg.eigvals(jacobian).real)[::-1]
    violation = float(out_of_range(a))
    return SteadyState(
        a=a,
        residual=point.residual,
        iterations=point.iterations,
        continuation=steps,
        angle=float(preferred_angle(a)),
        eigenvalues=principal(a)[0],
        violation=violation,
        is_physical=violation <= PHYSICAL_TOLERANCE,
        growth=growth,
        is_stable=bool(growth[0] < -NEUTRAL),
    )


def _no_branch(problem: _Problem, reached: OrientationModel, v: Array) -> str:
    model, values = problem.model, ", ".join(f"{x:.4g}" for x in principal(unpack(v))[0])
    return (
        f"steady state of {model.name} with closure {problem.closure.name}: the branch from "
        f"isotropy ends at C_I = {reached.strength:.4g} with eigenvalues {values}, before C_I = "
        f"{model.strength:.4g}: take more interaction or another closure, or give start"
    )
