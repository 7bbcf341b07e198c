"""Fields on curved triangles as plain arrays: what is left of a solve once the solver is gone.

A `FlowField` can be stored, drawn and evaluated anywhere without a finite-element library. Node
order within a triangle is VTK's for Lagrange triangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fibermelt.arrays import Unchanging, real_array
from fibermelt.flow.lagrange import LagrangeTriangle

__all__ = ["FlowField", "Place"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

MAX_NEWTON = 12
"""Inverse mapping: 4 steps on the most curved triangles seen."""

STRAIGHT = 1e-11
"""A triangle whose nodes lie this near [sizes] to where straight edges put them is straight."""

INSIDE = 1e-9
"""A barycentric coordinate above -INSIDE counts as inside: rounding on shared edges."""

MAX_WALK = 200
"""Triangles crossed in one search from the nearest centroid; meshes here need a handful."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where points lie: triangle (-1 if outside) and reference coordinates (n, 2) in it."""

    cell: Index
    reference: Array

    @property
    def found(self) -> NDArray[np.bool_]:
        """Return which points lie inside the field."""
        return np.asarray(self.cell >= 0)


@dataclass(frozen=True, eq=False)
class FlowField(Unchanging):
    """Velocity, pressure, gradient and stream function of a planar flow, in SI units.

    Parameters
    ----------
    order : int
        Degree of the triangles and of every field on them.
    points : (n, 2) array
        Nodes [m].
    cells : (n_cells, n_local) int array
        Nodes of each triangle: corners, edges 01, 12, 20, inside.
    velocity : (n, 2) array
        [m/s].
    pressure : (n,) array
        [Pa], zero in the surrounding air.
    gradient : (n, 2, 2) array
        ``L[i, j] = d u_i / d x_j`` [1/s], recovered into a continuous field, without trace.
    stream_function : (n,) array
        ``psi`` [m2/s] with ``u = d psi/dy``, ``v = -d psi/dx``; zero on the left wall and the bed.
    viscosity : (n,) array
        Viscosity of the melt [Pa s] at its rate of deformation.
    gradient_error : (n,) array
        Estimated error of ``gradient`` [1/s], in Frobenius's norm; zero where none was made.
    """

    order: int
    points: Array
    cells: Index
    velocity: Array
    pressure: Array
    gradient: Array
    stream_function: Array
    viscosity: Array
    gradient_error: Array

    @cached_property
    def _shape(self) -> LagrangeTriangle:
        return LagrangeTriangle(self.order)

    @cached_property
    def _corners(self) -> Array:
        return self.points[self.cells]

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points[self.cells[:, :3]].mean(axis=1))

    @cached_property
    def _neighbour(self) -> Index:
        """Triangle across the edge opposite to each corner, -1 on the boundary."""
        n = len(self.cells)
        opposite = self.cells[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2)
        keys = np.sort(opposite, axis=1)
        order = np.lexsort(keys.T)
        same = np.all(keys[order[1:]] == keys[order[:-1]], axis=1)
        first, second = order[:-1][same], order[1:][same]
        neighbour = np.full(3 * n, -1, dtype=np.int64)
        neighbour[first], neighbour[second] = second // 3, first // 3
        return neighbour.reshape(n, 3)

    @property
    def shear_rate(self) -> Array:
        """Return ``gamma_dot = sqrt(2 D:D)`` at the nodes [1/s]."""
        D = 0.5 * (self.gradient + self.gradient.swapaxes(1, 2))
        return np.asarray(np.sqrt(2 * np.einsum("nij,nij->n", D, D)))

    @cached_property
    def _straight(self) -> tuple[NDArray[np.bool_], Array]:
        """Return which triangles are straight, and the inverse of their maps' slopes, of all."""
        nodes = self._corners
        corner, sides = nodes[:, :1], nodes[:, 1:3] - nodes[:, :1]
        off = nodes - corner - self._shape.nodes @ sides
        size = np.abs(sides).sum(axis=(1, 2))
        is_straight = np.asarray(np.abs(off).max(axis=(1, 2)) <= STRAIGHT * size)
        return is_straight, np.asarray(np.linalg.inv(sides), dtype=np.float64)

    def _inverse_map(self, xy: Array, cell: Index, start: Array) -> Array:
        """Return the reference coordinates of ``xy`` in ``cell``, inside it or not."""
        straight, inverse = self._straight
        corner = self.points[self.cells[cell, 0]]
        reference: Array = np.einsum("nd,ndr->nr", xy - corner, inverse[cell])
        curved = np.flatnonzero(~straight[cell])
        if curved.size:
            reference[curved] = self._curved_map(xy[curved], cell[curved], start[curved])
        return reference

    def _curved_map(self, xy: Array, cell: Index, start: Array) -> Array:
        """Return the same for triangles with a curved edge: Newton from ``start``."""
        reference = start.copy()
        nodes = self._corners[cell]
        size = np.abs(nodes[:, 1:3] - nodes[:, :1]).sum(axis=(1, 2))
        left = np.arange(len(xy))
        for _ in range(MAX_NEWTON):
            values, slopes = self._shape.evaluate(reference[left])
            miss = xy[left] - np.einsum("nk,nkd->nd", values, nodes[left])
            J = np.einsum("nkr,nkd->ndr", slopes, nodes[left])
            det = J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0]
            move = np.stack(
                [
                    J[:, 1, 1] * miss[:, 0] - J[:, 0, 1] * miss[:, 1],
                    J[:, 0, 0] * miss[:, 1] - J[:, 1, 0] * miss[:, 0],
                ],
                axis=1,
            )
            # a far-away guess is pulled in: the curved map is only good near its triangle
            reference[left] += np.clip(move / det[:, None], -2.0, 2.0)
            left = left[np.abs(miss).max(axis=1) > 1e-13 * size[left]]
            if left.size == 0:
                break
        return reference

    def locate(self, xy: Array, guess: Place | None = None) -> Place:
        """Return where the points ``xy`` (n, 2) lie, walking from ``guess`` if there is one."""
        xy = real_array("points", xy)
        n = len(xy)
        if guess is None or not guess.found.all():
            cell = np.asarray(self._tree.query(xy)[1], dtype=np.int64)
            reference = np.full((n, 2), 1 / 3)
        else:
            cell, reference = guess.cell.copy(), guess.reference.copy()
        active = np.arange(n)
        for _ in range(MAX_WALK):
            found = self._inverse_map(xy[active], cell[active], reference[active])
            reference[active] = found
            bary = np.column_stack([1 - found.sum(axis=1), found])
            worst = bary.argmin(axis=1)
            outside = bary[np.arange(len(active)), worst] < -INSIDE
            active, worst = active[outside], worst[outside]
            if active.size == 0:
                break
            cell[active] = self._neighbour[cell[active], worst]
            lost = cell[active] < 0
            active = active[~lost]
            reference[active] = 1 / 3
            if active.size == 0:
                break
        else:
            cell[active] = -1
        return Place(cell, reference)

    def evaluate(self, values: Array, place: Place) -> Array:
        """Return nodal ``values`` (n, ...) interpolated at ``place``; NaN outside the field."""
        weights, _ = self._shape.evaluate(place.reference)
        result = np.einsum("nk,nk...->n...", weights, values[self.cells[place.cell]])
        result[~place.found] = np.nan
        return np.asarray(result)

    def velocity_at(self, place: Place) -> Array:
        """Return the velocity at ``place`` [m/s]; NaN outside the field."""
        return self.evaluate(self.velocity, place)
