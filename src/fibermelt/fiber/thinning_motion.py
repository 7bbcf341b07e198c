"""Fibers followed along a path of a thinning melt: their angles, and the pressure on them.

``theta_dot = W_21 + d omega(gamma_dot, 2 beta - 2 theta)``, ``D = d (cos 2 beta, sin 2 beta)`` in
the axes of the flow. It is not linear in a director any more: each angle is integrated, by the
fifth order pair of Dormand and Prince (1980, doi 10.1016/0771-050X(80)90013-3), between the points
of the path as `fibermelt.interpolation` has it. An interval is halved, for the paths that need it,
until the pair's own error is within its share of the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.fiber.paths import Path, strain_polar
from fibermelt.fiber.thinning import SpinSeries, ThinningResponse
from fibermelt.interpolation import PathInterpolant

__all__ = ["TABLE_TOLERANCE", "ThinningMotion", "ThinningPressure", "follow_thinning"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

TABLE_TOLERANCE = 1e-6
"""Angle error over a path [rad] that is left to the integration: the table's own is 1e-5 per unit
of strain."""

MOST_HALVINGS = 12
"""Halvings of an interval, as many as Magnus' steps of a Newtonian fiber may need."""

LARGEST_TURN = 1.0
"""Strain times time of a first step: the pair's error is then its fifth power of a fraction."""

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
    angle, spin : (..., n_angles, n) array
        Angles [rad], continuous in time, and their rate [1/s].
    substeps : int
        Largest number of steps that an interval took.
    path : FlowHistory or PathBundle
        The path that they were followed along.
    """

    initial_angles: Array
    angle: Array
    spin: Array
    substeps: int
    path: Path = field(repr=False)


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
    path : FlowHistory or PathBundle
        The path that it was followed along.
    """

    lowest: Array
    highest: Array
    phase: Array
    amplitude: Array
    rate: Array
    response: ThinningResponse
    path: Path = field(repr=False)

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
    path: Path,
    response: ThinningResponse,
    initial_angles: Array,
    tolerance: float = TABLE_TOLERANCE,
) -> ThinningMotion:
    """Follow fibers of a thinning melt along a path from all initial angles at once.

    Parameters
    ----------
    path : FlowHistory or PathBundle
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
    lead, n = path.time.shape[:-1], path.time.shape[-1]
    L = path.gradient.reshape(-1, n, 2, 2)
    fields = [
        0.5 * (L[..., 0, 0] - L[..., 1, 1]),
        0.5 * (L[..., 0, 1] + L[..., 1, 0]),
        0.5 * (L[..., 1, 0] - L[..., 0, 1]),
    ]
    melt = _Melt(PathInterpolant(path.time.reshape(-1, n), np.stack(fields, axis=-1)), response)
    lines = len(L)
    angle = np.empty((n, lines, initial_angles.size))
    angle[0] = initial_angles
    bound = tolerance / (n - 1)
    first = np.ceil(np.log2(np.maximum(melt.turn / LARGEST_TURN, 1.0))).astype(np.intp)
    everyone = np.arange(lines)
    most = 1
    # all lines that one step may do take it together; what fails is halved by itself
    at_once = melt.stages(everyone, np.arange(n - 1)[:, None], 1, 0)
    for k in range(n - 1):
        new, error = _step(at_once.at(k), angle[k], melt.step[:, k, None])
        left = np.flatnonzero((error > bound) | (first[:, k] > 0))
        halvings = 0
        while left.size:
            halvings += 1
            if halvings > MOST_HALVINGS:
                worst = float(path.time.reshape(-1, n)[left[0], k])
                msg = (
                    f"fiber motion: the interval from t = {worst:.6g} s turns too fast or unevenly "
                    f"for {1 << MOST_HALVINGS} steps: give the history more points there"
                )
                raise ConvergenceError(msg)
            tried = left[first[left, k] <= halvings]
            if tried.size == 0:
                continue
            count = 1 << halvings
            most = max(most, count)
            now, errors = angle[k][tried], np.zeros(tried.size)
            for part in range(count):
                stages = melt.stages(tried, np.array([k]), count, part)
                now, error = _step(stages, now, melt.step[tried, k, None] / count)
                errors += error
            new[tried] = now
            done = errors <= bound
            left = np.setdiff1d(left, tried[done], assume_unique=True)
        angle[k + 1] = new
    whole = np.moveaxis(angle, 0, -1).reshape(*lead, initial_angles.size, n)
    size, double = strain_polar(path.gradient)
    omega = response.series(2.0 * size[..., None, :])(double[..., None, :] - 2.0 * whole)
    W = 0.5 * (path.gradient[..., 1, 0] - path.gradient[..., 0, 1])
    spin = W[..., None, :] + size[..., None, :] * omega
    return ThinningMotion(initial_angles, whole, spin, most, path)


@dataclass(frozen=True, eq=False)
class _Stages:
    """Spin, size and double angle (..., stage, m, 1), and the series (..., stage, k, m, 1)."""

    spin: Array
    size: Array
    double: Array
    series: Array

    def at(self, interval: int) -> _Stages:
        """Return those of one interval."""
        parts = (self.spin, self.size, self.double, self.series)
        return _Stages(*(part[interval] for part in parts))


class _Melt:
    """What the melt does between the points of paths (m, n)."""

    def __init__(self, gradient: PathInterpolant, response: ThinningResponse) -> None:
        self.gradient, self.response = gradient, response
        self.step = gradient.step[..., 0]
        self.turn = gradient.largest_change()

    def stages(self, line: Index, interval: Index, count: int, part: int) -> _Stages:
        """Return what the ``part``-th of ``count`` steps meets in intervals (..., 1) of lines."""
        u = ((part + NODES) / count)[:, None, None]
        values = self.gradient((line, interval[..., None]), u)
        normal, shear, spin = np.moveaxis(values, -1, 0)[..., None]
        size = np.hypot(normal, shear)
        series = np.ascontiguousarray(
            np.moveaxis(self.response.series(2.0 * size).coefficients, 0, -3)
        )
        return _Stages(spin, size, np.arctan2(shear, normal), series)


def _step(stages: _Stages, angle: Array, step: Array) -> tuple[Array, Array]:
    """Return angles (m, k) after a step (m, 1) [s], and each line's worst error [rad]."""
    rates: list[Array] = []
    now = angle
    for stage in range(len(NODES) + 1):
        at = min(stage, len(NODES) - 1)
        omega = SpinSeries(stages.series[at])(stages.double[at] - 2.0 * now)
        rates.append(stages.spin[at] + stages.size[at] * omega)
        if stage < len(NODES):
            slope = sum(w * rate for w, rate in zip(STAGES[stage], rates, strict=True) if w)
            now = angle + step * slope
    error = step * sum(w * rate for w, rate in zip(ERROR, rates, strict=True) if w)
    return now, np.asarray(np.max(np.abs(error), axis=-1))
