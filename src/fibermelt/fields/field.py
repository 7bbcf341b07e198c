"""A flow on triangles or tetrahedra, whatever made it: what paths are followed through.

Between nodes, values are linear in each cell; the velocity is quadratic, with the help of the
nodal gradients (see `Field.velocity_at`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fibermelt.arrays import Unchanging, real_array
from fibermelt.errors import ConfigError
from fibermelt.fields.simplices import Facets, facets, signed_sizes

__all__ = ["Field", "Geometry", "Place"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

Geometry = Literal["planar", "axisymmetric", "spatial"]

INSIDE = 1e-9
"""A barycentric coordinate above -INSIDE counts as inside: rounding on shared facets."""

MAX_WALK = 64
"""Cells crossed before a walk counts as lost: it may go round in circles on a mesh that is not
Delaunay's, and every cell near the point is then looked at."""

NEAREST = 16
"""Cells with the nearest centres that are looked at before all that may hold a point: on the way
along a path nearly all are in one of them."""

PAIRS = 200_000
"""Pairs of a point and a cell looked at in one go: 20 MB."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where points lie: cell (-1 if outside) and barycentric coordinates (n, d) in it.

    The coordinates are those of the second corner and on; that of the first is what is left to 1.
    """

    cell: Index
    reference: Array

    @property
    def found(self) -> NDArray[np.bool_]:
        """Return which points lie inside the field."""
        return np.asarray(self.cell >= 0)

    @property
    def weights(self) -> Array:
        """Return the barycentric coordinates of all corners, (n, d + 1)."""
        return np.column_stack([1.0 - self.reference.sum(axis=1), self.reference])


@dataclass(frozen=True, eq=False, repr=False)
class Field(Unchanging):
    """A steady flow on triangles or tetrahedra, in SI units.

    Parameters
    ----------
    geometry : str
        "planar" (z = 0, nothing across), "axisymmetric" (x along the axis, y the radius, third
        component around it) or "spatial".
    points : (n, 3) array
        Nodes [m].
    cells : (m, 3 or 4) int array
        Corners of each triangle (planar, axisymmetric) or tetrahedron (spatial).
    velocity : (n, 3) array
        [m/s].
    gradient : (n, 3, 3) array
        ``L[i, j] = d u_i / d x_j`` [1/s] without trace; axisymmetric with ``u_r / r`` in [2, 2].
    gradient_error : (n,) array
        Estimated error of ``gradient`` [1/s], in Frobenius's norm.
    divergence : (n,) array
        The trace that was removed from ``gradient`` [1/s], in equal parts from each direction that
        the flow has: two of a planar flow, three of any other.
    pressure, viscosity, temperature : (n,) array, optional
        [Pa], zero in the surrounding air; [Pa s]; [K].
    near_wall : (n,) bool array
        Where the gradient is one-sided (on the boundary) or a sharp edge is near.
    near_edge : (n,) bool array, optional
        Where a sharp edge that points into the flow is near, within two cells: the gradient there
        has no limit as a mesh is refined.
    cut : (n,) bool array, optional
        Where cells were left out as the file has no numbers at other corners of them.
    notes : tuple of str
        What was done to the file's data on the way, in words.

    Raises
    ------
    ConfigError
        If shapes disagree, a value is not finite or a cell has no size.
    """

    geometry: Geometry
    points: Array
    cells: Index
    velocity: Array
    gradient: Array
    gradient_error: Array
    divergence: Array
    pressure: Array | None
    viscosity: Array | None
    temperature: Array | None
    near_wall: NDArray[np.bool_]
    near_edge: NDArray[np.bool_] | None = None
    cut: NDArray[np.bool_] | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Take the numbers over, and refuse what is no field."""
        if self.geometry not in {"planar", "axisymmetric", "spatial"}:
            msg = f'field: geometry = "{self.geometry}": must be planar, axisymmetric or spatial'
            raise ConfigError(msg)
        n = len(self.points)
        shapes: dict[str, tuple[int, ...]] = {
            "points": (n, 3),
            "velocity": (n, 3),
            "gradient": (n, 3, 3),
            "gradient_error": (n,),
            "divergence": (n,),
            "pressure": (n,),
            "viscosity": (n,),
            "temperature": (n,),
        }
        for name, shape in shapes.items():
            given = getattr(self, name)
            if given is None and name in {"pressure", "viscosity", "temperature"}:
                continue
            value = real_array(f"field: {name}", given)
            if value.shape != shape:
                msg = f"field: {name} has shape {value.shape}, expected {shape} for {n} points"
                raise ConfigError(msg)
            if not np.all(np.isfinite(value)):
                bad = int(np.flatnonzero(~np.isfinite(value.reshape(n, -1)).all(axis=1))[0])
                msg = (
                    f"field: {name}[{bad}] = {value[bad]} is not finite: leave out the cells there"
                )
                raise ConfigError(msg)
            object.__setattr__(self, name, value)
        object.__setattr__(self, "cells", np.asarray(self.cells, dtype=np.int64))
        for name in ("near_wall", "near_edge", "cut"):
            flags = getattr(self, name)
            marked = np.zeros(n, dtype=bool) if flags is None else np.asarray(flags, dtype=bool)
            object.__setattr__(self, name, marked)
        k = 4 if self.geometry == "spatial" else 3
        if self.cells.ndim != 2 or self.cells.shape[1] != k or not len(self.cells):
            kind = "tetrahedra" if k == 4 else "triangles"
            msg = (
                f"field: cells have shape {self.cells.shape}, expected (m, {k}): a "
                f"{self.geometry} field lies on {kind}"
            )
            raise ConfigError(msg)
        if self.cells.min() < 0 or self.cells.max() >= n:
            msg = f"field: cells name point {int(self.cells.max())}: there are 0 to {n - 1}"
            raise ConfigError(msg)
        flat = np.flatnonzero(signed_sizes(self._plane, self.cells) == 0.0)
        if flat.size:
            msg = f"field: cell {int(flat[0])} has no size: leave it out"
            raise ConfigError(msg)
        super().__post_init__()

    def __repr__(self) -> str:
        """Return geometry and sizes: the arrays are long."""
        return f"Field({self.geometry}, {len(self.points)} points, {len(self.cells)} cells)"

    @property
    def dimension(self) -> int:
        """Return in how many coordinates points differ: 2 or 3."""
        return int(self.cells.shape[1]) - 1

    @property
    def _plane(self) -> Array:
        return self.points[:, : self.dimension]

    @cached_property
    def facets(self) -> Facets:
        """Return how the cells lie together, and the boundary."""
        return facets(self.cells)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Return the lowest and the highest coordinates of the points, (3,) each [m]."""
        return self.points.min(axis=0), self.points.max(axis=0)

    @cached_property
    def _centres(self) -> Array:
        return np.asarray(self._plane[self.cells].mean(axis=1))

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self._centres)

    @cached_property
    def _inverse(self) -> Array:
        """Return the inverse of each cell's sides (m, d, d), which leads to its coordinates."""
        corner = self._plane[self.cells]
        return np.asarray(np.linalg.inv(corner[:, 1:] - corner[:, :1]))

    @cached_property
    def _levels(self) -> tuple[tuple[cKDTree, Index, float], ...]:
        """Return the cells by size: a tree of centres, their numbers, the largest radius of each.

        A cell that holds a point has its centre within its own radius of it.
        """
        away = self._plane[self.cells] - self._centres[:, None]
        radius = np.sqrt(np.einsum("mkd,mkd->mk", away, away).max(axis=1)) * (1.0 + INSIDE)
        level = np.floor(np.log2(radius / radius.min())).astype(np.int64)
        found = []
        for number in np.unique(level):
            members = np.flatnonzero(level == number)
            found.append((cKDTree(self._centres[members]), members, float(radius[members].max())))
        return tuple(found)

    @cached_property
    def _beyond(self) -> Index:
        """Return the cell that a walk enters across the facet opposite to each corner.

        Its neighbour, and where it has none, the cell in which the last point that was lost there
        lay: cells do not meet at whole facets around a sliver that was taken out.
        """
        return facets(self.cells, over_slivers=False).neighbour

    def _reference(self, xyz: Array, cell: Index) -> Array:
        """Return the barycentric coordinates (n, d) of points in their cells, inside or not."""
        away = xyz - self._plane[self.cells[cell, 0]]
        return np.asarray(np.einsum("nd,ndr->nr", away, self._inverse[cell]))

    def locate(self, points: Array, guess: Place | None = None) -> Place:
        """Return where points lie.

        Parameters
        ----------
        points : (n, 3) array
            Points [m]; of a planar or axisymmetric field (n, 2) will do, the third is not looked
            at.
        guess : Place, optional
            Where the same points lay a step before: the search begins there.

        Notes
        -----
        A walk over the neighbours, from the guess or the nearest centre. What it does not find
        (it ends at the boundary of a domain that is not convex, too) is looked for in every cell
        near enough to hold the point, so that no point inside is missed.
        """
        d = self.dimension
        given = real_array("points", points)
        if given.ndim != 2 or given.shape[1] < d:
            msg = f"points have shape {given.shape}, expected (n, 3) or (n, {d})"
            raise ConfigError(msg)
        xyz = np.ascontiguousarray(given[:, :d])
        cell = np.full(len(xyz), -1, dtype=np.int64)
        reference = np.full((len(xyz), d), 1.0 / (d + 1))
        low, high = self.bounds
        slack = INSIDE * float((high - low).max())
        active = np.flatnonzero(
            np.all((xyz >= low[:d] - slack) & (xyz <= high[:d] + slack), axis=1)
        )
        if guess is not None:
            cell[active] = guess.cell[active]
        unknown = active[cell[active] < 0]
        if unknown.size:
            cell[unknown] = self._tree.query(xyz[unknown])[1]
        lost, doors = [], []
        for _ in range(MAX_WALK):
            if not active.size:
                break
            inside = self._reference(xyz[active], cell[active])
            reference[active] = inside
            bary = np.column_stack([1.0 - inside.sum(axis=1), inside])
            worst = bary.argmin(axis=1)
            outside = bary[np.arange(len(active)), worst] < -INSIDE
            active, worst = active[outside], worst[outside]
            across = self._beyond[cell[active], worst]
            closed = across < 0
            lost.append(active[closed])
            doors.append(np.stack([cell[active], worst])[:, closed])
            cell[active] = across
            active = active[~closed]
        left = np.concatenate([*lost, active]) if lost else active
        if left.size:
            cell[left], reference[left] = self._search(xyz[left])
            if doors:
                through = tuple(np.concatenate(doors, axis=1))
                self._beyond[through] = cell[left[: len(through[0])]]
        return Place(cell, reference)

    def _search(self, xyz: Array) -> tuple[Index, Array]:
        """Return cells, -1 where none holds the point, and coordinates, from all cells near."""
        n, d = xyz.shape
        cell = np.full(n, -1, dtype=np.int64)
        reference = np.full((n, d), 1.0 / (d + 1))
        best = np.full(n, -INSIDE)
        near = self._tree.query(xyz, min(NEAREST, len(self.cells)))[1].reshape(n, -1)
        inside = self._reference(np.repeat(xyz, near.shape[1], axis=0), near.ravel())
        least = np.minimum(1.0 - inside.sum(axis=1), inside.min(axis=1)).reshape(near.shape)
        first = least.argmax(axis=1)
        row = np.arange(n)
        there = least[row, first] >= best
        cell[there] = near[there, first[there]]
        reference[there] = inside.reshape(n, -1, d)[there, first[there]]
        rest = np.flatnonzero(~there)
        for tree, members, radius in self._levels if rest.size else ():
            counts = np.zeros(n, dtype=np.int64)
            counts[rest] = tree.query_ball_point(xyz[rest], radius, return_length=True)
            some = np.flatnonzero(counts)
            part = np.cumsum(counts[some]) // PAIRS
            for number in np.unique(part):
                rows = some[part == number]
                near = tree.query_ball_point(xyz[rows], radius)
                row = np.repeat(rows, [len(item) for item in near])
                named = members[np.concatenate(near).astype(np.int64)]
                inside = self._reference(xyz[row], named)
                least = np.minimum(1.0 - inside.sum(axis=1), inside.min(axis=1))
                # the most inside of each point comes first
                order = np.lexsort((-least, row))
                first = order[np.unique(row[order], return_index=True)[1]]
                better = first[least[first] >= best[row[first]]]
                cell[row[better]], reference[row[better]] = named[better], inside[better]
                best[row[better]] = least[better]
        return cell, reference

    def evaluate(self, values: Array, place: Place) -> Array:
        """Return nodal ``values`` (n, ...) interpolated linearly at ``place``; NaN outside."""
        corners = values[self.cells[place.cell]]
        result = np.einsum("nk,nk...->n...", place.weights, corners)
        result[~place.found] = np.nan
        return np.asarray(result)

    @cached_property
    def whole_gradient(self) -> Array:
        """Return the gradient with the trace that was removed from ``gradient`` [1/s]."""
        share = 2 if self.geometry == "planar" else 3
        part = np.zeros((3, 3))
        part[range(share), range(share)] = 1.0 / share
        return np.asarray(self.gradient + self.divergence[:, None, None] * part)

    def velocity_at(self, place: Place) -> Array:
        """Return the velocity (n, 3) at ``place`` [m/s], quadratic in each cell; NaN outside.

        Notes
        -----
        ``sum_i w_i (u_i + L_i (x - x_i) / 2)`` over the corners, with the barycentric weights
        ``w_i`` and the gradients ``L_i`` before their trace was removed. Of a quadratic,
        ``u_i = u - L d_i + d_i H d_i / 2`` and ``L_i = L - H d_i`` at ``d_i = x - x_i``; the terms
        add up to ``u - L sum w_i d_i / 2 = u``, so that quadratics are reproduced. Continuous
        across facets, as it depends on their nodes alone.
        """
        nodes = self.cells[place.cell]
        weights = place.weights
        corner = self._plane[nodes]
        away = (weights[:, None] @ corner) - corner
        factor = weights[..., None] * np.concatenate([np.ones((*nodes.shape, 1)), away], axis=-1)
        result = np.einsum("nkij,nkj->ni", self._expansion[nodes], factor)
        result[~place.found] = np.nan
        return np.asarray(result)

    @cached_property
    def _expansion(self) -> Array:
        """Return ``u`` and ``L / 2`` at the nodes side by side, (n, 3, 1 + d)."""
        half = 0.5 * self.whole_gradient[..., : self.dimension]
        return np.concatenate([self.velocity[..., None], half], axis=-1)
