"""The support function of a closed curve, tabulated once and then read at any angle.

``h(phi) = max_s e(phi).P(s)`` with ``e = (cos phi, sin phi)``. At the maximum ``P'.e = 0``, hence
by the envelope theorem ``h' = P.e'`` with ``e' = (-sin phi, cos phi)``, and the maximum's own
drift gives ``h''``: all three are exact at every knot, and quintic Hermite pieces lie between.
Where two stretches of the curve compete the maximum jumps from one to the other and ``h`` has a
corner; both branches are then continued from their own knot, and the larger one holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConvergenceError
from fibermelt.fiber.curve import TrigonometricCurve, fold_angle

__all__ = ["SupportFunction"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

SUPPORT_TOLERANCE = 1e-8
"""Interpolation error of ``h`` over its largest value: the finite elements leave 1e-5."""

FEWEST_KNOTS = 512
MOST_KNOTS = 1 << 16
"""Knots of the table: doubled until the tolerance is met. 2^16 resolve a spheroid of ratio 500 and
an ellipse of 2000, in half a minute; 100 takes a quarter of a second."""

FINE = 1 << 16
"""Phases of a table without interpolation: 5e-5 of the largest ``h``, in the cache."""

JUMP_FRACTION = 0.25
"""Part of the maximum's way between two knots that its own drift leaves unexplained: above it, the
maximum may have jumped, and the two ends' branches are kept apart."""

STILL = 1e-9
"""A way below which the maximum stands still [rad]: rounding of Newton's method."""


@dataclass(frozen=True, eq=False)
class _Branches:
    """A quantity between the knots: polynomial pieces, and both ends' own continuation.

    Parameters
    ----------
    pieces : (n, k) array
        ``c_0 + c_1 f + c_2 f^2 + ...``, ``f`` in [0, 1) across the interval.
    before, after : (n, 3) arrays
        Parabolas in ``f`` from the left end and in ``f - 1`` from the right end.
    """

    pieces: Array
    before: Array
    after: Array


class SupportFunction:
    """``h(phi)`` of a curve that is the same at ``s`` and ``s + pi``.

    Parameters
    ----------
    curve : TrigonometricCurve
        The curve ``s -> (P_1, P_2)``.

    Raises
    ------
    ConvergenceError
        If the table does not reach `SUPPORT_TOLERANCE` with `MOST_KNOTS` knots.
    """

    def __init__(self, curve: TrigonometricCurve) -> None:
        self.curve = curve
        self.knots = FEWEST_KNOTS
        while True:
            self._tabulate()
            error = self._midpoint_error()
            if error <= SUPPORT_TOLERANCE:
                break
            if self.knots >= MOST_KNOTS:
                msg = (
                    f"support function: interpolation error {error:.1e} with {self.knots} knots, "
                    f"bound {SUPPORT_TOLERANCE:g}: the pressure varies too steeply over the "
                    "surface; take a smaller fiber.aspect_ratio, or in a cell a domain_size "
                    "further from 2 or a finer mesh"
                )
                raise ConvergenceError(msg)
            self.knots *= 2

    def _tabulate(self) -> None:
        """Set up the pieces of ``h`` and of the maximum's place between the knots."""
        step = 2.0 * np.pi / self.knots
        phase = step * np.arange(self.knots, dtype=np.float64)
        s = self.curve.search(phase)
        drift, bend = _rates(self.curve, s, phase)
        point = self.curve.point(s)
        slope = _height(point, phase + 0.5 * np.pi)
        turn = np.roll(s, -1) - s
        turn -= np.pi * np.round(turn / np.pi)
        drifted = 0.5 * step * (drift + np.roll(drift, -1))
        value = _height(point, phase)
        rise = np.roll(value, -1) - value
        slope, drift, bend = slope * step, drift * step, 0.5 * bend * step * step
        self._height = _branches(_quintic(value, rise, slope, bend), rise, slope, bend)
        self._where = _branches(_cubic(s, turn, drift), turn, drift, np.zeros_like(s))
        self._corners = np.abs(turn - drifted) > JUMP_FRACTION * np.abs(turn) + STILL
        self._corners[self._corners] = self._branches_are_nearer(np.flatnonzero(self._corners))
        self._has_corners = bool(np.any(self._corners))

    def _branches_are_nearer(self, index: Index) -> NDArray[np.bool_]:
        """Tell where both ends' branches are nearer to ``h`` half-way than the smooth piece.

        A maximum that only moves fast, as at the tip of a slender fiber, makes no corner.
        """
        half = np.full(index.size, 0.5)
        exact = self.exact((index.astype(np.float64) + 0.5) * (2.0 * np.pi / self.knots))
        height = self._height
        smooth = np.abs(_polynomial(height.pieces[index], half) - exact)
        ends = (_parabola(height.before[index], half), _parabola(height.after[index], half - 1.0))
        return np.asarray(np.abs(np.maximum(*ends) - exact) < smooth)

    def _midpoint_error(self) -> float:
        """Return the relative error half-way between knots: at corners, and on a sample."""
        stride = max(1, self.knots // (2 * FEWEST_KNOTS))
        chosen = np.arange(0, self.knots, stride)
        chosen = np.union1d(chosen, np.flatnonzero(self._corners))
        phase = (chosen.astype(np.float64) + 0.5) * (2.0 * np.pi / self.knots)
        exact = self.exact(phase)
        return float(np.max(np.abs(self(phase) - exact)) / np.max(np.abs(exact)))

    def exact(self, phase: Array) -> Array:
        """Return ``h`` by search and Newton's method, without the table [-]."""
        s = self.curve.search(phase)
        return _height(self.curve.point(s), phase)

    def __call__(self, phase: Array) -> Array:
        """Return ``h(phase)`` [-]; any angle in radians, any shape."""
        index, f = self._locate(phase)
        return self._read(self._height, index, f)

    def both(self, phase: Array) -> tuple[Array, Array]:
        """Return ``-h(phase + pi)`` and ``h(phase)``: the lowest and the highest [-]."""
        index, f = self._locate(phase)
        lowest = self._read(self._height, (index + self.knots // 2) & (self.knots - 1), f)
        return -lowest, self._read(self._height, index, f)

    def near(self, phase: Array) -> tuple[Array, Array]:
        """Return `both` of the nearest of `FINE` phases, at a tenth of the cost [-].

        As ``|h'| = |P.e'|`` is at most the largest ``h``, it is off by ``pi/FINE`` of that at most.
        """
        index = np.rint(phase * (FINE / (2.0 * np.pi))).astype(np.intp) & (FINE - 1)
        return -self._fine[(index + FINE // 2) & (FINE - 1)], self._fine[index]

    @cached_property
    def _fine(self) -> Array:
        """Return ``h`` at `FINE` phases."""
        return self((2.0 * np.pi / FINE) * np.arange(FINE, dtype=np.float64))

    def where(self, phase: Array) -> Array:
        """Return the eccentric angle of the maximum [rad], in (-pi/2, pi/2], from the table.

        Both ends of a fiber see the same pressure; of ``s`` and ``s + pi`` the one in the half
        around the tip ``s = 0`` is named. Where the pressure is flat (a slender fiber that neither
        stretches nor is compressed along its axis) the angle is less certain than the pressure.
        """
        index, f = self._locate(phase)
        return fold_angle(self._read(self._where, index, f))

    def where_exact(self, phase: Array) -> Array:
        """Return `where` refined by Newton's method on the curve itself [rad]."""
        phase = np.asarray(phase, dtype=np.float64)
        return fold_angle(self.curve.maximise(phase, self.where(phase)))

    def _locate(self, phase: Array) -> tuple[Index, Array]:
        """Return the interval of each phase and the fraction of it."""
        scaled = np.asarray(phase) * (self.knots / (2.0 * np.pi))
        floor = np.floor(scaled)
        return floor.astype(np.intp) & (self.knots - 1), scaled - floor

    def _read(self, branches: _Branches, index: Index, f: Array) -> Array:
        """Return the pieces' values, or at a corner those of the branch that is higher."""
        value = _polynomial(branches.pieces[index], f)
        if self._has_corners:
            here = np.nonzero(self._corners[index])
            at, g = index[here], f[here]
            height = self._height
            first = _parabola(height.before[at], g) >= _parabola(height.after[at], g - 1.0)
            value[here] = np.where(
                first, _parabola(branches.before[at], g), _parabola(branches.after[at], g - 1.0)
            )
        return value

    @property
    def largest(self) -> float:
        """Return the largest ``h`` over every orientation [-]: ``max_s |P(s)|``, exact."""
        return self.curve.farthest

    @cached_property
    def smallest(self) -> float:
        """Return the smallest ``h`` over every orientation [-].

        By repeated subdivision of the knots' interval that holds it: ``h`` may have a corner there.
        """
        step = 2.0 * np.pi / self.knots
        knots = step * np.arange(self.knots, dtype=np.float64)
        centre = float(knots[np.argmin(self._height.pieces[:, 0])])
        lowest = float(np.min(self._height.pieces[:, 0]))
        for _ in range(12):
            phase = np.asarray(centre + step * np.linspace(-1.0, 1.0, 17), dtype=np.float64)
            values = self.exact(phase)
            centre, lowest = float(phase[np.argmin(values)]), float(np.min(values))
            step /= 8.0
        return lowest


def _height(point: Array, phase: Array) -> Array:
    value: Array = np.cos(phase) * point[..., 0] + np.sin(phase) * point[..., 1]
    return value


def _polynomial(coefficients: Array, f: Array) -> Array:
    value: Array = np.array(coefficients[..., -1])
    for k in range(coefficients.shape[-1] - 2, -1, -1):
        value *= f
        value += coefficients[..., k]
    return value


def _parabola(coefficients: Array, f: Array) -> Array:
    value: Array = (coefficients[:, 2] * f + coefficients[:, 1]) * f + coefficients[:, 0]
    return value


def _quintic(value: Array, rise: Array, slope: Array, bend: Array) -> Array:
    """Return the quintic pieces that meet values, slopes and half curvatures at both ends."""
    after_slope, after_bend = np.roll(slope, -1), np.roll(bend, -1)
    a = rise - slope - bend
    b = after_slope - slope - 2.0 * bend
    c = after_bend - bend
    return np.stack(
        [
            value,
            slope,
            bend,
            10.0 * a - 4.0 * b + c,
            -15.0 * a + 7.0 * b - 2.0 * c,
            6.0 * a - 3.0 * b + c,
        ],
        axis=-1,
    )


def _cubic(value: Array, rise: Array, slope: Array) -> Array:
    """Return the cubic pieces that meet values and slopes at both ends."""
    after = np.roll(slope, -1)
    return np.stack(
        [value, slope, 3.0 * rise - 2.0 * slope - after, slope + after - 2.0 * rise], axis=-1
    )


def _branches(pieces: Array, rise: Array, slope: Array, bend: Array) -> _Branches:
    """Add both ends' own parabolas to the pieces.

    At the right end an angle is its left neighbour plus the rise, so that no half turn enters.
    """
    value = pieces[:, 0]
    before = np.stack([value, slope, bend], axis=-1)
    after = np.stack([value + rise, np.roll(slope, -1), np.roll(bend, -1)], axis=-1)
    return _Branches(pieces, before, after)


def _rates(curve: TrigonometricCurve, s: Array, phase: Array) -> tuple[Array, Array]:
    """Return ``ds/dphi`` of the maximum and the curvature ``h''``.

    ``P'.e = 0`` moves along by ``P''.e ds + P'.e' dphi = 0``; then ``h'' = -h + P'.e' ds/dphi``.
    Where the curve is flat along ``e`` the maximum has no rate, and none is used.
    """
    first, second = curve.derivatives(s)
    along = _height(second, phase)
    across = _height(first, phase + 0.5 * np.pi)
    moving = along < 0.0
    drift = np.where(moving, -across / np.where(moving, along, -1.0), 0.0)
    return drift, across * drift - _height(curve.point(s), phase)
