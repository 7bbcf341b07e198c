"""Planar die swell: the free surface's own verification problem.

A half channel of unit half-width lets its melt out into the air, at a mean speed of one; without
surface tension a Newtonian jet ends 18.67 % thicker than the channel, one that thins less. The lip
is singular, so the answer converges with the lip's mesh edge and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import ngsolve as ng
import numpy as np
from netgen.geom2d import SplineGeometry

from fibermelt.errors import ConvergenceError
from fibermelt.flow.freesurface import Boundaries, FreeSurfaceFlow
from fibermelt.flow.spacing import graded_spacing
from fibermelt.melt import ViscosityLaw
from fibermelt.melt.slit import SlitFlow
from fibermelt.threads import exclusive

__all__ = ["DieSwell", "settle", "solve_die_swell", "swell_problem"]

CHANNEL, JET = 4.0, 8.0
"""Lengths in half-widths: the end effects decay as exp(-2.1 x) and exp(-3 x), below 1e-4 here."""

PROFILE_POINTS = 20001
"""Points of an inlet profile that is no parabola; linear between them, to 1e-8 of its height."""

MAX_STEPS = 12
"""Newton needs 5; more than twice that is a failure."""


@dataclass(frozen=True)
class DieSwell:
    """The result: swell ratio, cost, and the size of the last Newton step."""

    swell: float
    unknowns: int
    newton_steps: int
    last_step: float


def _mesh(lip_edge: float, bulk_edge: float, growth: float) -> ng.Mesh:
    geometry = SplineGeometry()

    def point(x: float, y: float, edge: float = bulk_edge) -> int:
        return int(geometry.AppendPoint(x, y, maxh=edge))

    lip = point(0, 1, lip_edge)
    start, middle, end, top = point(-CHANNEL, 0), point(0, 0), point(JET, 0), point(JET, 1)
    inlet_top = point(-CHANNEL, 1)

    def line(first: int, last: int, name: str, left: int = 1, right: int = 0) -> None:
        edge = ["line", first, last]
        geometry.Append(edge, leftdomain=left, rightdomain=right, bc=name, maxh=bulk_edge)

    def graded(last: int, direction: tuple[float, float], length: float) -> list[int]:
        inner = graded_spacing(length, bulk_edge, growth, start=lip_edge)[1:-1]
        return [lip, *(point(direction[0] * s, 1 + direction[1] * s) for s in inner), last]

    line(start, middle, "symmetry", 1)
    line(middle, end, "symmetry", 2)
    line(end, top, "outlet", 2)
    surface = graded(top, (1, 0), JET)[::-1]
    for first, last in pairwise(surface):
        line(first, last, "free", 2)
    wall = graded(inlet_top, (-1, 0), CHANNEL)
    for first, last in pairwise(wall):
        line(first, last, "wall", 1)
    line(inlet_top, start, "inlet", 1)
    exit_plane = graded(middle, (0, -1), 1.0)
    for first, last in pairwise(exit_plane):
        line(first, last, "exit", 2, 1)
    geometry.SetMaterial(1, "channel")
    geometry.SetMaterial(2, "jet")
    return ng.Mesh(geometry.GenerateMesh(maxh=bulk_edge, grading=0.3))


@exclusive
def swell_problem(
    lip_edge: float,
    bulk_edge: float = 0.35,
    growth: float = 0.25,
    law: ViscosityLaw | None = None,
) -> tuple[ng.Mesh, Boundaries]:
    """Return mesh and boundaries of the die swell problem, arguments as in `solve_die_swell`."""
    profile, inflow = 1.5 * (1 - ng.y**2), {}
    if law is not None and not law.is_newtonian:
        y = np.linspace(0.0, 1.0, PROFILE_POINTS)
        u = SlitFlow(law, 2.0, 1.0).velocity(y)
        # a table over x and y, the same for every x
        profile = ng.VoxelCoefficient(
            (-CHANNEL, 0.0), (0.0, 1.0), np.repeat(u[:, None], 2, axis=1), linear=True
        )
        inflow = {"inlet": 1.0}
    boundaries = Boundaries(
        moving="jet",
        free="free",
        velocity={"inlet": (profile, 0), "wall": (0, 0)},
        held=("exit|outlet|wall|inlet", "exit|symmetry|wall|inlet"),
        symmetry=("", "symmetry|outlet"),
        inflow=inflow,
    )
    return _mesh(lip_edge, bulk_edge, growth), boundaries


@exclusive
def solve_die_swell(
    lip_edge: float,
    order: int = 3,
    bulk_edge: float = 0.35,
    growth: float = 0.25,
    tolerance: float = 1e-7,
    law: ViscosityLaw | None = None,
) -> DieSwell:
    """Return the swell ratio of a jet without surface tension.

    Parameters
    ----------
    lip_edge : float
        Mesh edge at the lip, in half-widths.
    order : int
        Polynomial degree of the velocity.
    bulk_edge : float
        Largest edge, in half-widths.
    growth : float
        Added edge length per distance from the lip.
    tolerance : float
        Newton stops when no node moves further, in half-widths; what is left is its square.
    law : ViscosityLaw, optional
        In units of half-width and mean speed, of order one at the wall's rate of some 3; Newtonian
        without.

    Raises
    ------
    ConvergenceError
        If Newton does not reach the tolerance in 12 steps.

    References
    ----------
    Swell ratio 1.186 to 1.187 (Newtonian, planar, no surface tension): Mitsoulis, Georgiou and
    Kountouriotis, Computers & Fluids 57 (2012) 195, and the sources there.
    """
    mesh, boundaries = swell_problem(lip_edge, bulk_edge, growth, law)
    flow = FreeSurfaceFlow(mesh, boundaries, order, law)
    count, size = settle(flow, tolerance, bulk_edge, "die swell")
    height = flow.surface("free", np.array([0.0, 1.0]))[-1, 1]
    return DieSwell(float(height), flow.unknowns, count, size)


def settle(
    flow: FreeSurfaceFlow, tolerance: float, bulk_edge: float, called: str
) -> tuple[int, float]:
    """Take Newton's steps until no node moves further; return how many, and the last one's size.

    Parameters
    ----------
    flow : FreeSurfaceFlow
        The jet.
    tolerance : float
        As in `solve_die_swell`.
    bulk_edge : float
        What its mesh was made with, to be told.
    called : str
        Which jet it is.

    Raises
    ------
    ConvergenceError
        If that takes more than 12 steps.
    """
    for count in range(1, MAX_STEPS + 1):
        step = flow.step()
        if step.size < tolerance and step.fraction == 1.0:
            return count, step.size
    msg = (
        f"{called}: node moves of {step.size:.1e} after {MAX_STEPS} Newton steps "
        f"(bound {tolerance:g}); try a shorter bulk_edge than {bulk_edge:g}"
    )
    raise ConvergenceError(msg)
