"""The pressure on a moving fiber's surface, at every step, by its support function.

All pressures are relative to the streamline's ``p_psi`` [Pa]. With ``D = d (cos 2 beta, sin 2
beta)`` in the axes of the flow and the fiber at ``theta`` the phase is ``phi = 2 (beta - theta)``:
highest ``mu d h(phi)``, lowest ``-mu d h(phi + pi)`` (see `fibermelt.fiber.response`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import Unchanging
from fibermelt.errors import refuse_other
from fibermelt.fiber.checks import checked_positive
from fibermelt.fiber.motion import Turning
from fibermelt.fiber.paths import Path, checked_path, refuse_another_path, strain_polar
from fibermelt.fiber.response import FiberResponse

__all__ = [
    "PressureBounds",
    "SurfaceHistory",
    "SurfacePressure",
    "checked_viscosity",
    "pressure_bounds",
    "surface_pressure",
]

Array = NDArray[np.float64]


class SurfaceHistory(Protocol):
    """Pressure extremes on fibers along a path, by whichever way they were found."""

    @property
    def lowest(self) -> Array:
        """Lowest pressure over the surface [Pa], relative, shape (..., n_angles, n)."""

    @property
    def highest(self) -> Array:
        """Highest pressure over the surface [Pa], relative, shape (..., n_angles, n)."""

    @property
    def path(self) -> Path:
        """The path."""

    def where_at(self, index: NDArray[np.intp]) -> Array:
        """Return the eccentric angles [rad] of the extremes at given points of the path.

        Parameters
        ----------
        index : (..., n_angles, location, 2) integer array
            Points of the path, last axis: for the lowest, for the highest.
        """


@dataclass(frozen=True, eq=False)
class SurfacePressure(Unchanging):
    """Lowest and highest pressure on the surface along the way.

    Parameters
    ----------
    lowest, highest : (..., n_angles, n) array
        Over the surface, relative to the streamline's pressure [Pa].
    phase : (..., n_angles, n) array
        ``2 (beta - theta)``, twice the angle from the fiber to the stretching direction [rad].
    amplitude : (..., n) array
        ``mu d`` [Pa].
    response : FiberResponse
        The fiber that answered.
    path : FlowHistory or PathBundle
        The way.
    """

    lowest: Array
    highest: Array
    phase: Array
    amplitude: Array
    response: FiberResponse
    path: Path = field(repr=False)

    @cached_property
    def where_lowest(self) -> Array:
        """Return the eccentric angle of the lowest pressure [rad] in (-pi/2, pi/2], 0 the tip."""
        return self.response.support.where(self.phase + np.pi)

    @cached_property
    def where_highest(self) -> Array:
        """Return the eccentric angle of the highest pressure [rad] in (-pi/2, pi/2], 0 the tip."""
        return self.response.support.where(self.phase)

    def where_at(self, index: NDArray[np.intp]) -> Array:
        """Return the eccentric angles [rad] of the extremes at given points of the path.

        See `SurfaceHistory.where_at`; refined by Newton's method on the curve itself.
        """
        flat = index.reshape(*index.shape[:-2], -1)
        phase = np.take_along_axis(self.phase, flat, axis=-1).reshape(index.shape)
        phase[..., 0] += np.pi
        return self.response.support.where_exact(phase)

    @cached_property
    def tip(self) -> Array:
        """Return the pressure at the fiber's tips [Pa], (..., n_angles, n)."""
        p1, p2 = self.response.tip
        shape = p1 * np.cos(self.phase) + p2 * np.sin(self.phase)
        return np.asarray(self.amplitude[..., None, :] * shape)


@dataclass(frozen=True, eq=False)
class PressureBounds:
    """What the pressure extremes of a fiber can be at a point, over every orientation.

    At any instant the map from initial angle to angle is one-to-one, so these are exact bounds for
    any set of fibers. All (..., n), relative to the streamline's pressure [Pa].

    Parameters
    ----------
    lowest, highest : (..., n) array
        Lowest and highest surface pressure in the worst orientation.
    mildest_lowest, mildest_highest : (..., n) array
        The same in the orientation that suffers least.
    """

    lowest: Array
    highest: Array
    mildest_lowest: Array
    mildest_highest: Array


def surface_pressure(
    path: Path, response: FiberResponse, viscosity: float, motion: Turning
) -> SurfacePressure:
    """Return the lowest and highest surface pressure of every fiber at every point of its path.

    Parameters
    ----------
    path : FlowHistory or PathBundle
        The path that the fibers were followed along.
    response : FiberResponse
        Their pressure response (confined or unbounded).
    viscosity : float
        ``mu`` of the melt [Pa s], positive; all pressures are proportional to it.
    motion : Turning
        Their angles along the path.

    Raises
    ------
    ConfigError
        If the viscosity is not positive, or the response is none.
    HistoryError
        If the fibers were followed along another path.
    """
    refuse_other("response", response, FiberResponse)
    refuse_another_path(path, motion.path)
    size, double = strain_polar(path.gradient)
    amplitude = checked_viscosity(viscosity) * size
    phase = double[..., None, :] - 2.0 * motion.angle
    lowest, highest = response.support.both(phase)
    lowest *= amplitude[..., None, :]
    highest *= amplitude[..., None, :]
    return SurfacePressure(lowest, highest, phase, amplitude, response, path)


def pressure_bounds(path: Path, response: FiberResponse, viscosity: float) -> PressureBounds:
    """Return the bounds of the pressure extremes over every orientation, (..., n) [Pa].

    ``-+ mu d max h`` and ``-+ mu d min h``: exact, no angle is sampled. Parameters as in
    `surface_pressure`.
    """
    refuse_other("response", response, FiberResponse)
    checked_path(path)
    size, _ = strain_polar(path.gradient)
    amplitude = checked_viscosity(viscosity) * size
    worst = amplitude * response.support.largest
    mildest = amplitude * response.support.smallest
    return PressureBounds(-worst, worst, -mildest, mildest)


def checked_viscosity(viscosity: float) -> float:
    """Return a viscosity [Pa s], or refuse it (`ConfigError`)."""
    return checked_positive("melt.viscosity", viscosity, "Pa s", "817")
