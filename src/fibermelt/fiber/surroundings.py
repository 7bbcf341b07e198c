"""The two flows around a fiber in an unbounded melt, at the points of a net, to be drawn.

What `CellSolution` has for a confined fiber, from the closed forms. Lengths are in units of the
half-length, velocities in half-lengths a second, pressures over ``mu``; axes are the fiber's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.ellipse_field import ellipse_field
from fibermelt.fiber.ellipsoid import Ellipsoid
from fibermelt.fiber.ellipsoid_field import ellipsoid_field
from fibermelt.fiber.models import FiberModel
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.spheroid import Spheroid, embed_planar

__all__ = ["FlowAround", "Surroundings", "strain_at", "surroundings", "turned_to_flow"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

RADIUS = 2.0
"""Half-lengths that are drawn: as far as the default cell reaches, so that pictures compare."""

SPACINGS = (0.6, 0.7)
"""Net around and outward in the stretched coordinates of `CellGrid`, the default cell's."""

PARTS = 6
"""Points along a line of the net: as many as a picture of the default cell has, but one."""

MODES = np.array([[[1.0, 0.0], [0.0, -1.0]], [[0.0, 1.0], [1.0, 0.0]]])
"""Far fields ``D_11 = 1 1/s`` and ``D_12 = 1 1/s``."""


@dataclass(frozen=True, eq=False)
class FlowAround:
    """The flow around a fiber in a given flow, at the points of a net, along the flow's axes.

    Parameters
    ----------
    velocity : (N, 2) array
        Less that of the fiber's centre, which moves with the melt [half-lengths/s].
    pressure : (N,) array
        Less the melt's own [Pa].
    """

    velocity: Array
    pressure: Array


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The two flows in the plane through the fiber's axis, as in `CellSolution`.

    Parameters
    ----------
    points : (N, 2) array
        Points, from the fiber to two half-lengths around its centre.
    cells : (n_cells, 3) integer array
        Triangles between them, counter-clockwise.
    lines : (n_lines, k) integer array
        Points along each line of the net.
    velocity : (N, 2, 2) array
        Point, mode, component.
    pressure : (N, 2) array
        Point, mode; relative to the far field.
    """

    points: Array
    cells: Index
    lines: Index
    velocity: Array
    pressure: Array

    def around(self, gradient: Array, angle: float, viscosity: float) -> FlowAround:
        """Superpose the flow around a fiber in a Newtonian melt.

        In the fiber's axes, with ``D`` and ``w = (L_21 - L_12)/2`` of the melt there,
        ``v = D_11 U_1 + D_12 U_2 + w (-y, x)`` and ``p = mu (D_11 P_1 + D_12 P_2)``: the modes are
        those of a fiber free of torque, which so turns at ``w + B D_12``.

        Parameters
        ----------
        gradient : (2, 2) array
            ``L_ij = d u_i / d x_j`` of the melt along the flow's axes [1/s].
        angle : float
            Of the fiber from the flow's x axis, counter-clockwise [rad].
        viscosity : float
            ``mu`` [Pa s].
        """
        strain, spin = strain_at(gradient, angle)
        local = np.einsum("nmi,m->ni", self.velocity, strain)
        return turned_to_flow(self.points, local, viscosity * self.pressure @ strain, spin, angle)


def strain_at(gradient: Array, angle: float) -> tuple[Array, float]:
    """Return the strain ``D_11, D_12`` [1/s] in a fiber's axes, and the melt's spin ``W_21``.

    Parameters
    ----------
    gradient : (2, 2) array
        ``L_ij`` along the flow's axes [1/s].
    angle : float
        Of the fiber from the flow's x axis [rad].
    """
    turn = _rotation(angle)
    L = turn.T @ gradient @ turn
    strain = np.array([0.5 * (L[0, 0] - L[1, 1]), 0.5 * (L[0, 1] + L[1, 0])])
    return strain, float(0.5 * (L[1, 0] - L[0, 1]))


def turned_to_flow(
    points: Array, velocity: Array, pressure: Array, spin: float, angle: float
) -> FlowAround:
    """Return the flow around a fiber, known in its axes of a melt that only strains, in the flow's.

    Parameters
    ----------
    points, velocity : (N, 2) array
        In the fiber's axes [half-lengths, half-lengths/s].
    pressure : (N,) array
        Less the melt's own [Pa].
    spin : float
        Of the melt [1/s]; a fiber free of torque turns as much faster, and so does all around it.
    angle : float
        Of the fiber from the flow's x axis [rad].
    """
    local = velocity + spin * np.stack([-points[:, 1], points[:, 0]], axis=-1)
    return FlowAround(local @ _rotation(angle).T, pressure)


def _rotation(angle: float) -> Array:
    """Return the matrix from the fiber's axes to the flow's."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def surroundings(model: FiberModel) -> Surroundings:
    """Return the flows around a fiber in an unbounded melt.

    Parameters
    ----------
    model : FiberModel
        An unbounded one; for a confined fiber, `solve_cell` has its own.
    """
    ratio = model.response.aspect_ratio
    points, cells, lines = _net(CellGrid(1.0 / ratio, RADIUS, *SPACINGS))
    velocity, pressure = [], []
    for mode in MODES:
        if model.spheroid is None and model.ellipsoid is None:
            planar = ellipse_field(Ellipse(1.0, ratio), mode, 0.0, points)
            velocity.append(planar.velocity)
            pressure.append(planar.pressure)
        else:
            inside = np.concatenate([points, np.zeros((len(points), 1))], axis=-1)
            body = Spheroid(1.0, ratio).as_ellipsoid()
            if model.ellipsoid is not None:
                a, b, c = model.ellipsoid.semi_axes / model.ellipsoid.semi_axes[0]
                body = Ellipsoid((a, b, c))
            spatial = ellipsoid_field(body, embed_planar(mode), inside)
            velocity.append(spatial.velocity[:, :2])
            pressure.append(spatial.pressure)
    return Surroundings(points, cells, lines, np.stack(velocity, 1), np.stack(pressure, 1))


def _net(grid: CellGrid) -> tuple[Array, Index, Index]:
    """Return the points of a grid's refined rays and rings, triangles, and the grid's own lines."""
    around, outward = grid.columns * PARTS, grid.rows * PARTS + 1
    column = np.repeat(np.arange(grid.columns), PARTS)
    quarters = np.arange(around) / (PARTS * grid.columns_per_quarter)
    depth = np.linspace(0.0, 1.0, outward)
    x, y = grid.position(grid.nearest_tip(column)[:, None], quarters[:, None], depth)
    node = np.arange(around * outward).reshape(around, outward)
    ahead = np.roll(node, -1, axis=0)
    corners = [part.ravel() for part in (node[:, :-1], node[:, 1:], ahead[:, 1:], ahead[:, :-1])]
    cells = [np.stack([corners[0], corners[k], corners[k + 1]], axis=-1) for k in (1, 2)]
    places = np.arange(PARTS + 1)
    starts = np.arange(0, around, PARTS)
    rays = node[starts][:, np.arange(0, outward - 1, PARTS)[:, None] + places]
    rings = node[(starts[:, None] + places) % around][:, :, ::PARTS]
    lines = [rays.reshape(-1, PARTS + 1), np.moveaxis(rings, 1, -1).reshape(-1, PARTS + 1)]
    return np.stack([x.ravel(), y.ravel()], axis=-1), np.concatenate(cells), np.concatenate(lines)
