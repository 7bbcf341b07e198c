"""The steady bead in three dimensions: a round nozzle, a gap, a moving bed.

The strand is one closed tube of free surface, and the bed a film on it (`BedFilm`): there is no
contact line to be found. Newton's method on flow and shape together takes it from a guess; the film
is then thinned, and what is reported of the bead's shape is extrapolated to none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, ConvergenceError, refuse_other
from fibermelt.flow.forms import BedFilm
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.mesh import scaled
from fibermelt.flow.problem import WET, BeadDeposition, BeadNumerics
from fibermelt.flow.space.field import BeadField, bead_field_of
from fibermelt.flow.space.guess import BeadGuess
from fibermelt.flow.space.tube import Tube, tube_mesh
from fibermelt.flow.spaces import Boundaries
from fibermelt.flow.spacing import graded_spacing
from fibermelt.melt.slit import PipeFlow
from fibermelt.numerals import measured
from fibermelt.shown import Shown
from fibermelt.threads import exclusive

__all__ = ["BeadError", "BeadSolution", "bead_tube", "solve_bead"]

Array = NDArray[np.float64]
Progress = Callable[[str], None]

COARSENING = 1.5
"""Edges of the mesh against which the discretisation error is estimated."""

FILMS = (2.0, 1.0)
"""Films [thicknesses] on each mesh: a thin one at once leads Newton astray, and two of them tell
how the answer depends on it."""

FILM_LEFT = 0.25
"""Part of what the extrapolation in the film's thickness adds that may be wrong with it; halving
the film once more changes the extrapolated height by a sixteenth of it."""

MAX_STEPS = 20
"""Steps on one film; 4 to 6 are taken where Newton's lead there, 7 to 9 with implicit time."""

FIRST_RATE, LAST_RATE = 1.0, 0.2
"""Rates [bed speeds per diameter] at which steps of implicit time begin and end."""

NARROWEST_GAP = 0.75
"""Gap [diameters] below which the melt reaches the nozzle's outer face."""

SLOWEST_EXIT = 0.8
"""Exit speed over the bed's below which the bed draws the strand: what is drawn is held on it by
adhesion alone, which the film has not. At 0.6 Newton converges to a strand that peels off."""

NEAREST_OUTLET = 2.5
"""x of the outlet [diameters] below which it is felt where the strand is still turning."""

OFF_THE_BED = 0.9
"""How far off the bed [films] a strand's lowest point at the outlet may lie: pushed on it lies 0.4
off. Beyond 1 the film hardly holds it."""

CLIMB = 1e-3
"""A surface this many diameters above the lip wets the nozzle's outer face, which is not here."""

PROFILE_POINTS = 2001
"""Points of an inlet profile that is no parabola; linear between them, to 1e-6 of its height."""

AT_OUTLET = 1e-6
"""A point this near to the outlet's plane [diameters] lies in it."""


def bead_tube(
    numerics: BeadNumerics, stations: tuple[float, float], coarsening: float = 1.0
) -> Tube:
    """Return the mesh's layers, rings and sectors."""
    lip, bulk, rim = (
        coarsening * edge for edge in (numerics.lip_edge, numerics.bulk_edge, numerics.rim_edge)
    )
    up, down = (graded_spacing(abs(end), bulk, numerics.edge_growth, start=lip) for end in stations)
    # in radii of the section; its middle is smooth
    inwards = graded_spacing(1.0, 0.4 * coarsening, numerics.edge_growth, start=2 * rim)
    sectors = 4 * max(2, round(numerics.sectors / (4 * coarsening)))
    return Tube(np.r_[-up[:0:-1], down], 1.0 - inwards[::-1], sectors)


@dataclass(frozen=True)
class _Measured:
    """What a bead is measured by; what each is, `BeadSolution` says."""

    bead_height: float
    bead_width: float
    widest: float
    heel: float
    front: float
    wet_width: float
    section_area: float
    inlet_pressure: float


@dataclass(frozen=True)
class BeadError(_Measured):
    """Estimated errors: of the mesh, against a coarser one, and of the film's extrapolation.

    In the units of the numbers of `BeadSolution` that they belong to, [m], [m2], [Pa].
    """


@dataclass(frozen=True, eq=False, repr=False)
class BeadSolution(Shown):
    """A steady bead in space, in SI units.

    Parameters
    ----------
    problem : BeadDeposition
        What was solved.
    field : BeadField
        Velocity, pressure, gradient, with the thinner film.
    bead_height, bead_width : float
        Of the section at the outlet [m], extrapolated to no film.
    widest : float
        Largest width anywhere [m], extrapolated.
    heel : float
        Smallest x of the strand [m], extrapolated.
    front : float
        x on the plane of symmetry where the melt first lies on the bed [m], with the thinner film.
    wet_width : float
        Width of what lies on the bed at the outlet [m], likewise: where the melt rolls onto the bed
        at 180 degrees its surface leaves it tangentially, and the width is known poorly.
    section_area : float
        Area of the section at the outlet [m2], with the thinner film.
    film : float
        Thickness of the thinner film [m].
    inlet_pressure : float
        Mean pressure over the inlet [Pa], extrapolated.
    mass_imbalance : float
        ``|V A - Q| / Q`` at the outlet.
    kinematic_residual : float
        Root mean square of ``u.n`` over the free surface, in bed speeds.
    divergence : float
        Root mean square of ``div u`` over that of the gradient.
    newton_steps : int
        Steps in all, on both meshes.
    unknowns, elements : int
        Of the finer mesh.
    error : BeadError
        Estimated errors.
    """

    problem: BeadDeposition
    field: BeadField
    bead_height: float
    bead_width: float
    widest: float
    heel: float
    front: float
    wet_width: float
    section_area: float
    film: float
    inlet_pressure: float
    mass_imbalance: float
    kinematic_residual: float
    divergence: float
    newton_steps: int
    unknowns: int
    elements: int
    error: BeadError

    def told(self) -> dict[str, str]:
        """Return what the bead is known by, with its estimated errors."""
        lengths = {
            "bead height": "bead_height",
            "bead width": "bead_width",
            "heel": "heel",
            "front": "front",
        }
        told = {
            title: f"{measured(1e3 * getattr(self, name), 1e3 * getattr(self.error, name))} mm"
            for title, name in lengths.items()
        }
        pressure = measured(1e-6 * self.inlet_pressure, 1e-6 * self.error.inlet_pressure)
        return {
            **told,
            "inlet pressure": f"{pressure} MPa",
            "tetrahedra": f"{self.elements}",
            "unknowns": f"{self.unknowns}",
            "Newton steps": f"{self.newton_steps}",
        }


@dataclass(frozen=True)
class _Shape(_Measured):
    """What is measured on one mesh with one film, in units of diameter, bed speed and viscosity."""

    @classmethod
    def of(cls, flow: FreeSurfaceFlow, outlet: float, film: float) -> _Shape:
        places = flow.places("free")
        x, y, z = places.T
        at_end = x > outlet - AT_OUTLET
        wet = y <= WET * film
        middle = z < AT_OUTLET
        pressure = ng.Integrate(flow.pressure * ng.ds("inlet"), flow.mesh) / flow.area("inlet")
        return cls(
            bead_height=float(y[at_end].max()),
            bead_width=float(2 * z[at_end].max()),
            widest=float(2 * z.max()),
            heel=float(x.min()),
            front=float(np.min(x, where=wet & middle, initial=outlet)),
            wet_width=float(2 * np.max(z, where=wet & at_end, initial=0.0)),
            section_area=2 * flow.area("outlet"),
            inlet_pressure=float(pressure),
        )


EXTRAPOLATED = ("bead_height", "bead_width", "widest", "heel", "inlet_pressure")
"""What depends on the film's thickness to first order, as its bed's level does."""


def _refuse_unverified(problem: BeadDeposition) -> None:
    """Refuse what no formulation here holds."""
    nozzle, ratio = scaled(problem.nozzle), problem.speed_ratio
    width = problem.nozzle.capillary_width
    if nozzle.gap < NARROWEST_GAP:
        msg = (
            f"flow.gap = {problem.nozzle.gap:g} m is {nozzle.gap:.3g} diameters: below "
            f"{NARROWEST_GAP:g} the melt reaches the nozzle's outer face, which a bead in space "
            f"does not have: raise flow.gap to {NARROWEST_GAP * width:.4g} m or more"
        )
        raise ConfigError(msg)
    if ratio < SLOWEST_EXIT:
        speed = problem.bed_speed * ratio / SLOWEST_EXIT
        msg = (
            f"flow.bed_speed = {problem.bed_speed:g} m/s: the melt leaves the nozzle at "
            f"{ratio:.3g} of it; below {SLOWEST_EXIT:g} the bed draws the strand, which adhesion "
            "alone would hold, and a bead in space has none: lower flow.bed_speed to "
            f"{speed:.4g} m/s or less, or raise flow.inlet_speed"
        )
        raise ConfigError(msg)
    if nozzle.outlet < NEAREST_OUTLET:
        msg = (
            f"flow.outlet = {problem.nozzle.outlet:g} m is {nozzle.outlet:.3g} diameters from the "
            "nozzle's axis, where a bead in space still turns: raise it to "
            f"{NEAREST_OUTLET * width:.4g} m or more"
        )
        raise ConfigError(msg)


def _boundaries(problem: BeadDeposition, film: BedFilm) -> Boundaries:
    """Return inlet profile, no slip on the nozzle, the bed's film, and its speed at the outlet."""
    nozzle = scaled(problem.nozzle)
    speed = problem.inlet_speed / problem.bed_speed
    r, half = ng.sqrt(ng.x**2 + ng.z**2), nozzle.inlet_width / 2
    profile = 2.0 * speed * (1 - (r / half) ** 2)
    if not problem.melt.is_newtonian:
        knots = np.linspace(0.0, half, PROFILE_POINTS)
        pipe = PipeFlow(problem.scaled_law, nozzle.inlet_width, speed)
        # a spline of order two is linear between its knots; the first stands for itself twice
        profile = ng.BSpline(2, [0.0, *knots], [*pipe.velocity(knots), 0.0])(r)
    return Boundaries(
        moving="strand",
        free="free",
        velocity={"inlet": (0, -profile, 0), "wall": (0, 0, 0), "outlet": (1, 0, 0)},
        held=("inlet|wall|outlet", "inlet|wall", "inlet|wall|symmetry"),
        symmetry=("", "", "symmetry"),
        rounded="wall",
        film=film,
        inflow={"inlet": np.pi / 8 * speed * nozzle.inlet_width**2},
    )


class _Search:
    """One bead on one mesh after the other, and what it took."""

    def __init__(
        self, problem: BeadDeposition, numerics: BeadNumerics, progress: Progress | None
    ) -> None:
        self.problem, self.numerics, self.progress = problem, numerics, progress
        self.nozzle = scaled(problem.nozzle)
        self.steps = 0

    def solve(
        self, coarsening: float, before: FreeSurfaceFlow | None = None
    ) -> tuple[FreeSurfaceFlow, list[_Shape]]:
        """Return the flow on a mesh, and its shapes with the thicker and the thinner film."""
        films = [part * self.numerics.film for part in FILMS]
        guess = BeadGuess(self.nozzle, self.problem.speed_ratio, films[0])
        mesh, middles = tube_mesh(bead_tube(self.numerics, guess.stations, coarsening), guess)
        thickness = ng.Parameter(films[0])
        boundaries = _boundaries(self.problem, BedFilm(thickness))
        order, law = self.numerics.flow_order, self.problem.scaled_law
        flow = FreeSurfaceFlow(mesh, boundaries, order, law, before, middles)
        shapes = []
        for film in films:
            thickness.Set(film)
            self._converge(flow, film)
            self._check(flow, film)
            shapes.append(_Shape.of(flow, self.nozzle.outlet, film))
        flow.release()
        return flow, shapes

    def _converge(self, flow: FreeSurfaceFlow, film: float) -> None:
        """Take Newton's steps; where one points nowhere, steps of implicit time lead on."""
        rate = 0.0
        for _ in range(MAX_STEPS):
            step = flow.step(rate)
            self.steps += 1
            self._tell(flow, film, rate, step.residual, step.size, step.fraction)
            if step.fraction < 1.0:
                rate = max(2.0 * rate, FIRST_RATE)
            elif rate == 0.0 and step.size < self.numerics.flow_tolerance:
                return
            else:
                rate = 0.0 if rate < LAST_RATE else rate / 2.0
        nozzle, ratio = self.problem.nozzle, self.problem.speed_ratio
        msg = (
            f"bead in space: no steady strand found for flow.gap = {nozzle.gap:g} m and a melt "
            f"that leaves at {ratio:.3g} of flow.bed_speed = {self.problem.bed_speed:g} m/s: it "
            f"still moves {step.size:.1e} diameters after {MAX_STEPS} steps (bound "
            f"numerics.flow_tolerance = {self.numerics.flow_tolerance:g}), residual "
            f"{step.residual:.1e}, most of it in the {step.worst_field}; bring flow.gap nearer to "
            "a diameter, flow.bed_speed nearer to the speed at the exit, or raise numerics.film"
        )
        raise ConvergenceError(msg)

    def _tell(
        self,
        flow: FreeSurfaceFlow,
        film: float,
        rate: float,
        residual: float,
        size: float,
        fraction: float,
    ) -> None:
        if self.progress is None:
            return
        kind = "Newton step" if rate == 0 else f"time step of {1 / rate:.2g} D/V"
        cut = "" if fraction == 1.0 else f", {fraction:.0%} taken"
        self.progress(
            f"film {film:g} D ({flow.mesh.ne} tetrahedra, {flow.unknowns} unknowns), {kind} "
            f"{self.steps}: residual {residual:.1e}, surface moves {size:.1e} diameters{cut}"
        )

    def _check(self, flow: FreeSurfaceFlow, film: float) -> None:
        """Raise if the strand climbs above the lip, or has left the bed."""
        places, gap = flow.places("free"), self.nozzle.gap
        nozzle, width = self.problem.nozzle, self.problem.nozzle.capillary_width
        x, y, _ = places[places[:, 1].argmax()] * width
        if places[:, 1].max() > gap + CLIMB:
            msg = (
                f"bead in space: at flow.gap = {nozzle.gap:g} m the strand rises to y = {y:.4g} m "
                f"at x = {x:.4g} m, above the nozzle's lip, and would wet its outer face, which a "
                "bead in space does not have: raise flow.gap or flow.bed_speed, or lower "
                "flow.inlet_speed"
            )
            raise ConvergenceError(msg)
        at_end = places[:, 0] > self.nozzle.outlet - AT_OUTLET
        lowest = float(places[at_end, 1].min())
        if lowest > OFF_THE_BED * film:
            msg = (
                f"bead in space: at flow.gap = {nozzle.gap:g} m the strand lies "
                f"{lowest * width:.2g} m above the bed at the outlet, where the film that stands "
                f"for the bed is {film * width:.2g} m thick: it has left the bed, on which "
                "adhesion alone would hold it, and a bead in space has none: lower flow.gap or "
                "flow.bed_speed, or raise flow.inlet_speed"
            )
            raise ConvergenceError(msg)


def _divergence(flow: FreeSurfaceFlow) -> float:
    slope = ng.Grad(flow.velocity)
    parts = (ng.Trace(slope) ** 2, ng.InnerProduct(slope, slope))
    divergence, gradient = (ng.Integrate(part * ng.dx, flow.mesh) for part in parts)
    return float(np.sqrt(divergence / gradient))


@exclusive
def solve_bead(
    problem: BeadDeposition,
    numerics: BeadNumerics | None = None,
    progress: Progress | None = None,
) -> BeadSolution:
    """Solve the steady flow of a melt from a round nozzle onto a moving bed.

    Parameters
    ----------
    problem : BeadDeposition
        Nozzle, melt and speeds.
    numerics : BeadNumerics, optional
        Order, mesh, film, tolerance.
    progress : callable, optional
        Receives a line of text after every Newton step.

    Raises
    ------
    ConfigError
        If problem or numerics is of another type, or the strand would reach the nozzle's outer
        face (gap below 0.75 diameters) or be drawn by the bed (exit speed below 0.8 of the bed's).
    ConvergenceError
        If no steady strand is found, or the one found rises above the lip or has left the bed.
    MeshError
        If the first guess cannot be meshed.

    Notes
    -----
    Solved in units of capillary diameter, bed speed and viscosity at their rate. The bed is a film
    of a finite thickness; height, width, heel and pressure depend on it to first order, and are
    extrapolated from two films. There is no gravity, no surface tension and no adhesion: what is
    not pressed on the bed leaves it, and is refused.
    """
    numerics = BeadNumerics() if numerics is None else numerics
    refuse_other("problem", problem, BeadDeposition)
    refuse_other("numerics", numerics, BeadNumerics)
    _refuse_unverified(problem)
    search = _Search(problem, numerics, progress)
    rough, coarse = search.solve(COARSENING)
    flow, fine = search.solve(1.0, rough)
    value, error = _extrapolated(coarse, fine)
    length, stress = problem.nozzle.capillary_width, problem.stress_scale
    units = {"section_area": length**2, "inlet_pressure": stress}
    scale = {one.name: units.get(one.name, length) for one in fields(_Shape)}
    area = value["section_area"] * length**2
    off = abs(value["section_area"] - problem.mass_balance_area / length**2)
    error["section_area"] = max(error["section_area"], off)  # known exactly
    return BeadSolution(
        problem=problem,
        field=bead_field_of(flow, problem),
        film=numerics.film * length,
        mass_imbalance=abs(area / problem.mass_balance_area - 1.0),
        kinematic_residual=flow.kinematic_residual(),
        divergence=_divergence(flow),
        newton_steps=search.steps,
        unknowns=flow.unknowns,
        elements=int(flow.mesh.ne),
        error=BeadError(**{name: error[name] * scale[name] for name in scale}),
        **{name: value[name] * scale[name] for name in scale},
    )


def _extrapolated(
    coarse: list[_Shape], fine: list[_Shape]
) -> tuple[dict[str, float], dict[str, float]]:
    """Return values and errors by name, from the shapes with both films on either mesh.

    The error of the finer mesh is twice what it differs from the coarser by, as the lip's
    singularity leaves first order, ``(h, 1.5 h)``. What is not extrapolated in the film keeps the
    whole of its change.
    """
    value, error = {}, {}
    for name in (one.name for one in fields(_Shape)):
        (thick, thin), (other, thinner) = (
            [getattr(shape, name) for shape in shapes] for shapes in (fine, coarse)
        )
        shift, known = thin - thick, name in EXTRAPOLATED
        value[name] = thin + (shift if known else 0.0)
        there = thinner + (thinner - other if known else 0.0)
        of_mesh = abs(value[name] - there) / (COARSENING - 1.0)
        error[name] = of_mesh + (FILM_LEFT if known else 1.0) * abs(shift)
    return value, error
