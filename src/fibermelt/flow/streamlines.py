"""Streamlines of the deposition flow, and what the melt meets along each of them.

Lines are seeded at equal flux and numbered from the left edge of the nozzle (the paper's footnote
1). All are traced at once, by arclength: ``dx/ds = u/|u|``, ``dt/ds = 1/|u|``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConvergenceError, refuse_no_count, refuse_other
from fibermelt.flow.deposition import FlowSolution
from fibermelt.flow.field import FlowField
from fibermelt.flow.problem import Deposition
from fibermelt.flow.tracing import Path, trace
from fibermelt.history import FlowHistory
from fibermelt.melt import ViscosityLaw
from fibermelt.melt.slit import SlitFlow
from fibermelt.shown import Shown

__all__ = ["Streamline", "inlet_seeds", "trace_streamlines"]

Array = NDArray[np.float64]

TRACING_TOLERANCE = 1e-9
"""Error allowed per step, in capillary widths: a hundredth of the discretisation's stream drift."""

NEAR_SINGULARITY = 0.15
"""A line that passes a singular corner within this many capillary widths is flagged: the gradient
there follows the singular solution, and with it the mesh."""

SETTLED_SPEED = 0.02
"""Zone 3 begins where the velocity stays within this part of the bed's speed of uniform."""


@dataclass(frozen=True, eq=False, repr=False)
class Streamline(Shown):
    """One streamline, from the inlet to the outlet, in SI units.

    Parameters
    ----------
    index : int
        1 at the left edge of the nozzle.
    flux_fraction : float
        Part of the flux that passes to the left of it.
    history : FlowHistory
        What a material point meets on it.
    stream_function : (n,) array
        ``psi`` along it [m2/s]; constant but for discretisation.
    gradient_error : (n,) array
        Estimated error of the velocity gradient along it [1/s].
    drift : float
        Largest change of ``psi`` along it, in parts of the flux.
    corner_distance : (n,) array
        Distance [m] from the nearest singular corner, where the stress has no bound: a lip, a
        corner of the capillary's entrance, or the upstream surface's contact with the bed.
    near_singularity : bool
        Whether it passes such a corner closely.
    zone_time : (3,) array
        Times [s] at zone 1 (capillary entrance), 2 (nozzle exit), 3 (end of the swell region).
    """

    index: int
    flux_fraction: float
    history: FlowHistory
    stream_function: Array
    gradient_error: Array
    drift: float
    corner_distance: Array
    near_singularity: bool
    zone_time: Array

    def told(self) -> dict[str, str]:
        """Return its number, flux, points and times."""
        time = self.history.time
        return {
            "number": f"{self.index}",
            "flux to its left": f"{100 * self.flux_fraction:.1f} %",
            "points": f"{time.size}",
            "time": f"{time[-1] - time[0]:.4g} s",
            "gradient error": f"{self.gradient_error.max():.2g} 1/s",
            "near a singular corner": "yes" if self.near_singularity else "no",
        }


def inlet_seeds(problem: Deposition, count: int) -> tuple[Array, Array]:
    """Return flux fractions ``(k - 1/2)/count`` and the x [m] at which they pass the inlet.

    The profile there is the melt's own in a slit.
    """
    fraction = (np.arange(count) + 0.5) / count
    inlet = SlitFlow(problem.melt, problem.nozzle.inlet_width, problem.inlet_speed)
    return fraction, inlet.position_at_flux(fraction)


def _first_below(history: FlowHistory, level: float) -> float:
    """Return the time at which a line first falls to the height ``level`` [m].

    Raises
    ------
    ConvergenceError
        If it begins there, or never falls so far: every line from the inlet passes the nozzle.
    """
    height = history.position[:, 1]
    when = float(history.time_across(1, level))
    if height[0] <= level or np.isnan(when):
        msg = (
            f"streamline: no point at y = {level:.4g} m or below after one above (y from "
            f"{height.max():.4g} to {height.min():.4g} m): take more streamlines.points"
        )
        raise ConvergenceError(msg)
    return when


def _settled(history: FlowHistory, bed_speed: float) -> float:
    """Return the time from which the velocity stays within 2 % of the bed's."""
    miss = np.hypot(history.velocity[:, 0] - bed_speed, history.velocity[:, 1])
    unsettled = np.flatnonzero(miss > SETTLED_SPEED * bed_speed)
    return float(history.time[min(unsettled[-1] + 1, len(history) - 1)])


def _history(
    field: FlowField, melt: ViscosityLaw, path: Path, count: int
) -> tuple[FlowHistory, Array, Array]:
    """Return the history at ``count`` points of ``path``, stream function and error there."""
    rate = field.evaluate(field.shear_rate, field.locate(path.position))
    at = path.spread(rate, count)
    xy, time = path.at(at)
    place = field.locate(xy)
    if not place.found.all():
        lost = xy[~place.found][0]
        msg = f"streamline point ({lost[0]:.4g}, {lost[1]:.4g}) m lies outside the mesh"
        raise ConvergenceError(msg)
    history = FlowHistory(
        time=time,
        position=xy,
        velocity=field.evaluate(field.velocity, place),
        gradient=field.evaluate(field.gradient, place),
        pressure=field.evaluate(field.pressure, place),
    )
    history = replace(history, viscosity=melt.viscosity_at(history.shear_rate))
    psi, error = (field.evaluate(f, place) for f in (field.stream_function, field.gradient_error))
    error = np.maximum(error, 0.0)  # between nodes the polynomial of an error may fall below
    return history, psi, error


def trace_streamlines(
    solution: FlowSolution, count: int = 22, points: int = 1500
) -> tuple[Streamline, ...]:
    """Return ``count`` streamlines of equal flux, each with ``points`` points.

    Raises
    ------
    ConfigError
        If there is no solution, there are no streamlines, or fewer than 50 points on each.
    ConvergenceError
        If a line leaves the mesh.
    """
    refuse_other("solution", solution, FlowSolution)
    refuse_no_count("streamlines.count", count)
    refuse_no_count("streamlines.points", points, 50)
    nozzle, field = solution.problem.nozzle, solution.field
    width = nozzle.capillary_width
    fraction, x = inlet_seeds(solution.problem, count)
    seeds = np.column_stack([x, np.full(count, nozzle.inlet_height * (1 - 1e-12))])
    paths = trace(field, seeds, nozzle.outlet, TRACING_TOLERANCE * width, 0.1 * width)
    ends = product((-0.5 * width, 0.5 * width), (nozzle.gap, nozzle.capillary_entrance))
    corners = np.array([*ends, (solution.contact_point, 0.0)])
    lines = []
    for k, path in enumerate(paths):
        history, psi, error = _history(field, solution.problem.melt, path, points)
        distance = np.linalg.norm(history.position[:, None, :2] - corners, axis=2).min(axis=1)
        levels = (nozzle.capillary_entrance, nozzle.gap)
        zones = [_first_below(history, level) for level in levels]
        lines.append(
            Streamline(
                index=k + 1,
                flux_fraction=float(fraction[k]),
                history=history,
                stream_function=psi,
                gradient_error=error,
                drift=float(np.ptp(psi)) / solution.problem.flux,
                corner_distance=distance,
                near_singularity=bool(distance.min() < NEAR_SINGULARITY * width),
                zone_time=np.array([*zones, _settled(history, solution.problem.bed_speed)]),
            )
        )
    return tuple(lines)
