"""The pressure near a confined fiber on a net of fixed size, whatever the cell's mesh.

A cell's solution comes at the nodes of its own mesh, whose number grows with the aspect ratio and
with the domain size. To lay pictures of several cells side by side in one array (the paper's
Fig. 11), both the nodes' positions and the pressure are read at even steps of the mesh's own two
coordinates, around and outward: they are polynomials of the cell's order on each element, so this
is the finite elements' solution itself, and the net is as fine at the tips as the mesh is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import KroghInterpolator

from fibermelt.errors import ConfigError
from fibermelt.fiber.cell_data import CellNumerics, CellSolution
from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.cell_surface import lagrange_matrix

__all__ = ["NearField", "near_field"]

Array = NDArray[np.float64]

FEWEST = (2, 16)
"""Rings and rays below which nothing could be drawn."""


@dataclass(frozen=True, eq=False)
class NearField:
    """Pressure around a fiber at unit strain, in units and axes of `CellSolution`.

    Parameters
    ----------
    points : (rings, rays, 2) array
        Net, ring 0 on the fiber, ray 0 from the tip, counter-clockwise; over the half-length.
    pressure : (rings, rays, 2) array
        Ring, ray, mode, over ``mu``.
    """

    points: Array
    pressure: Array


def near_field(
    solution: CellSolution, numerics: CellNumerics, reach: float, rings: int, rays: int
) -> NearField:
    """Return the pressure from the fiber to a distance from its centre.

    Parameters
    ----------
    solution : CellSolution
        A cell, on the graded mesh.
    numerics : CellNumerics
        What it was solved with.
    reach : float
        Distance from the centre, to 1e-3, that the outermost ring nowhere falls short of, over the
        half-length; the cell's edge if that is nearer.
    rings, rays : int
        Size of the net, at least 2 and 16.

    Raises
    ------
    ConfigError
        If the net is too small, the mesh is the paper's, or the numerics are not the solution's.
    """
    if rings < FEWEST[0] or rays < FEWEST[1] or not reach > 1.0:
        msg = (
            f"reach = {reach:g}, rings = {rings}, rays = {rays}: the net must go beyond the fiber "
            f"(reach above 1) with at least {FEWEST[0]} rings and {FEWEST[1]} rays"
        )
        raise ConfigError(msg)
    ratio = solution.response.aspect_ratio
    spacings = numerics.angular_spacing, numerics.radial_spacing
    grid = CellGrid(1.0 / ratio, 0.5 * solution.domain_size, *spacings)
    around, outward = grid.columns * numerics.order, grid.rows * numerics.order + 1
    if numerics.mesh != "graded" or len(solution.points) != around * outward:
        msg = (
            f"cell of {len(solution.points)} nodes: the graded mesh of these numerics (order "
            f"{numerics.order}) has {around * outward}; give those that the cell was solved with"
        )
        raise ConfigError(msg)
    nodes = np.concatenate([solution.points, solution.pressure], axis=-1)
    nodes = nodes.reshape(around, outward, 4)
    quarters = 4.0 * np.arange(rays) / rays
    tip = grid.nearest_tip((quarters * grid.columns_per_quarter).astype(np.intp))
    angles = np.mod(grid.eccentric_angle(tip, quarters), 2.0 * np.pi)
    index, weights = lagrange_matrix(grid, numerics.order, angles)
    along_rays = np.einsum("kn,kn...->k...", weights, nodes[index])
    nearest = np.hypot(nodes[..., 0], nodes[..., 1]).min(axis=0)
    last = float(np.interp(reach, nearest, np.arange(outward)))  # the last node if it is nearer
    rows = np.linspace(0.0, last / numerics.order, rings)
    net = _outward(np.swapaxes(along_rays, 0, 1), numerics.order, grid.rows, rows)
    return NearField(net[..., :2], net[..., 2:])


def _outward(values: Array, order: int, rows: int, at: Array) -> Array:
    """Return nodal values (rows * order + 1, ...) at row coordinates, element by element."""
    element = np.minimum(np.floor(at).astype(np.intp), rows - 1)
    found = np.empty((at.size, *values.shape[1:]))
    for k in np.unique(element):
        here = element == k
        part = values[k * order : (k + 1) * order + 1]
        found[here] = KroghInterpolator(np.arange(order + 1.0), part)((at[here] - k) * order)
    return found
