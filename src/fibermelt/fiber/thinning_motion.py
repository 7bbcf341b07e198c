"""Fibers followed along a path of a thinning melt: their angles, and the pressure on them.

``theta_dot = W_21 + d omega(gamma_dot, 2 beta - 2 theta)``, ``D = d (cos 2 beta, sin 2 beta)`` in
the axes of the flow. It is not linear in a director any more: each angle is integrated, by the
fifth order pair of Dormand and Prince (1980, doi 10.1016/0771-050X(80)90013-3), between the points
of the path as `fibermelt.interpolation` has it. An interval is halved, for the paths that need it,
until the pair's own error is within its share of the tolerance.

What an interval does to an angle is a smooth function of the half turn. It is integrated for
`DIRECTIONS` angles of all intervals of all paths at once, and any number of fibers then steps from
point to point by its trigonometric interpolant. An interval whose function is too steep for that
is integrated for the fibers themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber.paths import checked_path, strain_polar
from fibermelt.fiber.thinning import SpinSeries, ThinningResponse
from fibermelt.history import FlowHistory
from fibermelt.interpolation import PathInterpolant

__all__ = ["TABLE_TOLERANCE", "ThinningMotion", "ThinningPressure", "follow_thinning"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

TABLE_TOLERANCE = 1e-5
"""Angle error over a path [rad] that is left to the integration: the table's own is 1e-5 per unit
of strain, of which a bead has ten."""

MOST_HALVINGS = 12
"""Halvings of an interval, as many as Magnus' steps of a Newtonian fiber may need."""

LARGEST_TURN = 1.0
"""Strain times time of a first step: the pair's error is then its fifth power of a fraction."""

FEWEST, DIRECTIONS = 16, 64
"""Angles over half a turn from which the intervals of a path are integrated: at first, and at most,
doubled where they are too few. Most of a bead's take 32. With no more than 48 a fifth of the
intervals was too steep on a path that strains by 0.4 an interval, with 64 one in thirty."""

TAIL = 4
"""Highest harmonics of an interval's function that have to be within its share of the tolerance.
The series' own terms are odd; where all of these are known, the even ones tell what is not."""

KNOTS = 128
"""Angles over half a turn at which the interpolant is read with its slope; the cubic between them
is 1e-8 of what an interval turns by off."""

TOGETHER = 1 << 14
"""Angles that are integrated together: their arrays then stay in the cache."""

BLOCK = 1 << 18
"""Values of interpolants that are kept at a time."""

NODES = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0])
STAGES = (
    np.array([1 / 5]),
    np.array([3 / 40, 9 / 40]),
    np.array([44 / 45, -56 / 15, 32 / 9]),
    np.array([19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729]),
    np.array([9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656]),
    np.array([35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84]),
)
ERROR = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
"""Fifth order solution less the embedded fourth, over its seven stages."""


@dataclass(frozen=True, eq=False)
class ThinningMotion:
    """The angles of fibers along a path of a thinning melt, as in `fibermelt.fiber.Motion`.

    Parameters
    ----------
    initial_angles : (n_angles,) array
        Angles at the start [rad].
    angle : (..., n_angles, n) array
        Angles [rad], continuous in time.
    substeps : int
        Largest number of steps that an interval took.
    path : FlowHistory
        The path that they were followed along.
    response : ThinningResponse
        The fibers' table.
    """

    initial_angles: Array
    angle: Array
    substeps: int
    path: FlowHistory = field(repr=False)
    response: ThinningResponse = field(repr=False)

    @cached_property
    def spin(self) -> Array:
        """Rate of the angle [1/s], (..., n_angles, n)."""
        L = self.path.plane_gradient
        size, double = strain_polar(L)
        omega = self.response.series(2.0 * size[..., None, :])
        W = 0.5 * (L[..., 1, 0] - L[..., 0, 1])
        phase = double[..., None, :] - 2.0 * self.angle
        return np.asarray(W[..., None, :] + size[..., None, :] * omega(phase))


@dataclass(frozen=True, eq=False)
class ThinningPressure:
    """Lowest and highest pressure on the surface along the way, as in `SurfacePressure`.

    Parameters
    ----------
    lowest, highest : (..., n_angles, n) array
        Over the surface, relative to the streamline's pressure [Pa].
    phase : (..., n_angles, n) array
        ``2 (beta - theta)`` [rad].
    amplitude, rate : (..., n) array
        ``eta(gamma_dot) d`` [Pa] and ``gamma_dot`` [1/s].
    response : ThinningResponse
        The fiber that answered.
    path : FlowHistory
        The path that it was followed along.
    """

    lowest: Array
    highest: Array
    phase: Array
    amplitude: Array
    rate: Array
    response: ThinningResponse
    path: FlowHistory = field(repr=False)

    @property
    def tip(self) -> Array:
        """Return the pressure at the fiber's tips [Pa], (..., n_angles, n)."""
        shape = self.response.tip_at(self.rate[..., None, :], self.phase)
        return np.asarray(self.amplitude[..., None, :] * shape)

    def where_at(self, index: Index) -> Array:
        """Return the eccentric angles [rad] of the extremes, as `SurfaceHistory.where_at` says."""
        flat = index.reshape(*index.shape[:-2], -1)
        rates = np.broadcast_to(self.rate[..., None, :], self.phase.shape)
        phase, rate = (
            np.take_along_axis(values, flat, axis=-1).reshape(index.shape)
            for values in (self.phase, rates)
        )
        phase[..., 1] += np.pi
        return self.response.where_lowest_at(rate, phase)


def follow_thinning(
    path: FlowHistory,
    response: ThinningResponse,
    initial_angles: Array,
    tolerance: float = TABLE_TOLERANCE,
) -> ThinningMotion:
    """Follow fibers of a thinning melt along a path from all initial angles at once.

    Parameters
    ----------
    path : FlowHistory
        One path (n points) or several of equal length (leading axis).
    response : ThinningResponse
        Their table.
    initial_angles : (n_angles,) array
        Angles from the x axis at the start [rad].
    tolerance : float
        Angle error of the time integration over the whole path [rad]: a bound on the local errors'
        sum as the pair estimates them.

    Raises
    ------
    ConfigError
        If the tolerance is not positive, or the table does not hold at the path's rates.
    ConvergenceError
        If an interval needs more than ``2**12`` steps.
    """
    if not tolerance > 0:
        msg = f"tolerance = {tolerance:g}: must be positive, e.g. {TABLE_TOLERANCE:g}"
        raise ConfigError(msg)
    checked_path(path)
    lead, n = path.time.shape[:-1], path.time.shape[-1]
    turning = _turning(path, response, tolerance)
    most, lines = turning.steps, len(turning.steep)
    angle = np.empty((n, lines, initial_angles.size))
    angle[0] = initial_angles
    block = max(1, BLOCK // (lines * KNOTS))
    for k in range(n - 1):
        if k % block == 0:
            maps = turning.maps(slice(k, k + block))
        angle[k + 1] = _turned(maps[k % block], angle[k])
        steep = np.flatnonzero(turning.steep[:, k])
        if steep.size:
            where = np.full(steep.size, k)
            angle[k + 1, steep], taken = _cross(
                turning.melt, steep, where, angle[k, steep], tolerance / (n - 1)
            )
            most = max(most, taken)
    whole = np.ascontiguousarray(np.moveaxis(angle, 0, -1))
    whole = whole.reshape(*lead, initial_angles.size, n)
    return ThinningMotion(initial_angles, whole, most, path, response)


@dataclass(frozen=True, eq=False)
class _Turning:
    """How the intervals of paths turn any angle.

    The ``spectrum`` (m, n - 1, h) of the turn over the half turn, the intervals that are too
    ``steep`` for it (m, n - 1), and the largest number of ``steps`` of the others.
    """

    melt: _Melt
    spectrum: NDArray[np.complex128]
    steep: NDArray[np.bool_]
    steps: int

    def maps(self, some: slice) -> NDArray[np.complex128]:
        """Return the turn in each of some intervals at ``pi j/KNOTS``, its slope a knot beside it.

        As real and imaginary parts, which are then read at once; flat, line after line.
        """
        spectrum = np.moveaxis(self.spectrum[:, some], 1, 0)
        wave = 2j * np.arange(spectrum.shape[-1]) * (np.pi / KNOTS)
        found = np.empty((*spectrum.shape[:2], KNOTS), dtype=np.complex128)
        found.real = KNOTS * np.fft.irfft(spectrum, n=KNOTS, axis=-1)
        found.imag = KNOTS * np.fft.irfft(wave * spectrum, n=KNOTS, axis=-1)
        return found.reshape(len(found), -1)


@lru_cache(maxsize=1)
def _turning(path: FlowHistory, response: ThinningResponse, tolerance: float) -> _Turning:
    """Integrate all intervals of a path; any number of angles shares the last one's."""
    n = path.time.shape[-1]
    L = path.plane_gradient.reshape(-1, n, 2, 2)
    fields = [
        0.5 * (L[..., 0, 0] - L[..., 1, 1]),
        0.5 * (L[..., 0, 1] + L[..., 1, 0]),
        0.5 * (L[..., 1, 0] - L[..., 0, 1]),
    ]
    melt = _Melt(path.time.reshape(-1, n), np.stack(fields, axis=-1), response)
    line, interval = (part.ravel() for part in np.indices(melt.step.shape))
    bound, most = tolerance / (n - 1), 1
    spectrum = np.zeros((line.size, DIRECTIONS // 2), dtype=np.complex128)
    left, count, terms = np.arange(line.size), FEWEST, response.terms
    start = np.pi * np.arange(count) / count
    turn: Array = np.empty(0)
    while left.size and count <= DIRECTIONS:
        begin = np.broadcast_to(start, (left.size, start.size))
        after, taken = _cross(melt, line[left], interval[left], begin, bound)
        most, found = max(most, taken), after - start
        turn = found if count == FEWEST else np.stack([turn, found], -1).reshape(left.size, count)
        harmonics = np.fft.rfft(turn, axis=-1)[:, :-1] / count
        spectrum[left, : count // 2] = harmonics
        tail = harmonics[:, -TAIL :: 2 if count >= 4 * terms else 1]
        more = np.max(np.abs(tail), axis=-1) > bound
        left, turn = left[more], turn[more]
        start = np.pi * (np.arange(count) + 0.5) / count
        count *= 2
    steep = np.zeros(line.size, dtype=bool)
    steep[left] = True
    shape = melt.step.shape
    return _Turning(melt, spectrum.reshape(*shape, -1), steep.reshape(shape), most)


def _turned(turn: NDArray[np.complex128], angle: Array) -> Array:
    """Return angles (m, a) behind an interval, by a cubic between the knots of its turn."""
    at = angle * (KNOTS / np.pi)
    left = np.floor(at)
    u = at - left
    knot, line = left.astype(np.intp), KNOTS * np.arange(len(angle))[:, None]
    before, after = (turn.take(line + (knot + k) % KNOTS) for k in (0, 1))
    v, s, t = before.real, before.imag, after.imag
    rise = after.real - v
    bend, twist = 3.0 * rise - 2.0 * s - t, s + t - 2.0 * rise
    return np.asarray(angle + v + u * (s + u * (bend + u * twist)))


@dataclass(frozen=True, eq=False)
class _Stages:
    """Spin, size and double angle (stage, p, 1), and the series (stage, k, p, 1)."""

    spin: Array
    size: Array
    double: Array
    series: Array


class _Melt:
    """What the melt does between the points of paths (m, n)."""

    def __init__(self, time: Array, fields: Array, response: ThinningResponse) -> None:
        self.time, self.response = time, response
        self.gradient = PathInterpolant(time, fields)
        self.step = self.gradient.step[..., 0]
        turn = np.maximum(self.gradient.largest_change() / LARGEST_TURN, 1.0)
        self.halvings = np.ceil(np.log2(turn)).astype(np.intp)

    def stages(self, line: Index, interval: Index, count: int, part: int) -> _Stages:
        """Return what the ``part``-th of ``count`` steps meets in intervals (p,) of lines (p,)."""
        u = ((part + NODES) / count)[:, None, None]
        values = self.gradient((line, interval), u)
        normal, shear, spin = np.moveaxis(values, -1, 0)[..., None]
        size = np.hypot(normal, shear)
        series = np.ascontiguousarray(
            np.moveaxis(self.response.series(2.0 * size).coefficients, 0, -3)
        )
        return _Stages(spin, size, np.arctan2(shear, normal), series)


def _cross(
    melt: _Melt, line: Index, interval: Index, angle: Array, bound: float
) -> tuple[Array, int]:
    """Return angles (p, k) behind intervals of lines (p,), and the most steps that one took."""
    new = np.empty(angle.shape)
    first, left, halvings = melt.halvings[line, interval], np.arange(line.size), 0
    while left.size:
        if halvings > MOST_HALVINGS:
            worst = float(melt.time[line[left[0]], interval[left[0]]])
            msg = (
                f"fiber motion: the interval from t = {worst:.6g} s turns too fast or unevenly "
                f"for {1 << MOST_HALVINGS} steps: give the history more points there"
            )
            raise ConvergenceError(msg)
        tried = left[first[left] <= halvings]
        count = 1 << halvings
        for some in np.array_split(tried, 1 + tried.size * angle.shape[1] // TOGETHER):
            if some.size == 0:
                continue
            now, errors = angle[some], np.zeros(some.size)
            step = melt.step[line[some], interval[some], None] / count
            for part in range(count):
                now, error = _step(melt.stages(line[some], interval[some], count, part), now, step)
                errors += error
            new[some] = now
            # halving leaves a sixteenth of the error
            more = np.log2(np.maximum(errors / bound, 1.0)) / 4.0
            first[some] = np.where(errors <= bound, -1, halvings + np.maximum(1, more.astype(int)))
        left = left[first[left] >= 0]
        halvings += 1
    return new, 1 << max(0, halvings - 1)


def _step(stages: _Stages, angle: Array, step: Array) -> tuple[Array, Array]:
    """Return angles (m, k) after a step (m, 1) [s], and each line's worst error [rad]."""
    rates, now = np.empty((len(NODES) + 1, *angle.shape)), angle
    for stage in range(len(NODES) + 1):
        at = min(stage, len(NODES) - 1)
        rate = rates[stage]
        np.multiply(2.0, now, out=rate)
        np.subtract(stages.double[at], rate, out=rate)
        np.multiply(stages.size[at], SpinSeries(stages.series[at])(rate), out=rate)
        rate += stages.spin[at]
        if stage < len(NODES):
            now = angle + step * np.tensordot(STAGES[stage], rates[: stage + 1], 1)
    error = np.abs(np.tensordot(ERROR, rates, 1))
    return now, np.asarray(step[:, 0] * np.max(error, axis=-1))
