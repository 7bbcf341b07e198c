"""Many streamlines at once: an embedded Runge-Kutta pair, each line with its own step.

Of any steady flow in two or three dimensions that can say where points lie in it and what its
velocity is there. Lines are followed by arclength: ``dx/ds = u/|u|``, ``dt/ds = 1/|u|``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Literal, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import RK45
from scipy.interpolate import CubicHermiteSpline

from fibermelt.errors import ConvergenceError

__all__ = ["Ending", "Located", "Path", "Rules", "VelocityField", "follow_lines", "trace"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

Ending = Literal["arrived", "left", "still", "late"]
"""Why a line ends: at its outlet, where the field does, where the melt stands, at its time."""

MAX_STEPS = 20_000
"""Steps in which every line must reach its end; the default nozzle needs a few hundred."""

SMALLEST_STEP = 1e-7
"""Parts of the largest step below which a line is at a stagnation point or at the field's edge."""

MIDDLE = RK45.P @ 0.5 ** np.arange(1, 5)
"""Weights of the stages at the middle of a step: the pair's own interpolant, of order four."""

ARRIVED = 1e-9
"""Distance to the outlet over the largest step at which a line has arrived: above rounding."""


class Located(Protocol):
    """Where points lie in a field: cells, and coordinates in them."""

    def __init__(self, cell: Index, reference: Array) -> None: ...

    @property
    def cell(self) -> Index:
        """Cell of each point, (n,)."""

    @property
    def reference(self) -> Array:
        """Coordinates of each in its cell, (n, k)."""

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether it lies in the field at all, (n,)."""


P = TypeVar("P", bound=Located)


class VelocityField(Protocol[P]):
    """A steady flow in d = 2 or 3 dimensions."""

    def locate(self, points: Array, guess: P | None = None, /) -> P:
        """Return where points (n, d) lie, searching from a guess inside if there is one."""

    def velocity_at(self, place: P, /) -> Array:
        """Return the velocity there [m/s], (n, d); NaN outside."""


@dataclass(frozen=True)
class Rules:
    """How exactly lines are followed, and where they end, but for the field's edge.

    Parameters
    ----------
    tolerance : float
        Error of position allowed in a step [m].
    largest_step : float
        Longest step [m].
    outlet : float
        x at which lines end [m]; the flow there is along x.
    least_speed : float
        Speed at which the melt stands still [m/s].
    most_time : float
        Time after which a line ends [s]; the last step may pass it (`Path.length` does not).
    between : bool
        Whether the error of time, times the speed, and what the cubic between the steps misses
        (`Path.at`) are held to the tolerance as well. It matters where the melt slows down on a
        straight way.
    """

    tolerance: float
    largest_step: float
    outlet: float = np.inf
    least_speed: float = 0.0
    most_time: float = np.inf
    between: bool = False


@dataclass(frozen=True, eq=False)
class Path:
    """A traced line: arclength [m], position [m], time [s] and their slopes at every step.

    ``cell`` is where each step ended; ``length`` the arclength [m] at the line's end, which lies
    within the last step where time has run out.
    """

    arclength: Array
    position: Array
    time: Array
    direction: Array
    slowness: Array
    cell: Index
    length: float
    end: Ending

    def at(self, arclength: Array) -> tuple[Array, Array]:
        """Return position (n, d) and time (n,) between the steps, by cubic Hermite splines."""
        states = np.column_stack([self.position, self.time])
        slopes = np.column_stack([self.direction, self.slowness])
        found = CubicHermiteSpline(self.arclength, states, slopes)(arclength)
        return np.ascontiguousarray(found[:, :-1]), np.ascontiguousarray(found[:, -1])

    def spread(self, rate: Array, count: int) -> Array:
        """Return the arclengths [m] of ``count`` points on the line, the first at its start.

        They lie evenly over the mean of two measures, each scaled to one: arclength, and the
        strain ``int gamma_dot dt`` that turns a fiber, from its rate [1/s] at the steps.
        """
        strain = np.r_[0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(self.time))]
        measure = self.arclength / self.arclength[-1]
        if strain[-1] > 0.0:  # else the melt turns as a solid
            measure = 0.5 * (measure + strain / strain[-1])
        last = np.interp(self.length, self.arclength, measure)
        at = np.interp(np.linspace(0.0, last, count), measure, self.arclength)
        at[0], at[-1] = 0.0, self.length
        return at


class _Tracer(Generic[P]):
    """The state of all lines: position and time as one (n, d + 1) array, arclength, step."""

    def __init__(self, field: VelocityField[P], seeds: Array, between: bool) -> None:
        self.field = field
        self.between = between
        self.dimension = seeds.shape[1]
        self.place = field.locate(seeds)

    def slope(self, state: Array, lines: Index) -> Array:
        """Return d(x, t)/ds of the lines named; NaN where a point lies outside."""
        slope = np.full_like(state, np.nan)
        # after a stage outside, the next points are no numbers
        known = np.flatnonzero(np.isfinite(state[:, 0]))
        if known.size == 0:
            return slope
        lines = lines[known]
        guess = type(self.place)(self.place.cell[lines], self.place.reference[lines])
        place = self.field.locate(state[known, : self.dimension], guess)
        inside = place.found
        self.place.cell[lines[inside]] = place.cell[inside]
        self.place.reference[lines[inside]] = place.reference[inside]
        u = self.field.velocity_at(place)
        speed = np.hypot.reduce(u, axis=1)
        speed[speed == 0.0] = np.nan  # no direction: as if outside
        slope[known] = np.column_stack([u / speed[:, None], 1 / speed])
        return slope

    def step(self, state: Array, slope: Array, h: Array, lines: Index) -> tuple[Array, ...]:
        """Return state and slope after a step of each line named, and its error [m].

        The error is infinite where a stage lies outside the field.
        """
        stages = [slope]
        for weights in RK45.A[1:]:
            move = sum(w * k for w, k in zip(weights, stages, strict=False))
            stages.append(self.slope(state + h[:, None] * move, lines))
        new = state + h[:, None] * sum(b * k for b, k in zip(RK45.B, stages, strict=True))
        stages.append(self.slope(new, lines))
        miss = h[:, None] * sum(e * k for e, k in zip(RK45.E, stages, strict=True))
        if self.between:
            error = _distance(miss, slope)
            middle = sum(c * k for c, k in zip(MIDDLE, stages, strict=True))
            cubic = 0.5 * (new - state) + 0.125 * h[:, None] * (slope - stages[-1])
            error = np.maximum(error, _distance(h[:, None] * middle - cubic, slope))
        else:
            error = np.hypot.reduce(miss[:, :-1], axis=1)
        error[np.isnan(error)] = np.inf
        return new, stages[-1], error


def _distance(miss: Array, slope: Array) -> Array:
    """Return the size of misses of position and time, time as the way that it stands for [m]."""
    miss[:, -1] /= slope[:, -1]
    return np.asarray(np.hypot.reduce(miss, axis=1))


def follow_lines(field: VelocityField[P], seeds: Array, rules: Rules) -> list[Path]:
    """Follow the streamlines from ``seeds`` (n, d) to their ends.

    Parameters
    ----------
    field : VelocityField
        The flow.
    seeds : (n, d) array
        Where the lines start [m], inside and where the melt moves.
    rules : Rules
        Tolerance and ends.

    Notes
    -----
    Dormand and Prince's pair of orders 5 and 4 (J. Comput. Appl. Math. 6 (1980) 19), its
    coefficients from SciPy. The field is smooth within a cell only, so steps across faces are found
    out by the error estimate and shortened. So are steps out of the field: a line that leaves it
    ends within a few smallest steps of the edge.
    """
    count = len(seeds)
    tracer = _Tracer(field, seeds, rules.between)
    state = np.column_stack([seeds, np.zeros(count)])
    slope = tracer.slope(state, np.arange(count))
    arclength = np.zeros(count)
    step = np.full(count, 0.1 * rules.largest_step)
    active = np.arange(count)
    records = [(active, np.column_stack([arclength, state, slope, tracer.place.cell]))]
    end: list[Ending] = ["late"] * count
    for _ in range(MAX_STEPS):
        if active.size == 0:
            break
        left = rules.outlet - state[active, 0]
        h = np.minimum(np.minimum(step[active], rules.largest_step), left)
        new, end_slope, miss = tracer.step(state[active], slope[active], h, active)
        error = miss / rules.tolerance
        good = error <= 1.0
        with np.errstate(divide="ignore"):
            factor = np.clip(0.9 * error**-0.2, 0.2, 4.0)
        # a step cut short by the outlet says nothing of the step the field allows
        step[active] = np.where(good & (h == left), step[active], h * factor)
        done = active[good]
        state[done], slope[done] = new[good], end_slope[good]
        arclength[done] += h[good]
        here = [a[done] for a in (arclength, state, slope, tracer.place.cell)]
        records.append((done, np.column_stack(here)))
        arrived = rules.outlet - state[active, 0] <= ARRIVED * rules.largest_step
        late = state[active, -1] >= rules.most_time
        stuck = step[active] < SMALLEST_STEP * rules.largest_step
        still = slope[active, -1] * rules.least_speed >= 1.0
        ways: list[tuple[NDArray[np.bool_], Ending]] = [
            (stuck, "left"), (still, "still"), (late, "late"), (arrived, "arrived")
        ]  # fmt: skip
        over = np.zeros(len(active), dtype=bool)
        for which, how in ways:
            for k in active[which]:
                end[k] = how
            over |= which
        active = active[~over]
    lines = np.concatenate([lines for lines, _ in records])
    rows = np.concatenate([rows for _, rows in records])[np.argsort(lines, kind="stable")]
    parts = np.split(rows, np.cumsum(np.bincount(lines, minlength=count))[:-1])
    return [_path(part, how, rules.most_time) for part, how in zip(parts, end, strict=True)]


def trace(
    field: VelocityField[P], seeds: Array, outlet: float, tolerance: float, largest_step: float
) -> list[Path]:
    """Trace the streamlines from ``seeds`` (n, 2) to ``x = outlet``, which all of them reach.

    Parameters
    ----------
    field : VelocityField
        The flow.
    seeds : (n, 2) array
        Where the lines start [m].
    outlet, tolerance, largest_step : float
        As in `Rules` [m].

    Raises
    ------
    ConvergenceError
        If a line leaves the field or does not reach the outlet.
    """
    paths = follow_lines(field, seeds, Rules(tolerance, largest_step, outlet))
    for k, path in enumerate(paths):
        if path.end != "arrived":
            late = f"did not reach x = {outlet:g} m"
            what = late if path.end == "late" else "is stuck there or leaves the mesh"
            x, y = path.position[-1]
            msg = (
                f"streamline {k + 1} {what}: (x, y) = ({x:.4g}, {y:.4g}) m; "
                "refine the mesh (numerics.bulk_edge) or trace fewer lines (streamlines.count)"
            )
            raise ConvergenceError(msg)
    return paths


def _path(record: Array, end: Ending, most_time: float) -> Path:
    """Return a line from its rows of arclength, position, time, their slopes, and cell."""
    d = (record.shape[1] - 4) // 2
    s, position, time, direction, slowness, cell = np.split(
        record, np.cumsum([1, d, 1, d, 1]), axis=1
    )
    s, time, slowness = s[:, 0], time[:, 0], slowness[:, 0]
    length = float(s[-1])
    if time[-1] > most_time:
        length = float(CubicHermiteSpline(s, time, slowness).solve(most_time, extrapolate=False)[0])
    return Path(s, position, time, direction, slowness, cell[:, 0].astype(np.int64), length, end)
