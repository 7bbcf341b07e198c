"""The unknowns of the free-surface problem: which mesh nodes carry velocity, pressure, shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.forms import BedFilm, Elements

__all__ = ["Boundaries", "Spaces", "elements_of", "spaces_on"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Boundaries:
    """Which part of the mesh does what; names of boundaries are regular expressions.

    Parameters
    ----------
    moving : str
        Region whose mesh follows the free surfaces.
    free : str
        The free surfaces: no traction, ``u.n = 0``, shape unknown.
    velocity : mapping of name to components
        Boundaries on which the velocity is given.
    held : tuple of str, one for each component
        Boundaries on which the mesh may not move in x, in y, in z.
    symmetry : tuple of str, one for each component
        Boundaries on which that component of the velocity vanishes and the others are free.
    pinned : str
        Boundaries whose common points with the free surfaces are the lips: there they are pinned.
    rounded : str
        Boundaries that are curved and stay where they are.
    film : BedFilm, optional
        The bed, if it acts on the free surfaces as a film.
    inflow : mapping of name to float
        Flux through boundaries whose given velocity is no polynomial that the elements have.
    """

    moving: str
    free: str
    velocity: Mapping[str, tuple[Any, ...]]
    held: tuple[str, ...]
    symmetry: tuple[str, ...]
    pinned: str = "wall"
    rounded: str = ""
    film: BedFilm | None = None
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


def _mask(space: Any) -> NDArray[np.bool_]:
    """Return which unknowns of ``space`` are free."""
    return np.fromiter(space.FreeDofs(), dtype=bool, count=space.ndof)


def _nodes(mesh: ng.Mesh, boundaries: str) -> set[Any]:
    """Return the vertices, edges and, in space, faces of boundaries."""
    found: set[Any] = set()
    for element in mesh.Boundaries(boundaries).Elements():
        found.update(element.vertices, element.edges)
        if mesh.dim == 3:
            found.update(element.faces)
    return found


def elements_of(mesh: ng.Mesh, boundaries: Boundaries) -> Elements:
    """Return which elements have an edge on a curved boundary, and which move."""
    names = "|".join(filter(None, (boundaries.free, boundaries.rounded)))
    edges = {node.nr for node in _nodes(mesh, names) if node.type == ng.EDGE}
    curved, moves = ng.BitArray(mesh.ne), ng.BitArray(mesh.ne)
    curved.Clear()
    moves.Clear()
    for element in mesh.Elements(ng.VOL):
        if any(edge.nr in edges for edge in element.edges):
            curved.Set(element.nr)
    for element in mesh.Materials(boundaries.moving).Elements():
        moves.Set(element.nr)
    return Elements(curved, ~curved, moves)


def spaces_on(mesh: ng.Mesh, boundaries: Boundaries, order: int) -> Spaces:
    """Return the spaces on ``mesh`` for a velocity of degree ``order``.

    The displacement has its vertices' unknowns in the moving region and those of full order on
    the edges and faces of the free surfaces, the multiplier those on the surfaces but for the
    pinned lips. What is left out is in no space, so that the matrix has no rows for it.
    """
    axes, dim = ("dirichletx", "dirichlety", "dirichletz")[: mesh.dim], mesh.dim
    given = ["|".join(filter(None, (boundaries.given, one))) for one in boundaries.symmetry]
    u = ng.VectorH1(mesh, order=order, **dict(zip(axes, given, strict=True)))
    p = ng.H1(mesh, order=order - 1)
    parts = mesh.Materials(".*" if boundaries.rounded else boundaries.moving)
    held = dict(zip(axes, boundaries.held, strict=True))
    d = ng.VectorH1(mesh, order=order, definedon=parts, **held)
    lam = ng.H1(mesh, order=order, definedon=mesh.Boundaries(boundaries.free))

    # vertices come first in each of the components; what lies in no element is not free
    is_vertex = np.arange(d.ndof) % (d.ndof // dim) < mesh.nv
    in_mesh = ng.BitArray((_mask(d) & is_vertex).tolist())
    in_surface = ng.BitArray(lam.FreeDofs())
    surface, wall = _nodes(mesh, boundaries.free), _nodes(mesh, boundaries.pinned)
    for node in surface:
        if node.type != ng.VERTEX:
            for dof in d.GetDofNrs(node):
                in_mesh.Set(dof)
    for node in surface & wall:
        for dof in lam.GetDofNrs(node):
            in_surface.Clear(dof)
    in_mesh &= d.FreeDofs()
    for element in (parts - mesh.Materials(boundaries.moving)).Elements():
        for vertex in element.vertices:
            for dof in d.GetDofNrs(vertex):
                in_mesh.Clear(dof)
    moves = np.flatnonzero(np.fromiter(in_mesh, dtype=bool, count=d.ndof))
    coupled = u * p * ng.Compress(d, in_mesh) * ng.Compress(lam, in_surface)
    return Spaces(u * p, d, moves, coupled)
