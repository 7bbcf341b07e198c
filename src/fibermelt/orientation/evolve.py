"""Orientation along flow histories: all of them and all initial tensors at once.

Dormand and Prince's pair of orders 5 and 4 (1980, doi 10.1016/0771-050X(80)90013-3) with one step
for the whole batch, counted in parts of an interval of the history: the steps end at its points,
where the interpolated gradient has kinks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, ConvergenceError, refuse_no_number
from fibermelt.history import FlowHistory
from fibermelt.orientation.flows import strain_and_spin
from fibermelt.orientation.kinetics import ClosureLike, OrientationModel, checked_law
from fibermelt.orientation.paths import GradientAlong, checked_history
from fibermelt.orientation.tensors import checked_orientation, out_of_range

__all__ = ["OrientationHistory", "follow_orientation"]

Array = NDArray[np.float64]

NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
"""Where in a step the stages lie."""

STAGES = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
"""Weights of the earlier stages in each; the last row is the step of order 5."""

DIFFERENCE = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
"""Weights of the step of order 5 minus those of order 4: the error estimate."""

SAFETY, SLOWEST, FASTEST = 0.9, 0.2, 5.0
"""Factors of the step control; the exponent is 1/5, the estimate being of order ``h^5``."""

SLOWEST_AGAIN = 0.1
"""The same at the second refusal in a row, when the exponent is 1."""

SMALLEST_STEP = 2.0**-40
"""Smallest part of an interval: below it time hardly moves, and the rate is not smooth."""

LARGEST_STRAIN = 1.0
"""Bound of ``|L| dt`` over a step: a stage beyond could leave for numbers that overflow."""

MOST_STEPS = 4000
"""Steps and attempts in one interval: beyond, it is longer than any history's."""


@dataclass(frozen=True, eq=False)
class OrientationHistory:
    """Orientation tensors along histories.

    Parameters
    ----------
    time : (..., n) array
        Times [s], those of the history.
    a : (..., n, 3, 3) array
        Tensors there [-], as the integration left them: nothing is clipped or rescaled.
    error : (...) array
        Sum over the steps of the largest estimated error of a component [-].
    violation : (...) array
        Largest excess of an eigenvalue over [0, 1] on the way, 0 where there is none.
    trace_drift : (...) array
        Largest ``|tr a - 1|`` on the way: rounding for closures that keep ``A:I = a``.
    steps, rejected : int
        Steps taken by the batch, and tried in vain.
    """

    time: Array
    a: Array
    error: Array
    violation: Array
    trace_drift: Array
    steps: int
    rejected: int


def follow_orientation(
    model: OrientationModel,
    closure: ClosureLike,
    history: FlowHistory | tuple[ArrayLike, ArrayLike],
    a0: ArrayLike,
    *,
    rtol: float = 1e-8,
    atol: float = 1e-10,
) -> OrientationHistory:
    """Return the orientation tensor along one history or many.

    Parameters
    ----------
    model : OrientationModel
        Law of the rate.
    closure : ClosureLike
        What closes the fourth moment.
    history : FlowHistory, or (time, L)
        Times (..., n) [s] and velocity gradients (..., n, d, d) [1/s], d 2 (embedded, ``L_33 = 0``)
        or 3.
    a0 : (..., 3, 3) array_like
        Tensors at the start; leading axes are broadcast with those of the history.
    rtol, atol : float
        Bound of the estimated error of a step, relative to a component and absolute [-].

    Returns
    -------
    OrientationHistory

    Raises
    ------
    HistoryError
        If time does not increase, shapes disagree, or a gradient has a trace.
    ConfigError
        If ``a0`` is no orientation tensor, a tolerance not positive, or the model's diffusion
        negative in this flow where there are no fibers.
    ConvergenceError
        If a step would fall below 2^-40 of an interval, or an interval takes more than 4000. The
        message has the time.

    Notes
    -----
    Fitted orthotropic closures (ORF, ORL, ORW, ORW3, and ORE by a twentieth) change by their own
    error over a gap of two eigenvalues of 1e-5 (`fibermelt.orientation.orthotropic`). A state that
    their rates keep in there, as fibers may that enter aligned, takes short steps: for a strain of
    one, up to some 600.
    """
    _check_tolerances(rtol, atol)
    checked_law(model, closure)
    time, L = checked_history(history)
    model.refuse_flow(strain_and_spin(L)[0])
    start = checked_orientation(a0, "a0")
    try:
        batch = np.broadcast_shapes(time.shape[:-1], start.shape[:-2])
    except ValueError as error:
        msg = (
            f"a0 has leading axes {start.shape[:-2]}, the history {time.shape[:-1]}: give axes "
            "that broadcast, e.g. (m, 1) tensors and (k,) histories"
        )
        raise ConfigError(msg) from error
    run = _Run(model, closure, GradientAlong(time, L), np.diff(time, axis=-1), rtol, atol)
    return run.along(time, np.array(np.broadcast_to(start, (*batch, 3, 3))))


class _Run:
    """One integration: the state of its step control is the only thing that changes."""

    def __init__(
        self,
        model: OrientationModel,
        closure: ClosureLike,
        gradient: GradientAlong,
        duration: Array,
        rtol: float,
        atol: float,
    ) -> None:
        self.model, self.closure, self.gradient = model, closure, gradient
        self.duration, self.rtol, self.atol = duration, rtol, atol
        self.step, self.steps, self.rejected = 1.0, 0, 0
        self.refusal = ""

    def along(self, time: Array, a: Array) -> OrientationHistory:
        """Return the tensors at all points, from ``a`` (..., 3, 3) at the first."""
        intervals = self.duration.shape[-1]
        states = np.empty((*a.shape[:-2], intervals + 1, 3, 3))
        states[..., 0, :, :] = a
        error = np.zeros(a.shape[:-2])
        rate = self._rate(a, 0, 0.0)
        for k in range(intervals):
            a, rate, added = self._over(k, a, rate, time)
            states[..., k + 1, :, :] = a
            error += added
        drift = np.abs(np.trace(states, axis1=-2, axis2=-1) - 1.0).max(axis=-1)
        return OrientationHistory(
            time=np.broadcast_to(time, states.shape[:-2]),
            a=states,
            error=error,
            violation=out_of_range(states).max(axis=-1),
            trace_drift=drift,
            steps=self.steps,
            rejected=self.rejected,
        )

    def _rate(self, a: Array, interval: int, u: float) -> Array:
        return self.model.rate(a, self.gradient.at(interval, u), self.closure)

    def _over(self, k: int, a: Array, rate: Array, time: Array) -> tuple[Array, Array, Array]:
        """Return tensor and rate at the end of interval ``k``, and the error added on it."""
        longest = LARGEST_STRAIN / max(float(self.gradient.strain[k]), LARGEST_STRAIN)
        self.step, self.refusal = min(self.step, longest), ""
        u, added, before = 0.0, np.zeros(a.shape[:-2]), self.steps + self.rejected
        in_a_row = 0
        while u < 1.0:
            self._check_effort(float(np.ravel(time[..., k])[0]), before)
            left = 1.0 - u
            parts = np.ceil(left / self.step * (1.0 - 1e-12))
            h = left / parts
            ended, last, difference = self._try(k, u, h, a, rate)
            bound = self.atol + self.rtol * np.maximum(np.abs(a), np.abs(ended))
            worst = float(np.max(np.abs(difference) / bound, initial=0.0))
            if not worst <= 1.0:  # a rate that is not a number is refused too
                self.rejected += 1
                in_a_row += 1
                # a second time means a jump, across which the error goes with h alone
                order = 0.2 if in_a_row == 1 else 1.0
                least = SLOWEST if in_a_row == 1 else SLOWEST_AGAIN
                self.step = h * (max(least, SAFETY * worst**-order) if worst < np.inf else SLOWEST)
                continue
            most = FASTEST if in_a_row == 0 else 1.0
            factor = most if worst == 0.0 else min(most, SAFETY * worst**-0.2)
            in_a_row = 0
            # the last part of an interval may be short for no reason of accuracy
            self.step = min(longest, max(self.step, h * factor) if factor >= 1.0 else h * factor)
            self.steps += 1
            a, rate, added = ended, last, added + np.max(np.abs(difference), axis=(-2, -1))
            u = 1.0 if parts == 1.0 else u + h
        return a, rate, added

    def _try(self, k: int, u: float, h: float, a: Array, rate: Array) -> tuple[Array, Array, Array]:
        """Return the state after a step, the rate there, and the estimated error."""
        dt = h * self.duration[..., k][..., None, None]
        rates = [rate]
        state = a
        for node, weights in zip(NODES[1:], STAGES[1:], strict=True):
            state = a + dt * _combined(weights, rates)
            try:
                rates.append(self._rate(state, k, u + node * h))
            except ConfigError as error:  # a stage left the tensors that the closure is defined for
                self.refusal = f"; of the last step that was refused, {error}"
                return a, rate, np.full_like(a, np.inf)
        return state, rates[-1], dt * _combined(DIFFERENCE, rates)

    def _check_effort(self, time: float, before: int) -> None:
        """Refuse to go on where steps have become too small or too many."""
        if self.step < SMALLEST_STEP or self.steps + self.rejected - before > MOST_STEPS:
            msg = (
                f"orientation with {self.model.name} and closure {self.closure.name}: the interval "
                f"from t = {time:.6g} s needs steps below {SMALLEST_STEP:.1e} of it or more than "
                f"{MOST_STEPS}: loosen the tolerance, give the history more points there, or take "
                f"another closure{self.refusal}"
            )
            raise ConvergenceError(msg)


def _combined(weights: tuple[float, ...], rates: list[Array]) -> Array:
    """Return the weighted sum of rates; zero weights cost nothing."""
    terms = [weight * rate for weight, rate in zip(weights, rates, strict=True) if weight]
    total = terms[0]
    for term in terms[1:]:
        total += term
    return total


def _check_tolerances(rtol: float, atol: float) -> None:
    for name, value in (("rtol", rtol), ("atol", atol)):
        refuse_no_number(name, value)
        if not (np.isfinite(value) and value > 0.0):
            msg = f"{name} = {value:g}: must be positive, e.g. 1e-8"
            raise ConfigError(msg)
