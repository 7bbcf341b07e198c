"""The support function of a closed curve, tabulated once and then read at any angle.

``h(phi) = max_s e(phi).P(s)`` with ``e = (cos phi, sin phi)``. At the maximum ``P'.e = 0``, hence
by the envelope theorem ``h' = P.e'`` with ``e' = (-sin phi, cos phi)``: value and slope are exact
at every knot, and a cubic Hermite interpolant lies between. Where two stretches of the curve
compete the maximum jumps from one to the other and ``h`` has a corner; both branches are then
continued from their own knot, and the larger one holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import factorial

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConvergenceError

__all__ = ["SupportFunction", "TrigonometricCurve"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

SUPPORT_TOLERANCE = 1e-9
"""Interpolation error of ``h`` over its largest value: the finite elements leave 1e-5."""

FEWEST_KNOTS = 1024
MOST_KNOTS = 1 << 17
"""Knots of the table: doubled until the tolerance is met; 2^17 resolve an aspect ratio of 1000."""

OVERSAMPLING = 4
"""Expansion points per sample: half a spacing is then 0.4 rad of the highest harmonic."""

TAYLOR_ORDER = 7
"""Terms of the local expansions: ``0.4^8/8!`` is below 1e-7 of a harmonic that is itself tiny."""

NEWTON_STEPS = 6
"""Newton steps on ``P'(s).e = 0``: quadratic from half an expansion spacing, three suffice."""

JUMP_ANGLE = 0.5
"""A step of the maximum between two knots above this [rad] may be a jump and is looked at."""


class TrigonometricCurve:
    """A closed curve given by samples, with Taylor expansions that replace its Fourier sum.

    Parameters
    ----------
    samples : (m, 2) array
        Points of the curve at the angles ``2 pi j/m``, repeated after half of them.
    """

    def __init__(self, samples: Array) -> None:
        half = samples[: samples.shape[0] // 2]
        n = half.shape[0]
        modes = np.fft.rfft(half, axis=0)
        if n % 2 == 0:
            modes[-1] *= 0.5  # the Nyquist mode is shared by both signs
        self.n = OVERSAMPLING * n
        self.spacing = np.pi / self.n
        wave = 2.0j * np.arange(modes.shape[0])[:, None]
        self.terms = np.stack(
            [
                np.fft.irfft(modes * wave**k, n=self.n, axis=0) * (OVERSAMPLING / factorial(k))
                for k in range(TAYLOR_ORDER + 1)
            ]
        )

    def point(self, angle: Array) -> Array:
        """Return the curve at the angles ``s`` [rad], shape ``s.shape + (2,)``."""
        index, offset = self._nearest(angle)
        value: Array = _horner(self.terms[:, index, :], offset[..., None])
        return value

    def derivatives(self, angle: Array) -> tuple[Array, Array]:
        """Return the first and the second derivative at the angles ``s``, ``s.shape + (2,)``."""
        index, offset = self._nearest(angle)
        first = _derivative(self.terms[:, index, :])
        x = offset[..., None]
        return _horner(first, x), _horner(_derivative(first), x)

    def _nearest(self, angle: Array) -> tuple[Index, Array]:
        scaled = np.asarray(angle) / self.spacing
        nearest = np.rint(scaled)
        return nearest.astype(np.intp) % self.n, (scaled - nearest) * self.spacing

    def maximise(self, phase: Array, start: Array) -> Array:
        """Return the local maximum of ``e(phase).P(s)`` next to ``start`` [rad].

        Newton's method; where the curve is flat along ``e`` (nothing to choose) it stays.
        """
        direction = np.stack([np.cos(phase), np.sin(phase)], axis=-1)
        s = np.array(start, dtype=np.float64)
        for _ in range(NEWTON_STEPS):
            index, offset = self._nearest(s)
            height = np.einsum("k...i,...i->k...", self.terms[:, index, :], direction)
            first = _horner(_derivative(height), offset)
            second = _horner(_derivative(_derivative(height)), offset)
            concave = second < 0.0
            step = np.where(concave, -first / np.where(concave, second, -1.0), 0.0)
            s += np.clip(step, -self.spacing, self.spacing)
        return s

    def search(self, phase: Array) -> Array:
        """Return the global maximum of ``e(phase).P(s)`` as an angle in (-pi/2, pi/2] [rad]."""
        flat = np.ravel(phase)
        start = np.empty(flat.shape)
        block = max(1, (1 << 20) // self.n)
        for at in range(0, flat.size, block):
            part = flat[at : at + block]
            heights = np.stack([np.cos(part), np.sin(part)], axis=-1) @ self.terms[0].T
            start[at : at + block] = np.argmax(heights, axis=1) * self.spacing
        best = self.maximise(flat, start)
        return _fold(best).reshape(np.shape(phase))


def _horner(coefficients: Array, x: Array) -> Array:
    value: Array = coefficients[-1]
    for term in coefficients[-2::-1]:
        value = value * x + term
    return value


def _derivative(coefficients: Array) -> Array:
    powers = np.arange(1, coefficients.shape[0]).reshape((-1,) + (1,) * (coefficients.ndim - 1))
    derived: Array = coefficients[1:] * powers
    return derived


def _fold(angle: Array) -> Array:
    """Return the angle in (-pi/2, pi/2]: the two ends of a fiber are not told apart."""
    folded: Array = angle - np.pi * np.ceil(angle / np.pi - 0.5)
    return folded


@dataclass(frozen=True, eq=False)
class _Branches:
    """A quantity at the knots of each interval: cubic pieces, and both ends' own continuation.

    Parameters
    ----------
    pieces : (n, 4) array
        ``c_0 + c_1 f + c_2 f^2 + c_3 f^3``, ``f`` in [0, 1) across the interval.
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
                    f"bound {SUPPORT_TOLERANCE:g}: the surface pressure is too rough, refine the "
                    "cell or take a domain_size further from 2"
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
        self._corners = np.abs(turn) > JUMP_ANGLE
        self._has_corners = bool(np.any(self._corners))
        value = _height(point, phase)
        rise = np.roll(value, -1) - value
        self._height = _branches(value, rise, slope * step, 0.5 * bend * step * step)
        self._where = _branches(s, turn, drift * step, np.zeros_like(s))

    def _midpoint_error(self) -> float:
        """Return the relative error half-way between knots, on a sample of the intervals."""
        stride = max(1, self.knots // (2 * FEWEST_KNOTS))
        middle = np.arange(0, self.knots, stride, dtype=np.float64) + 0.5
        phase = middle * (2.0 * np.pi / self.knots)
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

    def where(self, phase: Array) -> Array:
        """Return the eccentric angle of the maximum [rad], in (-pi/2, pi/2], from the table.

        Both ends of a fiber see the same pressure; of ``s`` and ``s + pi`` the one in the half
        around the tip ``s = 0`` is named. Where the pressure is flat (a slender fiber that neither
        stretches nor is compressed along its axis) the angle is less certain than the pressure.
        """
        index, f = self._locate(phase)
        return _fold(self._read(self._where, index, f))

    def where_exact(self, phase: Array) -> Array:
        """Return `where` refined by Newton's method on the curve itself [rad]."""
        phase = np.asarray(phase, dtype=np.float64)
        return _fold(self.curve.maximise(phase, self.where(phase)))

    def _locate(self, phase: Array) -> tuple[Index, Array]:
        """Return the interval of each phase and the fraction of it."""
        scaled = np.asarray(phase) * (self.knots / (2.0 * np.pi))
        floor = np.floor(scaled)
        return floor.astype(np.intp) & (self.knots - 1), scaled - floor

    def _read(self, branches: _Branches, index: Index, f: Array) -> Array:
        """Return the cubic pieces' values, or at a corner those of the branch that is higher."""
        c = branches.pieces[index]
        value: Array = ((c[..., 3] * f + c[..., 2]) * f + c[..., 1]) * f + c[..., 0]
        if self._has_corners:
            here = np.nonzero(self._corners[index])
            at, g = index[here], f[here]
            height = self._height
            first = _parabola(height.before[at], g) >= _parabola(height.after[at], g - 1.0)
            value[here] = np.where(
                first, _parabola(branches.before[at], g), _parabola(branches.after[at], g - 1.0)
            )
        return value

    @cached_property
    def largest(self) -> float:
        """Return the largest ``h`` over every orientation [-]: ``max_s |P(s)|``, exact."""
        norm = np.hypot(*self.curve.terms[0].T)
        near = np.argsort(norm)[-4:]
        s = near * self.curve.spacing
        for _ in range(NEWTON_STEPS):
            point = self.curve.point(s)
            s = self.curve.maximise(np.arctan2(point[:, 1], point[:, 0]), s)
        return float(np.max(np.hypot(*self.curve.point(s).T)))

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


def _parabola(coefficients: Array, f: Array) -> Array:
    value: Array = (coefficients[:, 2] * f + coefficients[:, 1]) * f + coefficients[:, 0]
    return value


def _branches(value: Array, rise: Array, slope: Array, bend: Array) -> _Branches:
    """Return pieces from values, rises to the next knot, slopes and half curvatures per interval.

    At the right end an angle is its left neighbour plus the rise, so that no half turn enters.
    """
    after = np.roll(slope, -1)
    pieces = np.stack(
        [value, slope, 3.0 * rise - 2.0 * slope - after, slope + after - 2.0 * rise], axis=-1
    )
    before = np.stack([value, slope, bend], axis=-1)
    return _Branches(pieces, before, np.stack([value + rise, after, np.roll(bend, -1)], axis=-1))


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
