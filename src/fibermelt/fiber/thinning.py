"""What a fiber answers to any planar flow of a melt whose viscosity depends on the rate.

The viscosity depends on the strain rate alone, so turning fiber and melt together changes nothing:
spin and surface pressure of a force- and torque-free fiber are functions of the strain's size ``d =
gamma_dot/2`` and its direction ``phi`` in the fiber's axes (``D_11 = d cos phi``, ``D_12 = d sin
phi``) and of nothing else,

    theta_dot = W_21 + d omega(gamma_dot, phi),    p(s) - p_psi = eta(gamma_dot) d P(s; gamma_dot,
    phi).

Symmetry leaves ``phi`` in [0, pi/2]: a reversed flow reverses both, so ``P(phi + pi) = -P(phi)``,
and a mirrored one has ``omega(-phi) = -omega(phi)``, ``P(s; -phi) = P(-s; phi)``. Hence ``omega``
is a series of ``sin phi, sin 3 phi, ...`` (a Newtonian melt has the first term, ``B``), and of the
lowest pressure ``l`` and the highest ``h`` the one gives the other: ``l(pi - phi) = -h(phi)``. A
power law has no rate of its own: ``omega`` and ``P`` are then the same at every rate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from fibermelt.errors import ConfigError
from fibermelt.fiber.curve import fold_angle
from fibermelt.melt import PowerLaw, ViscosityLaw

__all__ = ["UNBOUNDED_SIZE", "SpinSeries", "ThinningResponse", "bending_rates", "table_rates"]

Array = NDArray[np.float64]
Values = TypeVar("Values", NDArray[np.float64], NDArray[np.complex128])

KNOTS = 1024
"""Intervals of ``phi`` in a quarter turn between which extremes are linear: a change of place on
the surface, a corner of ``l``, is then off by 1e-4 of the largest pressure, the rest by 1e-6."""

PER_DECADE = 48
"""Intervals of the rate in a decade between which extremes are linear, off by 1e-4 at most: laws
bend over decades. The cubic between the rates that were solved for is read there."""

BLOCK = 1 << 14
"""Fibers times points that are read at a time: their arrays then stay in the cache."""

JUMP = 0.3
"""Change of place [rad] between two directions that is a jump: the extreme itself moves on by
less."""

SPIN_ROUNDING = 2e-6
"""Terms of ``omega`` that are no more than what cells are solved to."""

SPREAD = (0.3, 15.0)
"""Rates that a fiber feels over the far field's: by the slow melt at its sides, and at its tip. A
Carreau law (n = 0.35, r_e = 6, M = 4) is within 0.3 % of Newtonian below the one bound and within
0.1 % of a power law above the other."""

UNBOUNDED_SIZE = 40.0
"""``M`` of the cell that stands for a melt without end: a Newtonian ellipse is within 0.4 % of its
closed form there, and what a thinning melt feels of a fiber fades faster."""

FLAT = 0.03
"""Change of a law's index that begins its bend."""

WIDEST = (1e-6, 1e8)
"""Rates [1/s] that are searched for where a law bends."""


def bending_rates(law: ViscosityLaw, reach: float = 0.0) -> tuple[float, float]:
    """Return the rates [1/s] between which a fiber's answer changes; the same twice if none.

    Below the first and above the second the law is a power law (of index 1, or its own) all over
    the rates that a fiber makes of one, `SPREAD`, or up to ``reach`` times as high. A pure
    power law's lowest rate is a regularisation and no property of the melt, so that it is left out:
    the answer is the same at all rates.
    """
    if law.is_newtonian or isinstance(law, PowerLaw):
        return 1.0, 1.0
    rate = np.geomspace(*WIDEST, 2801)
    index = law.index_at(rate)
    bends = np.flatnonzero((np.abs(index - index[0]) > FLAT) & (np.abs(index - index[-1]) > FLAT))
    if bends.size == 0:
        return 1.0, 1.0
    return float(rate[bends[0]] / max(SPREAD[1], reach)), float(rate[bends[-1]] / SPREAD[0])


def table_rates(
    law: ViscosityLaw,
    rates: tuple[float, float] | None,
    per_decade: float,
    reach: float = 0.0,
) -> Array:
    """Return the rates [1/s] of a law's table, one if the answer is the same at all.

    Parameters
    ----------
    law : ViscosityLaw
        The melt.
    rates : (2,) tuple of float, optional
        Lowest and highest ``gamma_dot`` [1/s] that will be asked for, or one rate twice; all if not
        given.
    per_decade : float
        How many there are.
    reach : float
        As in `bending_rates`.

    Raises
    ------
    ConfigError
        If the rates are not positive or fall.
    """
    if rates is not None and not 0 < rates[0] <= rates[1] < math.inf:
        msg = f"rates = {rates} 1/s: must be positive and not fall, e.g. (1, 1000)"
        raise ConfigError(msg)
    low, high = bending_rates(law, reach)
    if low == high:
        return np.ones(1)
    if rates is not None:
        if rates[0] == rates[1]:
            return np.array(rates[:1])
        low, high = max(low, min(rates[0], 0.5 * high)), min(high, max(rates[1], 2.0 * low))
    return np.geomspace(low, high, max(4, math.ceil(per_decade * math.log10(high / low)) + 1))


@dataclass(frozen=True, eq=False)
class SpinSeries:
    """``omega = sum_k b_k sin((2k + 1) phi)`` at given rates; ``b`` has shape (k, ...)."""

    coefficients: Array

    def __call__(self, phase: Array) -> Array:
        """Return ``omega`` [-] at angles that broadcast with the rates (Clenshaw's sum)."""
        sine = np.sin(phase)
        if len(self.coefficients) == 1:
            return np.asarray(self.coefficients[0] * sine)
        twice = 2.0 - 4.0 * sine * sine  # 2 cos 2 phi
        last, before, spare = (np.empty_like(sine) for _ in range(3))
        last[...], before[...] = self.coefficients[-1], 0.0
        for b in self.coefficients[-2:0:-1]:
            np.multiply(twice, last, out=spare)  # b + twice last - before, in place
            spare += b
            spare -= before
            last, before, spare = spare, last, before
        # sin 3 phi = (twice + 1) sin phi
        return np.asarray(sine * (self.coefficients[0] + (twice + 1.0) * last - before))


@dataclass(frozen=True, eq=False)
class ThinningResponse:
    """The response of a force- and torque-free fiber in a melt that thins, as a table.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-].
    law : ViscosityLaw
        The melt that it was computed for.
    rate : (r,) array
        Rates ``gamma_dot`` [1/s], increasing; one if the answer is the same at all.
    spin : (r, k) array
        ``b_k`` [-] of ``omega = sum b_k sin((2k + 1) phi)``.
    lowest, highest, where_lowest, where_highest, tip : (r, q) array
        Of the surface pressure over ``eta(gamma_dot) d`` [-], the eccentric angles [rad] of both in
        (-pi/2, pi/2], and the pressure at the tip, at ``phi = pi j/(2 (q - 1))``.
    surface : (m,) array
        Eccentric angles in [0, pi) of ``pressure`` [rad]; may be empty.
    pressure : (r, f, m) array
        The whole surface at ``phi = pi j/(2 (f - 1))``, where it was solved for.
    spin_error, pressure_error : float
        Estimated error of ``omega`` [-], and of the extremes over the largest pressure; NaN if
        unknown.

    Raises
    ------
    ConfigError
        If shapes disagree, a number is not finite or the rates do not increase.
    """

    aspect_ratio: float
    law: ViscosityLaw
    rate: Array
    spin: Array
    lowest: Array
    highest: Array
    where_lowest: Array
    where_highest: Array
    tip: Array
    surface: Array
    pressure: Array
    spin_error: float = np.nan
    pressure_error: float = np.nan

    def __post_init__(self) -> None:
        """Take the numbers over, and refuse what is no table."""
        for name in ARRAYS:
            owned = np.array(getattr(self, name), dtype=np.float64)
            owned.setflags(write=False)
            object.__setattr__(self, name, owned)
            if not np.all(np.isfinite(owned)):
                msg = f"thinning response: {name} has values that are not finite"
                raise ConfigError(msg)
        if not (np.isfinite(self.aspect_ratio) and self.aspect_ratio >= 1):
            msg = f"response: aspect_ratio = {self.aspect_ratio:g} must be at least 1"
            raise ConfigError(msg)
        r = self.rate.size
        if (
            self.rate.shape != (r,)
            or r == 0
            or np.any(np.diff(self.rate) <= 0)
            or self.rate[0] <= 0
        ):
            msg = f"thinning response: rate = {self.rate}: must be positive and increase"
            raise ConfigError(msg)
        shape = self.lowest.shape
        for name in (*EXTREMES, "spin"):
            found = getattr(self, name).shape
            if found[0] != r or len(found) != 2 or (name != "spin" and found != shape):
                msg = f"thinning response: {name} has shape {found}, expected ({r}, ...) like rate"
                raise ConfigError(msg)

    @property
    def largest(self) -> Array:
        """Return the largest pressure over all directions, over ``eta d`` [-], (r,)."""
        return np.asarray(np.maximum(-self.lowest.min(axis=1), self.highest.max(axis=1)))

    @cached_property
    def covered(self) -> tuple[float, float]:
        """Return the rates [1/s] between which the table answers; all where the law has no bend."""
        low, high = bending_rates(self.law)
        if low == high:
            return 0.0, np.inf
        return (
            0.0 if self.rate[0] <= low * (1 + 1e-9) else float(self.rate[0]),
            np.inf if self.rate[-1] >= high * (1 - 1e-9) else float(self.rate[-1]),
        )

    def checked(self, rate: float | Array) -> Array:
        """Return rates [1/s] as an array, or refuse those that the table does not answer for."""
        rates = np.asarray(rate, dtype=np.float64)
        low, high = self.covered
        if rates.size and not (
            np.min(rates) >= low * (1 - 1e-9) and np.max(rates) <= high * (1 + 1e-9)
        ):
            msg = (
                f"gamma_dot = {np.min(rates):.4g} to {np.max(rates):.4g} 1/s: the table holds "
                f"from {low:.4g} to {high:.4g} 1/s; make one for these rates"
            )
            raise ConfigError(msg)
        return rates

    def series(self, rate: float | Array) -> SpinSeries:
        """Return ``omega`` at rates [1/s], to be read at any direction."""
        rates = self.checked(rate)
        if self.rate.size == 1:
            b = self._kept[0].reshape(-1, *(1,) * rates.ndim)
            return SpinSeries(np.broadcast_to(b, (b.shape[0], *rates.shape)))
        at = np.log(np.clip(rates, self.rate[0], self.rate[-1]))
        return SpinSeries(np.moveaxis(self._spin_spline(at), -1, 0))

    def omega(self, rate: float | Array, phase: float | Array) -> Array:
        """Return the torque-free spin relative to the melt's over ``d`` [-]; shapes broadcast."""
        rates, phases = np.broadcast_arrays(np.asarray(rate, float), np.asarray(phase, float))
        return self.series(rates)(phases)

    @property
    def terms(self) -> int:
        """Return how many terms of ``omega`` are more than the cells' own error."""
        return int(self._kept.shape[1])

    @cached_property
    def _kept(self) -> Array:
        """Return the terms of ``omega`` up to the last that is more than the cells' own error."""
        large = np.flatnonzero(np.max(np.abs(self.spin), axis=0) > SPIN_ROUNDING)
        return self.spin[:, : large[-1] + 1 if large.size else 1]

    @cached_property
    def _spin_spline(self) -> Any:
        return _spline(np.log(self.rate), self._kept)

    @cached_property
    def _table(self) -> tuple[Array, Array, Array]:
        """Return the lowest pressure, its place and the tip's over (fine rate, phi in [0, pi])."""
        parts = [
            _joined(self.lowest, self.highest),
            _joined(self.where_lowest, self.where_highest),
            _joined(self.tip, self.tip),
        ]
        if self.rate.size == 1:
            return parts[0], parts[1], parts[2]
        decades = np.log10(self.rate[-1] / self.rate[0])
        first, last = np.log(self.rate[[0, -1]])
        fine = np.linspace(first, last, 1 + int(np.ceil(PER_DECADE * decades)))
        near = np.abs(fine[:, None] - np.log(self.rate)).argmin(axis=1)
        read = [_spline(np.log(self.rate), part)(fine) for part in (parts[0], parts[2])]
        return read[0], parts[1][near], read[1]

    def _row(self, rate: float | Array, rows: int) -> Array:
        """Return where rates lie on the fine axis, [0, rows - 1]."""
        rates = self.checked(rate)
        if rows == 1:
            return np.zeros(rates.shape)
        first, last = self.rate[[0, -1]]
        at = np.log(np.clip(rates, first, last) / first) / np.log(last / first)
        return np.asarray(at * (rows - 1))

    def lowest_at(self, rate: float | Array, phase: float | Array) -> Array:
        """Return the lowest surface pressure over ``eta d`` [-]; shapes broadcast.

        That the highest is the lowest of the reversed flow, ``h(phi) = -l(phi + pi)``, needs no
        table of its own.
        """
        return self._read(self._table[0], rate, phase)

    def tip_at(self, rate: float | Array, phase: float | Array) -> Array:
        """Return the pressure at the tips over ``eta d`` [-]; shapes broadcast."""
        return self._read(self._table[2], rate, phase)

    def both_at(self, rate: Array, phase: Array) -> tuple[Array, Array]:
        """Return lowest and highest pressure over ``eta d`` [-], (..., a, n).

        As `lowest_at` of a phase and of the opposite one, which lies as far from the other end of
        the table: both are read with one look. Some fibers are taken at a time.

        Parameters
        ----------
        rate : (..., n) array
            ``gamma_dot`` [1/s] along paths.
        phase : (..., a, n) array
            ``phi`` [rad] of ``a`` fibers on each.
        """
        table = self._table[0]
        row = self._row(rate, len(table)).reshape(-1, phase.shape[-1])
        found = np.empty((2, *phase.shape))
        values = found.reshape(2, len(row), -1, phase.shape[-1])
        step = max(1, BLOCK // max(1, phase.shape[-1]))
        for line, phases in enumerate(phase.reshape(values.shape[1:])):
            for first in range(0, len(phases), step):
                some = slice(first, first + step)
                both = _Place.of(row[line], phases[some], *table.shape).read(self._both)
                values[0, line, some], values[1, line, some] = both.real, both.imag
        return found[0], found[1]

    @cached_property
    def _both(self) -> NDArray[np.complex128]:
        """Return lowest and highest pressure over (fine rate, phi in [0, pi]), to be read at once.

        As real and imaginary parts.
        """
        table = self._table[0]
        return np.asarray(table - 1j * table[:, ::-1])

    def _read(self, table: Array, rate: float | Array, phase: float | Array) -> Array:
        """Return a table's values, linear between its knots; even in the phase."""
        return _Place.of(self._row(rate, len(table)), phase, *table.shape).read(table)

    def where_lowest_at(self, rate: float | Array, phase: float | Array) -> Array:
        """Return the eccentric angle [rad] of the lowest pressure, in (-pi/2, pi/2], 0 the tip.

        That of the nearest knot: places jump where two are as low.
        """
        table = self._table[1]
        row, (left, part) = self._row(rate, len(table)), _fold(phase, table.shape[1])
        sign = np.where(_turned(phase) < 0.0, -1.0, 1.0)
        return np.asarray(sign * table[np.rint(row).astype(np.intp), left + (part > 0.5)])

    def bounds(self, rate: float | Array) -> tuple[Array, Array]:
        """Return the lowest pressure over ``eta d`` [-] of the worst and of the mildest direction.

        The highest are their opposites.
        """
        table = self._table[0]
        row = self._row(rate, len(table))
        knots = np.arange(len(table))
        return np.interp(row, knots, table.min(axis=1)), np.interp(row, knots, table.max(axis=1))

    def to_arrays(self) -> dict[str, Array]:
        """Return the table by name, for a store; the law is not among it."""
        found = {name: np.asarray(getattr(self, name)) for name in (*SCALARS, *ARRAYS)}
        return {f"thinning_{name}": value for name, value in found.items()}

    @classmethod
    def from_arrays(cls, law: ViscosityLaw, arrays: Mapping[str, Any]) -> ThinningResponse:
        """Return the table of a melt from what `to_arrays` gave."""
        scalars = {name: float(arrays[f"thinning_{name}"]) for name in SCALARS}
        taken = {name: np.asarray(arrays[f"thinning_{name}"]) for name in ARRAYS}
        values: dict[str, Any] = {**scalars, **taken}
        return cls(law=law, **values)

    @classmethod
    def from_extremes(
        cls,
        aspect_ratio: float,
        law: ViscosityLaw,
        rate: Array,
        omega: Array,
        lowest: Array,
        highest: Array,
        tip: Array,
        where: tuple[Array, Array, Array] | None = None,
    ) -> ThinningResponse:
        """Return the table of a fiber from what is known at some directions, its surface left out.

        Parameters
        ----------
        aspect_ratio, law, rate
            As for the class.
        omega : (r, k) array
            Spin over ``d`` at ``phi = pi j/(2 (k - 1))``.
        lowest, highest, tip : (r, f) array
            Extremes and tip pressure over ``eta d`` at ``f`` directions. In between, lowest and
            highest pressure are one cubic spline over half a turn, ``l(pi - phi) = -h(phi)``: as
            its place on the surface moves on, so does it, without a corner.
        where : (f,), (r, f) and (r, f) arrays, optional
            The directions [rad], from 0 up to pi/2, and eccentric angles of lowest and highest
            pressure [rad], linear in between; evenly spread, and 0, the tip, if not known.
        """
        given = [np.asarray(part, dtype=np.float64) for part in (omega, lowest, highest, tip)]
        phase = np.linspace(0.0, 0.5 * np.pi, given[1].shape[1]) if where is None else where[0]
        fine = np.linspace(0.0, 0.5 * np.pi, KNOTS + 1)
        half = np.concatenate([phase, np.pi - phase[-2::-1]])
        joined = CubicSpline(half, _joined(given[1], given[2]), axis=1)
        tips = CubicSpline(half, _joined(given[3], given[3]), axis=1)(fine)
        low, high = joined(fine), -joined(np.pi - fine)
        places = [np.zeros(low.shape)] * 2
        if where is not None:
            places = [
                np.stack([_places(fine, phase, row) for row in np.asarray(part)])
                for part in where[1:]
            ]
        return cls(
            aspect_ratio=aspect_ratio,
            law=law,
            rate=rate,
            spin=odd_sines(given[0]),
            lowest=low,
            highest=high,
            where_lowest=places[0],
            where_highest=places[1],
            tip=tips,
            surface=np.zeros(0),
            pressure=np.zeros((len(low), 0, 0)),
        )


EXTREMES = ("lowest", "highest", "where_lowest", "where_highest", "tip")
SCALARS = ("aspect_ratio", "spin_error", "pressure_error")
ARRAYS = ("rate", "spin", *EXTREMES, "surface", "pressure")


def odd_sines(values: Array) -> Array:
    """Return ``b_k`` of ``sum b_k sin((2k + 1) phi)`` from ``phi = pi j/(2 (f - 1))``, last axis.

    ``f - 1`` terms through all but the first value, which is zero.
    """
    count = values.shape[-1] - 1
    phase = 0.5 * np.pi * np.arange(1, count + 1) / count
    basis = np.sin(np.outer(phase, 2 * np.arange(count) + 1))
    return np.asarray(np.linalg.solve(basis, values[..., 1:, None])[..., 0])


def odd_cosines(values: Array) -> Array:
    """Return ``a_k`` of ``sum a_k cos((2k + 1) phi)`` alike; the last value is zero."""
    count = values.shape[-1] - 1
    phase = 0.5 * np.pi * np.arange(count) / count
    basis = np.cos(np.outer(phase, 2 * np.arange(count) + 1))
    return np.asarray(np.linalg.solve(basis, values[..., :-1, None])[..., 0])


def _joined(before: Array, after: Array) -> Array:
    """Return a row's values over [0, pi] from those over [0, pi/2], ``f(pi - phi) = -g(phi)``."""
    return np.concatenate([before, -after[:, -2::-1]], axis=1)


def _places(fine: Array, phase: Array, angle: Array) -> Array:
    """Return eccentric angles [rad] at fine phases: linear, but for jumps to another place."""
    on = np.unwrap(angle, period=np.pi)
    found = np.interp(fine, phase, on)
    left = np.minimum(np.searchsorted(phase, fine, side="right") - 1, phase.size - 2)
    nearest = left + (fine - phase[left] > 0.5 * np.diff(phase)[left])
    jumps = np.abs(np.diff(on)) > JUMP
    return fold_angle(np.where(jumps[left], on[nearest], found))


def _spline(x: Array, values: Array) -> Any:
    """Return the cubic through values at three rates or more, the straight line through two."""
    if x.size > 2:
        return CubicSpline(x, values, axis=0)
    return lambda at: values[0] + ((at - x[0]) / (x[1] - x[0]))[..., None] * (values[1] - values[0])


def _turned(phase: float | Array) -> Array:
    """Return a phase [rad] within half a turn of zero."""
    turned = np.asarray(phase, dtype=np.float64)
    return np.asarray(turned - 2.0 * np.pi * np.rint(turned / (2.0 * np.pi)))


def _fold(phase: float | Array, width: int) -> tuple[NDArray[np.intp], Array]:
    """Return the knot left of a phase folded to [0, pi], and the part of the way to the next."""
    at = np.abs(_turned(phase)) * ((width - 1) / np.pi)
    left = np.minimum(at.astype(np.intp), width - 2)
    return left, at - left


@dataclass(frozen=True, eq=False)
class _Place:
    """Where rates and phases lie in a table.

    At the knot ``at``, counted row by row, and as a ``part`` of the way to the next phase and a
    ``weight`` of the next rate.
    """

    at: NDArray[np.intp]
    part: Array
    weight: Array

    @classmethod
    def of(cls, row: Array, phase: float | Array, rows: int, width: int) -> _Place:
        """Return the place of rows and phases [rad], whose shapes broadcast."""
        upper = np.minimum(row.astype(np.intp), max(rows - 2, 0))
        left, part = _fold(phase, width)
        return cls(upper * width + left, part, row - upper)

    def read(self, table: Values) -> Values:
        """Return a table's values there, linear between its knots."""
        value = self._between(table.ravel())
        if len(table) > 1:
            value += self.weight * (self._between(table[1:].ravel()) - value)
        return value

    def _between(self, flat: Values) -> Values:
        """Return values between two phases of a row."""
        value = flat.take(self.at)
        after = flat[1:].take(self.at)
        after -= value
        after *= self.part
        after += value
        return after
