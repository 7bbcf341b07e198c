"""The pressure on a moving fiber's surface, at every step, by its support function.

All pressures are relative to the streamline's ``p_psi`` [Pa]. With ``D = d (cos 2 beta, sin 2
beta)`` in the axes of the flow and the fiber at ``theta`` the phase is ``phi = 2 (beta - theta)``:
highest ``mu d h(phi)``, lowest ``-mu d h(phi + pi)`` (see `fibermelt.fiber.response`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol, overload

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import Unchanging
from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.checks import checked_positive
from fibermelt.fiber.motion import Turning
from fibermelt.fiber.paths import checked_path, refuse_another_path, strain_polar
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.fiber.thinning_motion import ThinningPressure
from fibermelt.history import FlowHistory
from fibermelt.melt import ViscosityLaw

__all__ = [
    "LocalViscosity",
    "PressureBounds",
    "SurfaceHistory",
    "SurfacePressure",
    "Viscosity",
    "checked_viscosity",
    "newtonian_viscosity",
    "pressure_amplitude",
    "pressure_bounds",
    "surface_pressure",
]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LocalViscosity:
    """A thinning melt taken for a Newtonian one of its viscosity at the fiber.

    An approximation, hence it has to be named: the pressure is the Newtonian response's times
    ``eta(gamma_dot)`` of the far field. A fiber of ``r_e = 6`` in the paper's cell
    has 0.71 (n = 0.7) or 0.45 (n = 0.35) of it.

    Parameters
    ----------
    law : ViscosityLaw
        The melt.
    """

    law: ViscosityLaw


Viscosity = float | ViscosityLaw | LocalViscosity
"""What a pressure is taken from: ``mu`` [Pa s], a law, or a law by its local viscosity."""


class SurfaceHistory(Protocol):
    """Pressure extremes on fibers along a path, by whichever way they were found."""

    @property
    def lowest(self) -> Array:
        """Lowest pressure over the surface [Pa], relative, shape (..., n_angles, n)."""

    @property
    def highest(self) -> Array:
        """Highest pressure over the surface [Pa], relative, shape (..., n_angles, n)."""

    @property
    def path(self) -> FlowHistory:
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
    path : FlowHistory
        The way.
    """

    lowest: Array
    highest: Array
    phase: Array
    amplitude: Array
    response: FiberResponse
    path: FlowHistory = field(repr=False)

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


@overload
def surface_pressure(
    path: FlowHistory, response: FiberResponse, viscosity: Viscosity, motion: Turning
) -> SurfacePressure: ...


@overload
def surface_pressure(
    path: FlowHistory, response: ThinningResponse, viscosity: Viscosity, motion: Turning
) -> ThinningPressure: ...


def surface_pressure(
    path: FlowHistory,
    response: FiberResponse | ThinningResponse,
    viscosity: Viscosity,
    motion: Turning,
) -> SurfacePressure | ThinningPressure:
    """Return the lowest and highest surface pressure of every fiber at every point of its path.

    Parameters
    ----------
    path : FlowHistory
        The path that the fibers were followed along.
    response : FiberResponse or ThinningResponse
        Their pressure response (confined or unbounded).
    viscosity : float, ViscosityLaw or LocalViscosity
        ``mu`` of the melt [Pa s], positive; all pressures are proportional to it. A melt that thins
        has the fiber's table of that melt for a response, unless its `LocalViscosity` is asked for.
    motion : Turning
        Their angles along the path.

    Raises
    ------
    ConfigError
        If the viscosity is not positive, the response none, or one of another melt.
    HistoryError
        If the fibers were followed along another path.
    """
    _refuse_no_response(response)
    refuse_another_path(path, motion.path)
    size, double = strain_polar(path.plane_gradient)
    amplitude = pressure_amplitude(response, viscosity, size)
    phase = double[..., None, :] - 2.0 * motion.angle
    if isinstance(response, ThinningResponse):
        rate = 2.0 * size
        lowest, highest = response.both_at(rate, phase)
        lowest *= amplitude[..., None, :]
        highest *= amplitude[..., None, :]
        return ThinningPressure(lowest, highest, phase, amplitude, rate, response, path)
    lowest, highest = response.support.both(phase)
    lowest *= amplitude[..., None, :]
    highest *= amplitude[..., None, :]
    return SurfacePressure(lowest, highest, phase, amplitude, response, path)


def pressure_bounds(
    path: FlowHistory, response: FiberResponse | ThinningResponse, viscosity: Viscosity
) -> PressureBounds:
    """Return the bounds of the pressure extremes over every orientation, (..., n) [Pa].

    ``-+ mu d max h`` and ``-+ mu d min h``: exact, no angle is sampled; of a table, the extremes
    over its directions at each point's rate. Parameters as in `surface_pressure`.
    """
    _refuse_no_response(response)
    checked_path(path)
    size, _ = strain_polar(path.plane_gradient)
    amplitude = pressure_amplitude(response, viscosity, size)
    if isinstance(response, ThinningResponse):
        low, mild = response.bounds(2.0 * size)
        return PressureBounds(
            amplitude * low, -amplitude * low, amplitude * mild, -amplitude * mild
        )
    worst = amplitude * response.support.largest
    mildest = amplitude * response.support.smallest
    return PressureBounds(-worst, worst, -mildest, mildest)


def pressure_amplitude(
    response: FiberResponse | ThinningResponse, viscosity: Viscosity, size: Array
) -> Array:
    """Return what multiplies a response's pressure, ``eta d`` [Pa], at strains of size ``d``.

    Raises
    ------
    ConfigError
        If the viscosity is not positive, or the melt not the response's.
    """
    if isinstance(response, ThinningResponse):
        if viscosity != response.law:
            msg = (
                f"melt {viscosity}: the fiber's table is of {response.law}; give that one, or make "
                "a table for this"
            )
            raise ConfigError(msg)
        return np.asarray(response.law.viscosity_at(2.0 * size) * size)
    return np.asarray(newtonian_viscosity(viscosity, size) * size)


def newtonian_viscosity(viscosity: Viscosity, size: Array) -> float | Array:
    """Return what stands for ``mu`` [Pa s] in a Newtonian response, at strains of size ``d`` [1/s].

    Raises
    ------
    ConfigError
        If it is not positive, or a law that thins was not asked for by its local viscosity.
    """
    if isinstance(viscosity, LocalViscosity):
        return viscosity.law.viscosity_at(2.0 * size)
    if isinstance(viscosity, ViscosityLaw):
        if not viscosity.is_newtonian:
            msg = (
                f"melt {viscosity}: thins, and the response is of a Newtonian melt: make "
                "its table (solve_thinning), or ask for the approximation, LocalViscosity(law)"
            )
            raise ConfigError(msg)
        return float(viscosity.viscosity_at(1.0))
    return checked_viscosity(viscosity)


def _refuse_no_response(response: object) -> None:
    """Refuse what does not answer for a fiber (`ConfigError`)."""
    if not isinstance(response, ThinningResponse):
        refuse_other("response", response, FiberResponse)


def checked_viscosity(viscosity: float) -> float:
    """Return a viscosity [Pa s], or refuse it (`ConfigError`)."""
    return checked_positive("melt.viscosity", viscosity, "Pa s", "817")
