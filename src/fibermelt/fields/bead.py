"""A bead in space as a field to follow paths through, and the paths of equal flux through it.

Its curved tetrahedra are cut into straight ones between their nodes, half as large. Paths begin in
the nozzle's inlet, in rings and sectors of equal flux by the profile of the melt's own flow there.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import refuse_no_count
from fibermelt.fields.field import Field
from fibermelt.fields.paths import FieldPath, Seeds, trace_field
from fibermelt.fields.simplices import boundary_nodes, facets
from fibermelt.fields.splitting import LAGRANGE_TETRA, split_cells
from fibermelt.flow.problem import BeadDeposition
from fibermelt.flow.streamlines import NEAR_SINGULARITY, SETTLED_SPEED
from fibermelt.melt.slit import PipeFlow

if TYPE_CHECKING:
    from fibermelt.flow.space.field import BeadField

__all__ = ["bead_paths", "bead_seeds", "bead_zones", "followable"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

ON_PLANE = 1e-6
"""z of nodes on the plane of symmetry, at most [diameters]: above rounding."""

INSIDE = 1e-6
"""How far below the inlet paths begin [diameters]: in its plane rounding decides who is inside."""

PROFILE = 4001
"""Radii at which the flux of a profile that is no parabola is summed: to 1e-7 of it."""


def followable(bead: BeadField, problem: BeadDeposition) -> Field:
    """Return a bead as a field of straight tetrahedra; z >= 0.

    Nodes within `NEAR_SINGULARITY` diameters of the lip count as near a sharp edge. On the plane of
    symmetry nothing goes across, exactly: no path leaves through it.

    Parameters
    ----------
    bead : BeadField
        Quadratic, as solved.
    problem : BeadDeposition
        What it solves.
    """
    cells = split_cells(LAGRANGE_TETRA, bead.cells)
    assert cells is not None
    diameter, gap = problem.nozzle.capillary_width, problem.nozzle.gap
    points, velocity, gradient = bead.points.copy(), bead.velocity.copy(), bead.gradient.copy()
    middle = points[:, 2] < ON_PLANE * diameter
    points[middle, 2] = velocity[middle, 2] = 0.0
    across = np.array([[False, False, True], [False, False, True], [True, True, False]])
    gradient[np.ix_(middle)] = np.where(across, 0.0, gradient[middle])
    x, y, z = points.T
    lip = np.hypot(np.hypot(x, z) - 0.5 * diameter, y - gap)
    near = lip < NEAR_SINGULARITY * diameter
    return Field(
        geometry="spatial",
        points=points,
        cells=cells,
        velocity=velocity,
        gradient=gradient,
        gradient_error=bead.gradient_error,
        divergence=bead.divergence,
        pressure=bead.pressure,
        viscosity=bead.viscosity,
        temperature=None,
        near_wall=boundary_nodes(points, cells, facets(cells)) & ~middle,
        near_edge=near,
    )


def _rings(count: int) -> list[int]:
    """Return the sectors of each ring of half a disc, from its middle, ``count`` in all.

    Ring k of R has the share ``(2 k - 1)/R^2``: rings are as wide as sectors are long, where the
    root of the flux within is taken for the radius.
    """
    rings = max(1, round(float(np.sqrt(2.0 * count / np.pi))))
    share = count * (2.0 * np.arange(1, rings + 1) - 1.0) / rings**2
    upto = np.rint(np.cumsum(share)).astype(np.int64)
    return [int(n) for n in np.diff(np.r_[0, upto]) if n > 0]


def bead_seeds(problem: BeadDeposition, count: int) -> Seeds:
    """Return where paths of equal flux begin in the inlet, numbered from its upstream side.

    Parameters
    ----------
    problem : BeadDeposition
        Nozzle, melt and speeds.
    count : int
        Paths through half of the nozzle, z > 0.

    Notes
    -----
    A ring has as many sectors as its share of the flux says, and all sectors carry the same. Each
    path begins at its sector's middle angle, and at the radius that halves its flux. A Newtonian
    melt has the part ``1 - (1 - rho^2)^2`` of its flux within ``rho`` radii.
    """
    refuse_no_count("streamlines.count", count)
    nozzle = problem.nozzle
    sectors = _rings(count)
    outer = np.cumsum(sectors) / count
    within = outer - 0.5 * np.array(sectors) / count
    radius = np.repeat(_radius(problem, within), sectors)
    angle = np.concatenate([np.pi * (np.arange(n) + 0.5) / n for n in sectors])
    x, z = radius * np.cos(angle), radius * np.sin(angle)
    order = np.lexsort((z, np.round(x / nozzle.inlet_width, 9)))
    y = np.full(count, nozzle.inlet_height - INSIDE * nozzle.capillary_width)
    fraction = (np.arange(count) + 0.5) / count
    return Seeds(np.column_stack([x, y, z])[order], fraction, 0.5 * problem.flux)


def _radius(problem: BeadDeposition, within: Array) -> Array:
    """Return the radii [m] within which parts of the flux pass the inlet."""
    half = 0.5 * problem.nozzle.inlet_width
    if problem.melt.is_newtonian:
        return np.asarray(half * np.sqrt(1.0 - np.sqrt(1.0 - within)))
    rho = np.linspace(0.0, 1.0, PROFILE)
    pipe = PipeFlow(problem.melt, problem.nozzle.inlet_width, problem.inlet_speed)
    density = rho * pipe.velocity(half * rho)
    passed = np.r_[0.0, np.cumsum(0.5 * (density[1:] + density[:-1]))]
    return np.asarray(half * np.interp(within, passed / passed[-1], rho))


def bead_paths(
    field: Field, problem: BeadDeposition, count: int, points: int
) -> tuple[FieldPath, ...]:
    """Return paths of equal flux through half of a bead.

    Parameters
    ----------
    field : Field
        Of `followable`.
    problem : BeadDeposition
        What it solves.
    count, points : int
        Paths, and points on each.

    Raises
    ------
    ConfigError
        If there are no paths, or fewer than 50 points on each.
    ConvergenceError
        If a path leaves the field anywhere but at the outlet.
    """
    paths = trace_field(field, bead_seeds(problem, count), points, problem.melt)
    nozzle = problem.nozzle
    return tuple(
        replace(path, near_singularity=True)
        if path.history.position[-1, 0] < nozzle.outlet - ON_PLANE * nozzle.capillary_width
        else path
        for path in paths
    )


def bead_zones(path: FieldPath, problem: BeadDeposition) -> Array:
    """Return when a path reaches zones 1 to 3 [s], (3,); NaN if it does not.

    They are those of a streamline in the plane: the capillary's entrance, the nozzle's exit, and
    from where on the velocity stays within 2 % of the bed's. A straight nozzle has no zone 1.
    """
    history, nozzle = path.history, problem.nozzle
    is_straight = nozzle.inlet_width == nozzle.capillary_width
    entrance = np.nan if is_straight else history.time_across(1, nozzle.capillary_entrance)
    bed = np.array([problem.bed_speed, 0.0, 0.0])
    miss = np.linalg.norm(history.velocity - bed, axis=1)
    unsettled = np.flatnonzero(miss > SETTLED_SPEED * problem.bed_speed)
    last = int(unsettled[-1]) + 1 if unsettled.size else 0
    settled = float(history.time[last]) if last < len(history) else np.nan
    return np.array([entrance, history.time_across(1, nozzle.gap), settled])
