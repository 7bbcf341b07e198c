"""Round die swell: the free surface in space against its own exact benchmark.

A round die of unit radius lets its melt out into the air, at a mean speed of one; without surface
tension a Newtonian jet ends 13.0 % thicker than the die. It is solved as a half tube, whose answer
does not know that it is axisymmetric.
"""

from __future__ import annotations

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.dieswell import DieSwell, settle
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.space.tube import Tube, tube_mesh
from fibermelt.flow.spaces import Boundaries
from fibermelt.threads import exclusive

__all__ = ["round_swell_problem", "solve_round_swell"]

Array = NDArray[np.float64]

DIE, JET = 2.0, 4.0
"""Lengths in radii: the end effects decay as exp(-4.5 x) and exp(-3.8 x), below 1e-3 of themselves
here."""


def _straight(along: Array, across: Array) -> Array:
    """Place a strand as it comes, its axis along x."""
    return np.column_stack([along, across])


@exclusive
def round_swell_problem(
    lip_edge: float, bulk_edge: float = 0.5, sectors: int = 12, growth: float = 0.5
) -> tuple[ng.Mesh, Boundaries, Array]:
    """Return mesh, boundaries and its edges' middles, arguments as in `solve_round_swell`."""
    tube = Tube.graded((-DIE, JET), lip_edge, bulk_edge, sectors, growth)
    mesh, middles = tube_mesh(tube, _straight)
    profile = 2.0 * (1 - ng.y**2 - ng.z**2)
    boundaries = Boundaries(
        moving="strand",
        free="free",
        velocity={"inlet": (profile, 0, 0), "wall": (0, 0, 0)},
        held=("inlet|wall|outlet", "inlet|wall", "inlet|wall|symmetry"),
        symmetry=("", "outlet", "symmetry|outlet"),
        rounded="wall",
        inflow={"inlet": np.pi / 2},
    )
    return mesh, boundaries, middles


@exclusive
def solve_round_swell(
    lip_edge: float,
    order: int = 2,
    bulk_edge: float = 0.5,
    sectors: int = 12,
    growth: float = 0.5,
    tolerance: float = 1e-5,
) -> DieSwell:
    """Return the swell ratio of a round jet without surface tension.

    With a lip edge of 0.05 and 16 sectors it is 0.007 above the literature's.

    Parameters
    ----------
    lip_edge : float
        Mesh edge at the lip, in radii: of its layers and of its outermost ring.
    order : int
        Polynomial degree of the velocity.
    bulk_edge : float
        Largest edge, in radii.
    sectors : int
        Elements around half of the rim, a multiple of four.
    growth : float
        Added edge length per distance from the lip.
    tolerance : float
        Newton stops when no node moves further, in radii.

    Raises
    ------
    ConvergenceError
        If Newton does not reach the tolerance in 12 steps.

    References
    ----------
    Swell ratio 1.130 (Newtonian, round, no surface tension): Mitsoulis, Georgiou and Kountouriotis,
    Computers & Fluids 57 (2012) 195, and the sources there.
    """
    mesh, boundaries, middles = round_swell_problem(lip_edge, bulk_edge, sectors, growth)
    flow = FreeSurfaceFlow(mesh, boundaries, order, middles=middles)
    count, size = settle(flow, tolerance, bulk_edge, "round die swell")
    area = 2 * flow.area("outlet")
    return DieSwell(float(np.sqrt(area / np.pi)), flow.unknowns, count, size)
