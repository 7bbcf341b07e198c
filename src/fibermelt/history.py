"""The flow history of a material point: the one value that joins the two scales.

Whoever makes one (the deposition solver, another solver's fields, a formula) can feed a fiber;
the fiber never knows where it came from. A history is in space; one that stays in a plane says so,
and is followed there at no more cost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import Unchanging, read_only, real_array
from fibermelt.errors import HistoryError, refuse_no_count, refuse_no_number, refuse_other

__all__ = ["Consistency", "FlowHistory", "simple_shear"]

Array = NDArray[np.float64]

TRACE_TOLERANCE = 1e-8
"""Largest |trace L| / |L| of an incompressible history: rounding, not discretisation."""

ATMOSPHERE = 101325.0
"""Standard pressure of the air [Pa]."""

LARGEST_MISS = 0.1
"""Part of a history's own changes by which its data may disagree before it is told: the paper's
bead, whose gradient is recovered from finite elements, has 1e-3."""


FAINT = 1e-3
"""Strain over a path, and change of the velocity in its parts, below which neither can be told from
the rounding of the data, and no fiber turns."""

FEWEST = 0.02
"""Part of the strain that every second point may miss before it is told: 200 points of the paper's
streamline 7 have 0.006, 100 have 0.025 and 52, with which a pressure is a fifth off, 0.08."""


@dataclass(frozen=True)
class Consistency:
    """How well the data of a history agree with one another; all are zero for an exact one.

    Parameters
    ----------
    transport : float
        ``dx/dt = u``: what positions and velocities disagree by, summed over the intervals, in
        parts of the way [-].
    steadiness : float
        ``du/dt = L u`` of a steady flow: the same of velocities and gradients, in parts of the
        most that such gradients could change such velocities, ``int |L| |u| dt`` [-]; where paths
        are straight nothing changes, and what is left of rounding is no part of it.
    coarseness : float
        What every second point says wrong of the gradient between, as the strain that it stands
        for, in parts of the whole strain [-]: the square of the points' spacing.
    told : tuple of str
        What does not fit, in words, with how much and what it may come from; empty if all does.
    """

    transport: float
    steadiness: float
    coarseness: float
    told: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class FlowHistory(Unchanging):
    """What a material point meets on its way, in SI units; or several points, stacked.

    Every array has the axes ``(..., n)`` of the paths' points: ``(n,)`` for one path, leading axes
    for several of equal length (`FlowHistory.stack`). A path in the plane may be given with two
    components, and has the third as zeros.

    Parameters
    ----------
    time : (..., n) array
        Time since the start of the path [s], strictly increasing; durations (``timedelta64``) are
        taken as seconds.
    position : (..., n, 3) or (..., n, 2) array
        Where the point is [m].
    velocity : (..., n, 3) or (..., n, 2) array
        Velocity of the melt there [m/s].
    gradient : (..., n, 3, 3) or (..., n, 2, 2) array
        Velocity gradient ``L[i, j] = d u_i / d x_j`` [1/s], without trace.
    pressure : (..., n) array
        Pressure of the melt [Pa], zero in the surrounding air.
    viscosity : (..., n) array, optional
        Viscosity of the melt [Pa s] at its rate of deformation, > 0.
    temperature : (..., n) array, optional
        Temperature of the melt [K], > 0.

    Raises
    ------
    HistoryError
        If shapes disagree, a value is no real number or not finite, time does not increase, or
        ``L`` has a trace.

    Notes
    -----
    The arrays are copies, and read-only, in copies of a history, too: what was computed from one
    may be kept for it.
    """

    time: Array
    position: Array
    velocity: Array
    gradient: Array
    pressure: Array
    viscosity: Array | None = None
    temperature: Array | None = None

    def __post_init__(self) -> None:
        """Take the numbers over, and refuse what no incompressible melt can do."""
        for name in self.quantities:
            value = getattr(self, name)
            numbers = real_array(
                f"history: {name}", value, error=HistoryError, duration=name == "time"
            )
            object.__setattr__(self, name, np.array(numbers))
        self._take_shape()
        super().__post_init__()
        for name in self.quantities:
            _refuse_infinite(name, getattr(self, name), self.time.ndim)
        for name, unit in (("viscosity", "Pa s"), ("temperature", "K")):
            _refuse_negative(name, getattr(self, name), unit)
        _refuse_still(self.time)
        _refuse_trace(self.__dict__.get("plane_gradient", self.gradient))

    def _take_shape(self) -> None:
        """Embed what is given in a plane, and refuse shapes that disagree."""
        axes = self.time.shape
        if not axes:
            msg = "history: time has shape (), expected (..., n) with n points, at least 2"
            raise HistoryError(msg)
        if axes[-1] < 2:
            msg = (
                f"history: time has shape {axes}, {axes[-1]} points of time: a path has at least 2"
            )
            raise HistoryError(msg)
        d = 2 if self.position.shape == (*axes, 2) else 3
        tails = {"position": (d,), "velocity": (d,), "gradient": (d, d)}
        for name in self.quantities:
            value, shape = getattr(self, name), (*axes, *tails.get(name, ()))
            if value.shape != shape:
                msg = f"history: {name} has shape {value.shape}, expected {shape} like time"
                raise HistoryError(msg)
            if name in tails and d == 2:
                if name == "gradient":  # known without looking at the numbers
                    self.__dict__.update(planar=True, plane_gradient=read_only(value))
                across = [(0, 0)] * len(axes) + [(0, 1)] * len(tails[name])
                object.__setattr__(self, name, np.pad(value, across))

    @classmethod
    def stack(cls, histories: Sequence[FlowHistory]) -> FlowHistory:
        """Return histories of equal number of points as one, along a new leading axis.

        Raises
        ------
        HistoryError
            If there is none, or their numbers of points differ.
        ConfigError
            If one is no history.
        """
        refuse_other("histories", histories, Sequence)
        for k, history in enumerate(histories):
            refuse_other(f"histories[{k}]", history, FlowHistory)
        lengths = sorted({len(history) for history in histories})
        if len(lengths) != 1 or len({history.time.shape for history in histories}) != 1:
            msg = (
                f"histories of {lengths or 'no'} points cannot be stacked: trace them with one "
                "number of points, or follow them one by one"
            )
            raise HistoryError(msg)
        return cls(
            **{
                name: np.stack([getattr(history, name) for history in histories])
                for name in QUANTITIES
                if all(getattr(history, name) is not None for history in histories)
            }
        )

    @classmethod
    def from_csv(cls, file: str | Path) -> FlowHistory:
        """Read a history from a table, several paths stacked: see `fibermelt.path_table`.

        Parameters
        ----------
        file : str or Path
            CSV: a line for each point, columns ``time, x, y, z, u, v, w, pressure, L_xx, ...``
            with their units in brackets, and ``path`` where there are several.

        Raises
        ------
        ConfigError, HistoryError
            As in `fibermelt.path_table.read_paths`.
        """
        from fibermelt.path_table import as_many_points, read_paths  # noqa: PLC0415  a circle else

        found = as_many_points(read_paths(file).histories)
        return found[0] if len(found) == 1 else cls.stack(found)

    def __len__(self) -> int:
        """Return the number of points on a path."""
        return int(self.time.shape[-1])

    def __repr__(self) -> str:
        """Return what it is, in a line."""
        paths = (
            "" if self.time.ndim == 1 else f"{' x '.join(map(str, self.time.shape[:-1]))} paths, "
        )
        where = "in the plane" if self.planar else "in space"
        return (
            f"FlowHistory({paths}{len(self)} points {where}, {np.max(self.time):.3g} s, strain "
            f"{np.max(self.strain):.3g}, pressure {self.pressure.min():.3g} to "
            f"{self.pressure.max():.3g} Pa)"
        )

    @property
    def quantities(self) -> tuple[str, ...]:
        """Return the names of what is known at the points."""
        known = (name for name in OPTIONAL if getattr(self, name) is not None)
        return (*(name for name in QUANTITIES if name not in OPTIONAL), *known)

    @cached_property
    def planar(self) -> bool:
        """Tell whether nothing leaves a plane z = const, neither the path nor the flow there."""
        across = (self.gradient[..., 2, :], self.gradient[..., :, 2], self.velocity[..., 2])
        z = self.position[..., 2]
        return not any(np.any(part) for part in across) and bool(np.all(z == z[..., :1]))

    @cached_property
    def plane_gradient(self) -> Array:
        """Return the gradient's part in the plane of x and y [1/s], (..., n, 2, 2)."""
        return np.ascontiguousarray(self.gradient[..., :2, :2])

    @cached_property
    def lines(self) -> tuple[FlowHistory, ...]:
        """Return the paths one by one; a single path alone."""
        if self.time.ndim == 1:
            return (self,)
        n = len(self)
        rows = int(np.prod(self.time.shape[:-1]))
        tails = {name: getattr(self, name).shape[self.time.ndim :] for name in self.quantities}
        flat = {name: getattr(self, name).reshape(rows, n, *tail) for name, tail in tails.items()}
        return tuple(
            FlowHistory(**{name: values[k] for name, values in flat.items()}) for k in range(rows)
        )

    def every_second(self) -> FlowHistory:
        """Return the history of every second point, the last one among them.

        What is computed from it differs from the whole's by an estimate of the error that the
        points' spacing makes; for one of order two or more it is an overestimate.

        Raises
        ------
        HistoryError
            If there are fewer than 3 points.
        """
        keep = np.arange(len(self)) % 2 == (len(self) - 1) % 2
        keep[0] = True
        lead = self.time.ndim - 1
        return FlowHistory(
            **{name: getattr(self, name).compress(keep, axis=lead) for name in self.quantities}
        )

    def time_across(self, axis: int, place: float) -> Array:
        """Return when each path first reaches a plane across x, y or z [s], (...); NaN if never.

        Parameters
        ----------
        axis : int
            0, 1 or 2: the axis that the plane lies across.
        place : float
            Where on it [m]. A path that begins in the plane is there at once. Between points the
            time is linear in the distance, second order in their spacing.
        """
        away = self.position[..., axis] - place
        away = away * np.where(away[..., :1] < 0.0, -1.0, 1.0)
        there = away <= 0.0
        after = np.argmax(there, axis=-1)[..., None]
        before = np.maximum(after - 1, 0)
        a, b = (np.take_along_axis(away, at, axis=-1) for at in (before, after))
        start, end = (np.take_along_axis(self.time, at, axis=-1) for at in (before, after))
        part = a / np.where(after > 0, a - b, 1.0)
        when = np.where(after > 0, start + part * (end - start), start)
        return np.asarray(np.where(there.any(axis=-1), when[..., 0], np.nan))

    @property
    def strain_rate(self) -> Array:
        """Return ``D = (L + L^T)/2`` [1/s], shape (..., n, 3, 3) (the paper's Gamma of Eq. 4)."""
        return 0.5 * (self.gradient + self.gradient.swapaxes(-1, -2))

    @property
    def spin(self) -> Array:
        """Return ``W_21 = (dv/dx - du/dy)/2`` [1/s], (..., n): the melt's rotation about z."""
        spin: Array = 0.5 * (self.gradient[..., 1, 0] - self.gradient[..., 0, 1])
        return spin

    @property
    def shear_rate(self) -> Array:
        """Return ``gamma_dot = sqrt(2 D:D)`` [1/s], shape (..., n) (below the paper's Eq. 4)."""
        D = self.strain_rate
        rate: Array = np.sqrt(2.0 * np.einsum("...ij,...ij->...", D, D))
        return rate

    @property
    def strain(self) -> Array:
        """Return ``int gamma_dot dt`` over each path [-], shape (...), by the trapezoidal rule."""
        return np.asarray(np.trapezoid(self.shear_rate, self.time, axis=-1))

    @property
    def direction(self) -> Array:
        """Return the angle of the velocity from the x axis [rad], (..., n), continuous in time.

        As seen along z. A melt at rest has no direction; it is given the x axis.
        """
        angle = np.arctan2(self.velocity[..., 1], self.velocity[..., 0])
        return np.asarray(np.unwrap(angle, axis=-1))

    def consistency(self) -> Consistency:
        """Return how well position, velocity and gradient agree, and what does not, in words.

        Intervals are integrated by the trapezoidal rule, so that a line of few points is told, too.
        """
        speed = np.linalg.norm(self.velocity, axis=-1)
        able = speed * np.linalg.norm(self.gradient, axis=(-2, -1))
        transport = _miss(self.position, self.velocity, speed, self.time)
        flow, turned = (
            np.einsum(f"...{axes},...j->...i", self.gradient, self.velocity)
            for axes in ("ij", "ji")
        )
        least = FAINT * float(np.sum(np.max(speed, axis=-1)))
        steadiness = _miss(self.velocity, flow, able, self.time, least)
        transposed = _miss(self.velocity, turned, able, self.time, least)
        coarseness = _coarseness(self.gradient, self.time)
        told = []
        if transport > LARGEST_MISS:
            told.append(
                f"positions and velocities disagree by {transport:.2g} of the way (dx/dt = u): "
                "check the units of length, velocity and time, or take more points"
            )
        if steadiness > LARGEST_MISS and transposed < 0.5 * steadiness:
            told.append(
                f"the gradient seems to be transposed: du/dt = L u misses by {steadiness:.2g} of "
                f"what could change, with L^T by {transposed:.2g}; L[i, j] is d u_i/d x_j"
            )
        elif steadiness > LARGEST_MISS:
            told.append(
                f"velocities and gradients disagree by {steadiness:.2g} of what could change "
                "(du/dt = L u): the flow is not steady, the gradient poor, or the points too few"
            )
        if coarseness > FEWEST:
            told.append(
                f"{len(self)} points are few: every second one misses {coarseness:.2g} of the "
                "strain; take more points"
            )
        ends = self.pressure[..., -1]
        if np.all(np.abs(ends - ATMOSPHERE) < 0.05 * ATMOSPHERE):
            told.append(
                f"pressure ends at {float(np.mean(ends)):.6g} Pa, that of the air: it seems to be "
                "absolute; here it is zero in the surrounding air, so subtract 101325 Pa"
            )
        return Consistency(transport, steadiness, coarseness, tuple(told))


QUANTITIES = tuple(field.name for field in fields(FlowHistory))
"""What can be known at the points of a path."""

OPTIONAL = ("viscosity", "temperature")
"""What need not be."""


def _miss(values: Array, rate: Array, size: Array, time: Array, least: float = 0.0) -> float:
    """Return how far ``values`` (..., n, 3) are from the integral of their rate.

    In parts of the largest of their way, the integral of the rate's ``size`` (..., n), and
    ``least``.
    """
    step = np.diff(time, axis=-1)
    gone = np.diff(values, axis=-2)
    said = 0.5 * step[..., None] * (rate[..., 1:, :] + rate[..., :-1, :])
    able = float(np.sum(0.5 * step * (size[..., 1:] + size[..., :-1])))
    whole = max(_length(gone), able, least)
    return _length(gone - said) / whole if whole > 0.0 else 0.0


def _length(moves: Array) -> float:
    """Return the sum of the sizes of vectors."""
    return float(np.sum(np.linalg.norm(moves, axis=-1)))


def _coarseness(gradient: Array, time: Array) -> float:
    """Return what linear interpolation between every second point misses of the gradient [-]."""
    if time.shape[-1] < 3:
        return 1.0
    step = time[..., 2:] - time[..., :-2]
    part = ((time[..., 1:-1] - time[..., :-2]) / step)[..., None, None]
    between = (1.0 - part) * gradient[..., :-2, :, :] + part * gradient[..., 2:, :, :]
    miss = np.linalg.norm(gradient[..., 1:-1, :, :] - between, axis=(-2, -1))
    whole = float(np.sum(step * np.linalg.norm(gradient[..., 1:-1, :, :], axis=(-2, -1))))
    return float(np.sum(step * miss)) / max(whole, 2.0 * FAINT * time[..., 0].size)


def _refuse_infinite(name: str, value: Array, axes: int) -> None:
    """Refuse what is not finite, with its place."""
    if np.all(np.isfinite(value)):
        return
    points = np.isfinite(value.reshape(*value.shape[:axes], -1)).all(axis=-1)
    where = tuple(int(k) for k in np.argwhere(~points)[0])
    msg = f"history: {name}[{', '.join(map(str, where))}] = {value[where]} is not finite"
    raise HistoryError(msg)


def _refuse_negative(name: str, value: Array | None, unit: str) -> None:
    """Refuse what is not positive, with its place."""
    if value is None or np.all(value > 0.0):
        return
    where = tuple(int(k) for k in np.unravel_index(np.argmin(value), value.shape))
    place = ", ".join(map(str, where))
    msg = f"history: {name}[{place}] = {value[where]:g} {unit} must be positive"
    raise HistoryError(msg)


def _refuse_still(time: Array) -> None:
    """Refuse times that do not increase."""
    still = np.argwhere(np.diff(time, axis=-1) <= 0.0)
    if still.size:
        *lead, k = (int(i) for i in still[0])
        line, place = time[tuple(lead)], ", ".join(map(str, (*lead, k + 1)))
        msg = (
            f"history: time must increase strictly, but time[{place}] = {line[k + 1]:.12g} s "
            f"follows {line[k]:.12g} s: leave out points that are met twice"
        )
        raise HistoryError(msg)


def _refuse_trace(gradient: Array) -> None:
    """Refuse gradients of a flow that swells or shrinks."""
    trace = np.abs(np.trace(gradient, axis1=-2, axis2=-1))
    excess = trace - TRACE_TOLERANCE * np.linalg.norm(gradient, axis=(-2, -1))
    where = tuple(int(k) for k in np.unravel_index(np.argmax(excess), excess.shape))
    if excess[where] > 0.0:
        msg = (
            f"history: gradient[{', '.join(map(str, where))}] has trace {trace[where]:.3g} 1/s; "
            f"an incompressible melt has none (bound {TRACE_TOLERANCE:g} |L|): remove it before"
        )
        raise HistoryError(msg)


def simple_shear(rate: float, duration: float, points: int = 201) -> FlowHistory:
    """Return the history of the origin of the simple shear ``u_x = rate y``.

    Parameters
    ----------
    rate : float
        Shear rate [1/s].
    duration : float
        Length of the history [s].
    points : int
        Number of points on it.

    Raises
    ------
    ConfigError
        If rate or duration is no number, or the points no whole one.
    HistoryError
        If they are not finite, the duration is not positive, or the points are fewer than two.
    """
    refuse_no_number("rate", rate)
    refuse_no_number("duration", duration)
    refuse_no_count("points", points, 0)
    gradient = np.zeros((points, 2, 2))
    gradient[:, 0, 1] = rate
    return FlowHistory(
        time=np.linspace(0.0, duration, points),
        position=np.zeros((points, 2)),
        velocity=np.zeros((points, 2)),
        gradient=gradient,
        pressure=np.zeros(points),
    )
