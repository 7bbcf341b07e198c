"""The flow history of a material point: the one value that joins the two scales.

Whoever makes one (the deposition solver, another solver's fields, a formula) can feed a fiber;
the fiber never knows where it came from.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import Unchanging, real_array
from fibermelt.errors import HistoryError, refuse_no_count, refuse_no_number

__all__ = ["FlowHistory", "simple_shear"]

Array = NDArray[np.float64]

TRACE_TOLERANCE = 1e-8
"""Largest |trace L| / |L| of an incompressible history: rounding, not discretisation."""


@dataclass(frozen=True, eq=False)
class FlowHistory(Unchanging):
    """What a material point meets on its way, in SI units.

    Parameters
    ----------
    time : (n,) array
        Time since the start of the path [s], strictly increasing; durations (``timedelta64``) are
        taken as seconds.
    position : (n, 2) array
        Where the point is [m].
    velocity : (n, 2) array
        Velocity of the melt there [m/s].
    gradient : (n, 2, 2) array
        Velocity gradient ``L[i, j] = d u_i / d x_j`` [1/s], without trace.
    pressure : (n,) array
        Pressure of the melt [Pa], zero in the surrounding air.
    viscosity : (n,) array, optional
        Viscosity of the melt [Pa s] at its rate of deformation, > 0.

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

    def __post_init__(self) -> None:
        """Take the numbers over, and refuse what no incompressible melt can do."""
        names = ["time", "position", "velocity", "gradient", "pressure"]
        names += ["viscosity"] if self.viscosity is not None else []
        for name in names:
            value = getattr(self, name)
            numbers = real_array(
                f"history: {name}", value, error=HistoryError, duration=name == "time"
            )
            object.__setattr__(self, name, np.array(numbers))
        super().__post_init__()
        n = self.time.size
        shapes = {
            "time": (n,),
            "position": (n, 2),
            "velocity": (n, 2),
            "gradient": (n, 2, 2),
            "pressure": (n,),
            "viscosity": (n,),
        }
        for name in names:
            shape = shapes[name]
            value = getattr(self, name)
            if value.shape != shape:
                msg = f"history: {name} has shape {value.shape}, expected {shape} like time"
                raise HistoryError(msg)
            if not np.all(np.isfinite(value)):
                bad = int(np.flatnonzero(~np.isfinite(value.reshape(n, -1)).all(axis=1))[0])
                msg = f"history: {name}[{bad}] = {value[bad]} is not finite"
                raise HistoryError(msg)
        if self.viscosity is not None and not np.all(self.viscosity > 0):
            bad = int(np.argmin(self.viscosity))
            msg = f"history: viscosity[{bad}] = {self.viscosity[bad]:g} Pa s must be positive"
            raise HistoryError(msg)
        _refuse_still(self.time)
        trace = np.abs(np.trace(self.gradient, axis1=1, axis2=2))
        size = np.linalg.norm(self.gradient, axis=(1, 2))
        worst = int(np.argmax(trace - TRACE_TOLERANCE * size))
        if trace[worst] > TRACE_TOLERANCE * size[worst]:
            msg = (
                f"history: gradient[{worst}] has trace {trace[worst]:.3g} 1/s; an incompressible "
                f"melt has none (bound {TRACE_TOLERANCE:g} |L|): remove it before"
            )
            raise HistoryError(msg)

    def __len__(self) -> int:
        """Return the number of points on the path."""
        return int(self.time.shape[0])

    @property
    def strain_rate(self) -> Array:
        """Return ``D = (L + L^T)/2`` [1/s], shape (n, 2, 2) (the paper's Gamma of Eq. 4)."""
        return 0.5 * (self.gradient + self.gradient.swapaxes(-1, -2))

    @property
    def spin(self) -> Array:
        """Return ``W_21 = (dv/dx - du/dy)/2`` [1/s], shape (n,): the melt's own rotation."""
        spin: Array = 0.5 * (self.gradient[:, 1, 0] - self.gradient[:, 0, 1])
        return spin

    @property
    def shear_rate(self) -> Array:
        """Return ``gamma_dot = sqrt(2 D:D)`` [1/s], shape (n,) (below the paper's Eq. 4)."""
        D = self.strain_rate
        rate: Array = np.sqrt(2.0 * np.einsum("nij,nij->n", D, D))
        return rate

    @property
    def direction(self) -> Array:
        """Return the angle of the velocity from the x axis [rad], continuous along the path."""
        return np.unwrap(np.arctan2(self.velocity[:, 1], self.velocity[:, 0]))


def _refuse_still(time: Array) -> None:
    """Refuse times that are too few or do not increase."""
    if time.size < 2:
        msg = f"history: {time.size} points of time: a path has at least 2"
        raise HistoryError(msg)
    still = np.flatnonzero(np.diff(time) <= 0.0)
    if still.size:
        k = int(still[0])
        msg = (
            f"history: time must increase strictly, but time[{k + 1}] = {time[k + 1]:.12g} s "
            f"follows {time[k]:.12g} s: leave out points that are met twice"
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
