"""The steady deposition flow: find the surfaces coarsely or start from a neighbour's, solve finely.

A coarse mesh finds the free surfaces in a few cheap meshes, whatever the first guess; each finer
mesh starts from the surfaces of the one before and needs four or five Newton steps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConvergenceError, MeshError, refuse_other
from fibermelt.flow.continuation import cold_surfaces
from fibermelt.flow.field import FlowField
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.mesh import Surfaces
from fibermelt.flow.problem import LOWEST_GAP, Deposition, FlowNumerics
from fibermelt.flow.recover import field_of, with_error
from fibermelt.flow.search import Progress, SurfaceSearch
from fibermelt.flow.start import StartShape, surfaces_from
from fibermelt.numerals import measured
from fibermelt.shown import Shown
from fibermelt.threads import exclusive

__all__ = ["FlowError", "FlowSolution", "solve_deposition"]

Array = NDArray[np.float64]

MIDDLE = 2.5
"""Coarsening of the mesh against which the discretisation error is estimated."""

ROUGH_TOLERANCE = 1e-5
"""Last step on the middle mesh [widths] that a warm start or a thinning melt asks for: chord steps
leave a quarter of it, and the error that the mesh is there to estimate is 1e-4."""

LARGEST_ERROR = 0.02
"""Estimated error of the contact point [widths] above which there is no answer to speak of."""

CLIMB = 1e-3
"""A surface this many widths above the lip wets the nozzle's outer face, which is not in here."""


@dataclass(frozen=True)
class FlowError:
    """Estimated discretisation errors: this mesh against one 2.5 times coarser.

    ``contact_point`` and ``heel`` in [m], ``inlet_pressure`` in [Pa].
    """

    contact_point: float
    heel: float
    inlet_pressure: float


@dataclass(frozen=True, eq=False, repr=False)
class FlowSolution(Shown):
    """A steady deposition flow, in SI units.

    Parameters
    ----------
    problem : Deposition
        What was solved.
    field : FlowField
        Velocity, pressure, gradient, stream function.
    upstream_surface, downstream_surface : (n, 2) arrays
        The free surfaces: left lip to contact point, right lip to outlet [m].
    bead_height : float
        Height of the bead at the outlet [m].
    inlet_pressure : float
        Mean pressure over the inlet [Pa].
    contact_point : float
        x where the upstream surface meets the bed [m].
    heel : float
        Smallest x of the melt on the bed's side of the nozzle [m].
    mass_imbalance : float
        ``|V h - Q| / Q`` at the outlet.
    kinematic_residual : float
        Root mean square of ``u.n`` over the free surfaces, in bed speeds.
    newton_steps : int
        Steps in all, on all meshes; chord steps (with an old matrix) count as steps.
    unknowns, elements : int
        Of the last mesh.
    error : FlowError
        Estimated discretisation errors.
    is_warm : bool
        Whether the solve began with surfaces that it was given, and needed no search from cold;
        of a flow that was read or scaled nothing is known, and it is False.
    """

    problem: Deposition
    field: FlowField
    upstream_surface: Array
    downstream_surface: Array
    bead_height: float
    inlet_pressure: float
    contact_point: float
    heel: float
    mass_imbalance: float
    kinematic_residual: float
    newton_steps: int
    unknowns: int
    elements: int
    error: FlowError
    is_warm: bool = False

    def told(self) -> dict[str, str]:
        """Return what the flow is known by, with its estimated errors."""
        pressure = measured(1e-6 * self.inlet_pressure, 1e-6 * self.error.inlet_pressure)
        contact = measured(1e3 * self.contact_point, 1e3 * self.error.contact_point)
        return {
            "bead height": f"{1e3 * self.bead_height:.4g} mm",
            "inlet pressure": f"{pressure} MPa",
            "contact point": f"{contact} mm",
            "triangles": f"{self.elements}",
            "unknowns": f"{self.unknowns}",
            "Newton steps": f"{self.newton_steps}",
        }


def _check_climb(problem: Deposition, surfaces: Surfaces) -> None:
    """Raise if the melt climbs above the upstream lip: the model has no outer nozzle face."""
    width, gap = problem.nozzle.capillary_width, problem.nozzle.gap
    top = float(surfaces.upstream[:, 1].max()) * width
    if top - gap > CLIMB * width:
        x = float(surfaces.upstream[surfaces.upstream[:, 1].argmax(), 0]) * width
        height = problem.mass_balance_height
        msg = (
            f"deposition flow: at flow.gap = {gap:g} m the melt climbs to y = {top:.4g} m at "
            f"x = {x:.4g} m, above the upstream lip, and would wet the nozzle's outer face, which "
            f"this model does not have; the bead is {height:.4g} m high: raise flow.gap above "
            f"about {LOWEST_GAP:g} of that ({LOWEST_GAP * height:.4g} m), or raise flow.bed_speed"
        )
        raise ConvergenceError(msg)


def _check_contact(problem: Deposition, contact: float, error: float) -> None:
    """Raise if two meshes place the contact point so differently that neither can be believed."""
    if error > LARGEST_ERROR:
        width, nozzle = problem.nozzle.capillary_width, problem.nozzle
        msg = (
            f"deposition flow: the contact point is found at x = {contact * width:.4g} m with an "
            f"estimated error of {error * width:.2g} m (bound {LARGEST_ERROR * width:.2g} m): with "
            f"flow.gap = {nozzle.gap:g} m and a bead {problem.mass_balance_height:.4g} m high the "
            "melt touches down at so flat an angle that its place is hardly determined; lower "
            "flow.gap or flow.bed_speed, or halve numerics.contact_edge and numerics.surface_edge"
        )
        raise ConvergenceError(msg)


def _inlet_pressure(flow: FreeSurfaceFlow) -> float:
    inlet = ng.ds("inlet")
    total = ng.Integrate(flow.pressure * inlet, flow.mesh)
    return float(total / ng.Integrate(ng.CF(1) * inlet, flow.mesh))


@exclusive
def solve_deposition(
    problem: Deposition,
    numerics: FlowNumerics | None = None,
    progress: Progress | None = None,
    start: StartShape | None = None,
) -> FlowSolution:
    """Solve the steady free-surface flow of a melt deposited on a moving bed (Eq. 1-4, Fig. 2a).

    Parameters
    ----------
    problem : Deposition
        Nozzle, melt and speeds.
    numerics : FlowNumerics, optional
        Order, mesh edges, tolerance.
    progress : callable, optional
        Receives a line of text after every Newton step.
    start : StartShape, optional
        Surfaces of a solved neighbour. They take the place of the search on coarse meshes; if they
        lead nowhere the search begins from cold (`FlowSolution.is_warm`). The answer is the same
        within its stated error.

    Raises
    ------
    ConfigError
        If problem or numerics is of another type.
    ConvergenceError
        If there is no steady surface (too small a gap, or a bed so fast that the surface would
        pass under it), the melt climbs above the upstream lip,
        or Newton does not reach the tolerance.
    MeshError
        If the mesh cannot be made as asked for.

    Notes
    -----
    Solved in units of capillary width, bed speed and viscosity, so the viscosity scales the
    pressure and nothing else, and a joint scaling of both speeds leaves the shape alone.
    """
    numerics = FlowNumerics() if numerics is None else numerics
    refuse_other("problem", problem, Deposition)
    refuse_other("numerics", numerics, FlowNumerics)
    search = SurfaceSearch(problem, progress)
    if start is not None:
        try:
            warm = _finely(search, surfaces_from(start, problem), numerics, chords=True)
            return replace(warm, is_warm=True)
        except (ConvergenceError, MeshError):
            search.tell("no answer from the neighbour's surfaces: from cold")
    return _finely(search, cold_surfaces(search, numerics.contact_guess), numerics)


def _finely(
    search: SurfaceSearch, surfaces: Surfaces, numerics: FlowNumerics, chords: bool = False
) -> FlowSolution:
    """Return the solution from a guess of its surfaces: on the middle mesh, then on the fine."""
    problem = search.problem
    _check_climb(problem, surfaces)
    rough = numerics.coarsened(MIDDLE)
    if chords or not problem.melt.is_newtonian:
        rough = replace(rough, flow_tolerance=max(rough.flow_tolerance, ROUGH_TOLERANCE))
    middle, surfaces = search.converge(surfaces, rough, chords)
    seen = (surfaces.upstream[-1, 0], surfaces.upstream[:, 0].min(), _inlet_pressure(middle))
    coarser = field_of(middle, problem, stream=False)
    flow, surfaces = search.converge(surfaces, numerics, chords)
    _check_climb(problem, surfaces)

    width, stress = problem.nozzle.capillary_width, problem.stress_scale
    contact, heel = surfaces.upstream[-1, 0], surfaces.upstream[:, 0].min()
    _check_contact(problem, float(contact), float(abs(contact - seen[0])))
    pressure = _inlet_pressure(flow)
    height = float(surfaces.downstream[-1, 1]) * width
    return FlowSolution(
        problem=problem,
        field=with_error(field_of(flow, problem), coarser),
        upstream_surface=surfaces.upstream * width,
        downstream_surface=surfaces.downstream * width,
        bead_height=height,
        inlet_pressure=pressure * stress,
        contact_point=float(contact) * width,
        heel=float(heel) * width,
        mass_imbalance=abs(height / problem.mass_balance_height - 1),
        kinematic_residual=flow.kinematic_residual(),
        newton_steps=search.newton_steps,
        unknowns=flow.unknowns,
        elements=int(flow.mesh.ne),
        error=FlowError(
            contact_point=float(abs(contact - seen[0])) * width,
            heel=float(abs(heel - seen[1])) * width,
            inlet_pressure=abs(pressure - seen[2]) * stress,
        ),
    )
