"""The unknowns of the free-surface problem: which mesh nodes carry velocity, pressure, shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import MeshError
from fibermelt.flow.forms import Elements

__all__ = ["Boundaries", "Spaces", "elements_of", "spaces_on"]

Array = NDArray[np.float64]

PIN_DISTANCE = 1e-9
"""A mesh vertex this near to a lip is the lip (coordinates are of order one)."""


@dataclass(frozen=True)
class Boundaries:
    """Which part of the mesh does what; names of boundaries are regular expressions.

    Parameters
    ----------
    moving : str
        Region whose mesh follows the free surfaces.
    free : str
        The free surfaces: no traction, ``u.n = 0``, shape unknown.
    velocity : mapping of name to (u, v)
        Boundaries on which the velocity is given.
    symmetry : str
        Boundaries along x on which only ``v = 0`` is given.
    inflow : mapping of name to float
        Flux through boundaries whose given velocity is no polynomial that the elements have.
    held_x, held_y : str
        Boundaries on which the mesh may not move in x, in y.
    lips : (n, 2) array
        Where free surfaces are pinned.
    """

    moving: str
    free: str
    velocity: Mapping[str, tuple[Any, Any]]
    held_x: str
    held_y: str
    lips: NDArray[np.float64]
    symmetry: str = ""
    inflow: Mapping[str, float] = field(default_factory=dict)

    @property
    def given(self) -> str:
        """Return the boundaries on which the velocity is given, as one expression."""
        return "|".join(self.velocity)


@dataclass(frozen=True, eq=False)
class Spaces:
    """The spaces on one mesh.

    Parameters
    ----------
    flow : product space
        Velocity (P_k) and pressure (P_k-1).
    displacement : space
        The mesh's displacement at full order everywhere: what the mesh is moved by.
    moves : (n,) int array
        Unknowns of ``displacement`` that are unknowns of the coupled problem.
    coupled : product space
        Velocity, pressure, those unknowns of the displacement, and the multiplier.
    """

    flow: Any
    displacement: Any
    moves: NDArray[np.int64]
    coupled: Any


def _vertex_at(mesh: ng.Mesh, point: Array) -> int:
    """Return the number of the mesh vertex at ``point``."""
    distance = np.hypot(*(mesh.ngmesh.Coordinates() - point).T)
    nearest = int(np.argmin(distance))
    if distance[nearest] > PIN_DISTANCE:
        msg = (
            f"no mesh vertex at the lip {tuple(point)}, the nearest is {distance[nearest]:.1e} off"
        )
        raise MeshError(msg)
    return nearest


def _mask(space: Any) -> NDArray[np.bool_]:
    """Return which unknowns of ``space`` are free."""
    return np.fromiter(space.FreeDofs(), dtype=bool, count=space.ndof)


def elements_of(mesh: ng.Mesh, boundaries: Boundaries) -> Elements:
    """Return which elements have an edge on a free surface, and which of the others move."""
    surface = mesh.Boundaries(boundaries.free).Elements()
    on_surface = {edge.nr for element in surface for edge in element.edges}
    curved, moving = ng.BitArray(mesh.ne), ng.BitArray(mesh.ne)
    curved.Clear()
    moving.Clear()
    for element in mesh.Materials(boundaries.moving).Elements():
        is_curved = any(edge.nr in on_surface for edge in element.edges)
        (curved if is_curved else moving).Set(element.nr)
    return Elements(curved, ~curved, moving)


def spaces_on(mesh: ng.Mesh, boundaries: Boundaries, order: int) -> Spaces:
    """Return the spaces on ``mesh`` for a velocity of degree ``order``.

    The displacement has its vertices' unknowns in the moving region and those of full order on
    the edges of the free surfaces, the multiplier those on the surfaces but for the pinned lips.
    What is left out is in no space, so that the matrix has no rows for it.
    """
    fixed_y = "|".join(filter(None, (boundaries.given, boundaries.symmetry)))
    held = {"dirichletx": boundaries.held_x, "dirichlety": boundaries.held_y}
    u = ng.VectorH1(mesh, order=order, dirichletx=boundaries.given, dirichlety=fixed_y)
    p = ng.H1(mesh, order=order - 1)
    d = ng.VectorH1(mesh, order=order, definedon=mesh.Materials(boundaries.moving), **held)
    lam = ng.H1(mesh, order=order, definedon=mesh.Boundaries(boundaries.free))

    # vertices come first in each of the two components; what lies in no element is not free
    is_vertex = np.arange(d.ndof) % (d.ndof // 2) < mesh.nv
    in_mesh = ng.BitArray((_mask(d) & is_vertex).tolist())
    in_surface = ng.BitArray(lam.FreeDofs())
    edges = {
        edge for element in mesh.Boundaries(boundaries.free).Elements() for edge in element.edges
    }
    for edge in edges:
        for dof in d.GetDofNrs(edge):
            in_mesh.Set(dof)
    for lip in boundaries.lips:
        for dof in lam.GetDofNrs(ng.NodeId(ng.VERTEX, _vertex_at(mesh, lip))):
            in_surface.Clear(dof)
    in_mesh &= d.FreeDofs()
    moves = np.flatnonzero(np.fromiter(in_mesh, dtype=bool, count=d.ndof))
    coupled = u * p * ng.Compress(d, in_mesh) * ng.Compress(lam, in_surface)
    return Spaces(u * p, d, moves, coupled)
