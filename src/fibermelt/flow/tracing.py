"""Many streamlines at once: an embedded Runge-Kutta pair, each line with its own step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import RK45
from scipy.interpolate import CubicHermiteSpline

from fibermelt.errors import ConvergenceError
from fibermelt.flow.field import FlowField, Place

__all__ = ["Path", "trace"]

Array = NDArray[np.float64]

MAX_STEPS = 20_000
"""Steps in which every line must reach the outlet; the default nozzle needs a few hundred."""

SMALLEST_STEP = 1e-7
"""Parts of the largest step below which a line is stuck at a stagnation point or outside."""


ARRIVED = 1e-9
"""Distance to the outlet over the largest step at which a line has arrived: above rounding."""


@dataclass(frozen=True, eq=False)
class Path:
    """A traced line: arclength [m], position [m], time [s] and their slopes at every step."""

    arclength: Array
    position: Array
    time: Array
    direction: Array
    slowness: Array

    def at(self, arclength: Array) -> tuple[Array, Array]:
        """Return position (n, 2) and time (n,) between the steps, by cubic Hermite splines."""
        position = CubicHermiteSpline(self.arclength, self.position, self.direction)(arclength)
        time = CubicHermiteSpline(self.arclength, self.time, self.slowness)(arclength)
        return np.asarray(position), np.asarray(time)


class _Tracer:
    """The state of all lines: position and time as one (n, 3) array, arclength, step."""

    def __init__(self, field: FlowField, seeds: Array, outlet: float) -> None:
        self.field = field
        self.outlet = outlet
        self.place = field.locate(seeds)

    def slope(self, state: Array, lines: NDArray[np.int64]) -> Array:
        """Return d(x, y, t)/ds of the lines named; NaN where a point lies outside."""
        guess = Place(self.place.cell[lines], self.place.reference[lines])
        place = self.field.locate(state[:, :2], guess)
        inside = place.found
        self.place.cell[lines[inside]] = place.cell[inside]
        self.place.reference[lines[inside]] = place.reference[inside]
        u = self.field.evaluate(self.field.velocity, place)
        speed = np.hypot(u[:, 0], u[:, 1])
        return np.column_stack([u / speed[:, None], 1 / speed])

    def step(
        self, state: Array, slope: Array, h: Array, lines: NDArray[np.int64]
    ) -> tuple[Array, Array, Array]:
        """Return state and slope after a step of each line named, and its error of position [m].

        The error is infinite where a stage lies outside the field.
        """
        stages = [slope]
        for weights in RK45.A[1:]:
            move = sum(w * k for w, k in zip(weights, stages, strict=False))
            stages.append(self.slope(state + h[:, None] * move, lines))
        new = state + h[:, None] * sum(b * k for b, k in zip(RK45.B, stages, strict=True))
        stages.append(self.slope(new, lines))
        miss = h[:, None] * sum(e * k for e, k in zip(RK45.E, stages, strict=True))
        error = np.hypot(miss[:, 0], miss[:, 1])
        error[np.isnan(error)] = np.inf
        return new, stages[-1], error


def trace(
    field: FlowField, seeds: Array, outlet: float, tolerance: float, largest_step: float
) -> list[Path]:
    """Trace the streamlines from ``seeds`` (n, 2) to ``x = outlet``.

    Parameters
    ----------
    field : FlowField
        The flow.
    seeds : (n, 2) array
        Where the lines start [m].
    outlet : float
        x at which they end [m]; the flow there is along x.
    tolerance : float
        Error of position allowed in a step [m].
    largest_step : float
        Longest step [m].

    Raises
    ------
    ConvergenceError
        If a line leaves the field or does not reach the outlet.

    Notes
    -----
    Dormand and Prince's pair of orders 5 and 4 (J. Comput. Appl. Math. 6 (1980) 19), its
    coefficients from SciPy. The field is smooth within a triangle only, so steps across edges
    are found out by the error estimate and shortened.
    """
    count = len(seeds)
    tracer = _Tracer(field, seeds, outlet)
    state = np.column_stack([seeds, np.zeros(count)])
    slope = tracer.slope(state, np.arange(count))
    arclength = np.zeros(count)
    step = np.full(count, 0.1 * largest_step)
    records: list[list[Array]] = [[np.r_[0.0, state[k], slope[k]]] for k in range(count)]
    active = np.arange(count)
    for _ in range(MAX_STEPS):
        if active.size == 0:
            break
        left = outlet - state[active, 0]
        h = np.minimum(np.minimum(step[active], largest_step), left)
        new, end_slope, miss = tracer.step(state[active], slope[active], h, active)
        error = miss / tolerance
        good = error <= 1.0
        with np.errstate(divide="ignore"):
            factor = np.clip(0.9 * error**-0.2, 0.2, 4.0)
        # a step cut short by the outlet says nothing of the step the field allows
        step[active] = np.where(good & (h == left), step[active], h * factor)
        done = active[good]
        state[done], slope[done] = new[good], end_slope[good]
        arclength[done] += h[good]
        for k in done:
            records[k].append(np.r_[arclength[k], state[k], slope[k]])
        if np.any(step[active] < SMALLEST_STEP * largest_step):
            k = active[np.argmin(step[active])]
            _raise_stuck(int(k), state[k], "is stuck there or leaves the mesh")
        active = active[outlet - state[active, 0] > ARRIVED * largest_step]
    else:
        _raise_stuck(int(active[0]), state[active[0]], f"did not reach x = {outlet:g} m")
    return [_path(np.array(record)) for record in records]


def _raise_stuck(line: int, state: Array, what: str) -> None:
    msg = (
        f"streamline {line + 1} {what}: (x, y) = ({state[0]:.4g}, {state[1]:.4g}) m; "
        "refine the mesh (numerics.bulk_edge) or trace fewer lines (streamlines.count)"
    )
    raise ConvergenceError(msg)


def _path(record: Array) -> Path:
    return Path(record[:, 0], record[:, 1:3], record[:, 3], record[:, 4:6], record[:, 6])
