"""The search for the free surfaces, mesh by mesh: Newton first, implicit time where it fails."""

from __future__ import annotations

from collections.abc import Callable

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConvergenceError, MeshError
from fibermelt.flow.freesurface import Boundaries, FreeSurfaceFlow, Step
from fibermelt.flow.mesh import Surfaces, deposition_mesh, scaled
from fibermelt.flow.problem import LOWEST_GAP, Deposition, FlowNumerics, Nozzle
from fibermelt.melt.slit import SlitFlow

__all__ = [
    "DRAWN_DOWN",
    "UNDER_BED_COARSE",
    "Progress",
    "SurfaceSearch",
    "UnderBedError",
    "coarse_numerics",
]

Array = NDArray[np.float64]
Progress = Callable[[str], None]

COARSE = FlowNumerics(
    lip_edge=0.05, contact_edge=0.1, corner_edge=0.2, surface_edge=0.15, bulk_edge=0.3
)
"""The mesh that finds the surfaces: 500 triangles, 0.1 s a step; finer for a bead lower than a
capillary width, down to a third."""

THINNEST = 0.3
"""Bead height [widths] below which the coarse mesh is refined no further."""

DRAWN_DOWN = 1.25
"""Gap over bead height above which a search that fails has been pulling the melt, not piling it."""

MAX_COARSE_MESHES = 20
"""Gaps from 0.83 to 2 bead heights need 2 to 7; the rest is for slow steps of implicit time."""

MAX_DRAWN_MESHES = 5
"""The same for a melt that is drawn down: what is not found by then takes continuation."""

UNDER_BED = 1e-6
"""A surface this many widths below the bed before its contact passes through the bed. Its foot
then lies 0.01 widths from where it touches first, half of the largest error."""

UNDER_BED_COARSE = 1e-3
"""The same on a coarse mesh: where the melt comes down flat, its own error dips the surface by some
1e-4. It is only a start: what passes under the bed is for the fine mesh to say."""

STEPS_A_COARSE_MESH = 4
"""Newton steps before the coarse mesh is made anew on the surfaces found."""

SETTLED = 1e-3
"""The coarse search ends when its last step moves no node by more than this many widths."""

MAX_STEPS = 12
"""A fine mesh needs 4 or 5 steps; more than twice that is a failure."""

CHORDS_FOR_ONE = 6
"""A step's matrix and factors serve on while this many chord steps at the rate last seen reach the
tolerance: new ones cost as much as six to eight."""

CHORD_LEFT = 0.25
"""What may be left undone after a chord step, in tolerances, by the rate of the last two steps."""

FASTEST_CHORDS = 0.1
"""A chord step is not believed to leave less than this part of itself: the first gains two
decimals or three, the next but one."""

PROFILE_POINTS = 20001
"""Points of an inlet profile that is no parabola; linear between them, to 1e-8 of its height."""

FIRST_RATE, LAST_RATE = 1.0, 0.2
"""Rates [bed speeds per capillary width] at which steps of implicit time begin and end."""

OUTLET_MARGIN = 0.5
"""A contact point this near to the outlet [widths] leaves no bead to solve for."""

HOPELESS_CLIMB = 0.5
"""A surface this many widths above the lip has never come back."""


class UnderBedError(ConvergenceError):
    """The steady surface passes under the bed: it is none."""


def coarse_numerics(problem: Deposition) -> FlowNumerics:
    """Return the coarse mesh's numerics, finer for a low bead."""
    height = problem.mass_balance_height / problem.nozzle.capillary_width
    return COARSE.coarsened(min(1.0, max(height, THINNEST)))


def _boundaries(problem: Deposition, nozzle: Nozzle) -> Boundaries:
    """Return the paper's Fig. 2a: inlet profile, no slip, bed and outlet at the bed's speed."""
    speed = problem.inlet_speed / problem.bed_speed
    profile, inflow = -1.5 * speed * (1 - (2 * ng.x / nozzle.inlet_width) ** 2), {}
    if not problem.melt.is_newtonian:
        half = nozzle.inlet_width / 2
        x = np.linspace(-half, half, PROFILE_POINTS)
        slit = SlitFlow(problem.scaled_law, nozzle.inlet_width, speed)
        profile = ng.VoxelCoefficient((-half,), (half,), -slit.velocity(x), linear=True)
        inflow = {"inlet": speed * nozzle.inlet_width}
    return Boundaries(
        moving="bead",
        free="upstream|downstream",
        velocity={"inlet": (0, profile), "wall": (0, 0), "bed": (1, 0), "outlet": (1, 0)},
        held_x="outlet|exit|wall|inlet",
        held_y="bed|exit|wall|inlet",
        lips=np.array([[-0.5, nozzle.gap], [0.5, nozzle.gap]]),
        inflow=inflow,
    )


def _first_surfaces(problem: Deposition, nozzle: Nozzle, guess: float | None) -> Surfaces:
    """Return an upstream surface that bends onto the bed at the contact guess, and a smooth top."""
    width = problem.nozzle.capillary_width
    height = problem.mass_balance_height / width
    # the guess must lie downstream of the answer: a wide gap carries the contact with it
    contact = max(0.0, 2 * (nozzle.gap - height)) if guess is None else guess / width
    contact = min(contact, 0.8 * nozzle.outlet)
    part = np.linspace(0.0, 1.0, 41)[:, None]
    upstream = np.hstack([-0.5 + (contact + 0.5) * part, nozzle.gap * (1 - part) ** 2])
    x = np.linspace(0.5, nozzle.outlet, 201)
    top = height + (nozzle.gap - height) * np.exp(-2 * (x - 0.5) / height)
    return Surfaces(upstream, np.column_stack([x, top]))


def _trimmed(upstream: Array) -> Array:
    """Return the upstream surface up to where it first meets the bed."""
    below = np.flatnonzero(upstream[:, 1] <= 0)
    if below.size == 0 or below[0] == len(upstream) - 1:
        return upstream
    first = below[0]
    above, under = upstream[first - 1], upstream[first]
    crossing = above + (under - above) * (above[1] / (above[1] - under[1]))
    crossing[1] = 0.0
    return np.vstack([upstream[:first], crossing])


def _chords_end(size: float, rate: float, tolerance: float) -> bool:
    """Return whether all chord steps to come together are a small part of the tolerance."""
    rate = max(rate, FASTEST_CHORDS)
    return rate < 1.0 and size * rate / (1.0 - rate) < CHORD_LEFT * tolerance


class SurfaceSearch:
    """Carries the surfaces from mesh to mesh and counts what it took."""

    def __init__(self, problem: Deposition, progress: Progress | None = None) -> None:
        """Start with no mesh; ``progress`` receives a line of text after every step."""
        self.problem = problem
        self.nozzle = scaled(problem.nozzle)
        self.progress = progress
        self.newton_steps = 0
        self.meshes = 0
        self._flow: FreeSurfaceFlow | None = None

    def start(self, surfaces: Surfaces, numerics: FlowNumerics) -> FreeSurfaceFlow:
        """Mesh the domain between ``surfaces`` and solve Stokes on it."""
        self.meshes += 1
        mesh = deposition_mesh(self.nozzle, surfaces, numerics)
        boundaries = _boundaries(self.problem, self.nozzle)
        self._flow = FreeSurfaceFlow(
            mesh, boundaries, numerics.flow_order, self.problem.scaled_law, self._flow
        )
        return self._flow

    def tell(self, line: str) -> None:
        """Pass a line of progress on."""
        if self.progress is not None:
            self.progress(line)

    def step(self, flow: FreeSurfaceFlow, rate: float = 0.0, reuse: bool = False) -> Step:
        """Take one step on the mesh, and tell."""
        step = flow.step(rate, reuse)
        self.newton_steps += 1
        kind = "Newton step" if rate == 0 else f"time step of {1 / rate:.2g} W/V"
        kind = "chord step" if reuse else kind
        cut = "" if step.fraction == 1.0 else f", {step.fraction:.0%} taken"
        self.tell(
            f"mesh {self.meshes} ({flow.mesh.ne} triangles, {flow.unknowns} unknowns), {kind} "
            f"{self.newton_steps}: residual {step.residual:.1e}, surface moves {step.size:.1e} "
            f"widths{cut}"
        )
        return step

    def surfaces(self, flow: FreeSurfaceFlow) -> Surfaces:
        """Return the free surfaces as they lie now."""
        gap = self.nozzle.gap
        return Surfaces(
            _trimmed(flow.surface("upstream", np.array([-0.5, gap]))),
            flow.surface("downstream", np.array([0.5, gap])),
        )

    def find_surfaces(self, contact_guess: float | None = None) -> Surfaces:
        """Return the surfaces found on coarse meshes, made anew until they no longer move.

        Newton's steps first; where one points nowhere, steps of implicit time take over, shorter
        while they must be cut and longer while they need not, until they are Newton's again.
        """
        rate = 0.0
        surfaces = _first_surfaces(self.problem, self.nozzle, contact_guess)
        coarse = coarse_numerics(self.problem)
        drawn = self.problem.nozzle.gap > DRAWN_DOWN * self.problem.mass_balance_height
        for _ in range(MAX_DRAWN_MESHES if drawn else MAX_COARSE_MESHES):
            try:
                flow = self.start(surfaces, coarse)
            except MeshError as reason:
                raise self._no_steady_surface(surfaces) from reason
            for _ in range(STEPS_A_COARSE_MESH):
                step = self.step(flow, rate)
                if step.fraction < 1.0:
                    rate = max(2.0 * rate, FIRST_RATE)
                    break
                if step.size < SETTLED and rate == 0.0:
                    return self.surfaces(flow)
                rate = 0.0 if rate < LAST_RATE else rate / 2.0
            surfaces = self.surfaces(flow)
            if surfaces.upstream[-1, 0] > self.nozzle.outlet - OUTLET_MARGIN:
                raise self._outlet_too_near()
            if surfaces.upstream[:, 1].max() > self.nozzle.gap + HOPELESS_CLIMB:
                break
        raise self._no_steady_surface(surfaces)

    def converge(
        self,
        surfaces: Surfaces,
        numerics: FlowNumerics,
        chords: bool = False,
        under_bed: float = UNDER_BED,
    ) -> tuple[FreeSurfaceFlow, Surfaces]:
        """Return the flow on a fine mesh, converged to the tolerance, and its surfaces.

        With ``chords`` a factorisation serves on while that is cheaper than a new one;
        ``under_bed`` is how far below the bed [widths] the upstream surface may pass.
        """
        flow = self.start(surfaces, numerics)
        reuse, last, bound = False, 1.0, numerics.flow_tolerance
        for taken in range(1, MAX_STEPS + 1):
            step = self.step(flow, reuse=reuse)
            steps, rate = f"{taken} steps", step.size / last
            is_small = step.size < bound if not reuse else _chords_end(step.size, rate, bound)
            if is_small and step.fraction == 1.0:
                self._check_bed(flow, under_bed)
                return flow, self.surfaces(flow)
            if step.fraction == 0.0:
                break  # nothing was moved: the next step would be the same
            reuse = chords and step.fraction == 1.0 and step.size * rate**CHORDS_FOR_ONE < bound
            last = step.size
        x, y = self.surfaces(flow).upstream.T * self.problem.nozzle.capillary_width
        msg = (
            f"deposition flow: the surface still moves {step.size:.1e} capillary widths after "
            f"{steps} on a mesh of {flow.mesh.ne} triangles (bound "
            f"numerics.flow_tolerance = {numerics.flow_tolerance:g}), "
            f"residual {step.residual:.1e}, most of it in the {step.worst_field}; "
            f"contact at x = {x[-1]:.4g} m, heel at x = {x.min():.4g} m, "
            f"highest point {y.max():.4g} m; try twice the "
            "numerics.contact_edge and numerics.lip_edge"
        )
        raise ConvergenceError(msg)

    def _check_bed(self, flow: FreeSurfaceFlow, deepest: float) -> None:
        """Raise if the upstream surface passes under the bed before it ends on it."""
        line = flow.surface("upstream", np.array([-0.5, self.nozzle.gap]))
        lowest = line[line[:, 1].argmin()] * self.problem.nozzle.capillary_width
        if line[:, 1].min() < -deepest:
            height, gap = self.problem.mass_balance_height, self.problem.nozzle.gap
            msg = (
                f"deposition flow: with flow.gap = {gap:g} m and a bead {height:.4g} m high "
                f"({gap / height:.3g} bead heights) the bed draws the melt so fast that the "
                f"upstream surface would pass {-lowest[1]:.2g} m under the bed at x = "
                f"{lowest[0]:.4g} m: no steady surface above the bed; lower flow.bed_speed or "
                "flow.gap, or raise flow.inlet_speed"
            )
            raise UnderBedError(msg)

    def towards(self, problem: Deposition) -> SurfaceSearch:
        """Return a search for an intermediate problem that tells its progress to the same."""
        return SurfaceSearch(problem, self.progress)

    def count(self, other: SurfaceSearch) -> None:
        """Add what another search took."""
        self.newton_steps += other.newton_steps
        self.meshes += other.meshes

    def _outlet_too_near(self) -> ConvergenceError:
        nozzle, height = self.problem.nozzle, self.problem.mass_balance_height
        return ConvergenceError(
            "deposition flow: the contact point ran into the outlet at flow.outlet = "
            f"{nozzle.outlet:g} m: flow.gap = {nozzle.gap:g} m is {nozzle.gap / height:.3g} times "
            f"the bead's height of {height:.4g} m; lower flow.gap or raise flow.outlet"
        )

    def _no_steady_surface(self, surfaces: Surfaces) -> ConvergenceError:
        """Return what to say when the search ends without an answer, and which way to go."""
        up = surfaces.upstream * self.problem.nozzle.capillary_width
        height, gap = self.problem.mass_balance_height, self.problem.nozzle.gap
        if gap > DRAWN_DOWN * height:
            reason = (
                f"the gap is {gap / height:.3g} bead heights, and the melt is drawn down so far "
                "that its contact with the bed is hardly determined; lower flow.gap or "
                "flow.bed_speed, or raise flow.inlet_speed"
            )
        else:
            reason = (
                f"below a gap of about {LOWEST_GAP:g} bead heights ({LOWEST_GAP * height:.4g} m) "
                "the melt climbs the nozzle; raise flow.gap or flow.bed_speed, or lower "
                "flow.inlet_speed"
            )
        return ConvergenceError(
            f"deposition flow: no steady free surface found for flow.gap = {gap:g} m after "
            f"{self.meshes} meshes and {self.newton_steps} steps: the upstream surface was last "
            f"seen from x = {up[:, 0].min():.4g} to {up[-1, 0]:.4g} m and up to y = "
            f"{up[:, 1].max():.4g} m; the bead is {height:.4g} m high: {reason}"
        )
