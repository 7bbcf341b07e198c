"""A rigid spheroid in a thinning melt, its axis in the plane of a planar flow, in 3D (NGSolve).

The cell of `fibermelt.fiber.cell.thinning` in three dimensions: far field ``D x`` with ``D = d [[cos
phi, sin phi], [sin phi, -cos phi]]`` in the plane of the fiber's axis and nothing across, half-length
``a = 1``. The fiber turns about z alone; no torque acts on it.

Coordinates are confocal: ``(x, y, z) = (A e_x, B e_y, B e_z)``, ``e`` on the unit sphere, ``A + B =
exp(s)``, ``A - B = c^2 exp(-s)``, ``c^2 = 1 - 1/r_e^2``, the sphere included. The plane's mirror and half
a turn about z leave the flow unchanged, so the quarter ``x >= 0``, ``z >= 0`` is solved. At its cut ``x
= 0`` the point ``(0, y, z)`` sees at ``(0, -y, z)`` the opposite ``u_x, u_y`` and the same ``u_z, p``:
a periodic boundary with a sign. Velocity of order k, continuous pressure of order k - 1 on
hexahedra, prisms at the pole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import netgen.meshing as ngm
import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from fibermelt.fiber.cell.thinning import TorqueFreeCell
from fibermelt.fiber.spheroid import Spheroid
from fibermelt.melt import ViscosityLaw

__all__ = ["SpheroidCell", "SpheroidGrid"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SpheroidGrid:
    """How the quarter of space is divided.

    Parameters
    ----------
    layers, meridian, azimuth : int
        Elements outward, from the tip to the equator, and around the half ``z >= 0``, even.
    order : int
        Of the velocity.
    outer : float
        Largest half-axis of the outer surface over the fiber's half-length [-].
    first_layer, first_angle : float
        First layer in ``s`` and first eccentric angle at the tip, both over ``1/r_e``: the angle at
        which the tip turns to the side [-].
    """

    layers: int = 6
    meridian: int = 6
    azimuth: int = 4
    order: int = 3
    outer: float = 10.0
    first_layer: float = 0.3
    first_angle: float = 0.5
    readings: int = 12
    extra: int = 2


class SpheroidCell(TorqueFreeCell):
    """A spheroid in a quarter of space.

    Parameters
    ----------
    fiber : Spheroid
        The fiber; its size does not matter.
    law : ViscosityLaw
        The melt.
    grid : SpheroidGrid
        The division.
    """

    def __init__(self, fiber: Spheroid, law: ViscosityLaw, grid: SpheroidGrid) -> None:
        self.grid = grid
        mesh, self._shift = _mesh(fiber.aspect_ratio, grid)
        given = "fiber|edge"
        in_plane = ng.H1(mesh, order=grid.order, dirichlet=given, dirichlet_bbnd="axis")
        across = ng.H1(mesh, order=grid.order, dirichlet=given + "|plane")
        odd, even = [-1], [1]
        u, w = ng.Periodic(in_plane, phase=odd), ng.Periodic(across, phase=even)
        p = ng.Periodic(ng.H1(mesh, order=grid.order - 1), phase=even)
        super().__init__(u * u * w * p, law, grid.extra)
        side = np.linspace(0.0, 1.0, grid.readings + 1)
        square = [(x, y) for x in side for y in side]
        half = [(x, y) for x, y in square if x + y <= 1.0 + 1e-9]
        rules = {
            shape: ng.IntegrationRule(points, [0.0] * len(points))
            for shape, points in ((ng.ET.QUAD, square), (ng.ET.TRIG, half))
        }
        self._surface = mesh.MapToAllElements(rules, mesh.Boundaries("fiber"))
        points = np.asarray(ng.CF((ng.x, ng.y, ng.z))(self._surface))
        self.points = points.reshape(-1, 3)

    def _rates(self, fields: Any) -> tuple[Any, Any, Any]:
        *velocity, p = fields
        gradient = ng.CF(tuple(ng.grad(part) for part in velocity), dims=(3, 3))
        return ng.Sym(gradient), ng.Trace(gradient), p

    def _set_velocity(self, function: Any, field: tuple[Any, Any], boundary: str = "") -> None:
        where = {"definedon": self.space.mesh.Boundaries(boundary)} if boundary else {}
        for part, value in zip(function.components[:2], field, strict=True):
            part.Set(value, **where)

    def _surface_pressure(self) -> Array:
        pressure = self.flow.components[3]
        read = np.asarray(pressure(self._surface)).ravel()
        edge = ng.ds("edge", bonus_intorder=4)
        mesh = self.space.mesh
        level = ng.Integrate(pressure * edge, mesh) / ng.Integrate(ng.CF(1.0) * edge, mesh)
        return np.asarray(read - level)


def _graded(first: float, total: float, count: int) -> Array:
    """Return ``count`` intervals in geometric progression from ``first`` to ``total``."""
    if first * count >= total:
        return np.linspace(0.0, total, count + 1)
    ratio = brentq(lambda g: first * (g**count - 1.0) / (g - 1.0) - total, 1.0 + 1e-9, 1e3)
    return np.concatenate([[0.0], np.cumsum(first * ratio ** np.arange(count))])


def _mesh(aspect_ratio: float, grid: SpheroidGrid) -> tuple[Any, Any]:
    """Return the curved quarter of space and the deformation that has to outlive it.

    Unit vectors ``e`` are linear between vertices and divided by their length, which is smooth
    across the pole, where the azimuth is not.
    """
    squared = 1.0 - aspect_ratio**-2
    start = np.log1p(1.0 / aspect_ratio)
    outward = np.log(grid.outer + np.sqrt(grid.outer**2 - squared)) - start
    shells = start + _graded(grid.first_layer / aspect_ratio, outward, grid.layers)
    angles = _graded(grid.first_angle / aspect_ratio, 0.5 * np.pi, grid.meridian)
    around = np.linspace(0.0, np.pi, grid.azimuth + 1)
    last, half = grid.meridian, grid.azimuth // 2
    raw = ngm.Mesh(dim=3)
    number: dict[tuple[int, int, int], Any] = {}
    charts: list[tuple[float, ...]] = []

    def vertex(i: int, j: int, k: int) -> Any:
        """Return the vertex, one at the pole for every azimuth."""
        key = (i, j, k if j > 0 else 0)
        if key not in number:
            nu, psi = angles[j], around[k]
            e = (np.cos(nu), np.sin(nu) * np.cos(psi), np.sin(nu) * np.sin(psi))
            far, near = 0.5 * np.exp(shells[i]), 0.5 * squared * np.exp(-shells[i])
            point = ((far + near) * e[0], (far - near) * e[1], (far - near) * e[2])
            number[key] = raw.Add(ngm.MeshPoint(ngm.Pnt(*point)))
            charts.append((*e, shells[i]))
        return number[key]

    for index, name in enumerate(("fiber", "edge", "plane", "cut"), 1):
        raw.Add(ngm.FaceDescriptor(surfnr=index, domin=1, domout=0, bc=index))
        raw.SetBCName(index - 1, name)
    raw.SetMaterial(1, "melt")
    # numbered alike on both halves of the cut, from the axis on: faces that are identified must
    # have their vertices in the same order
    for k in (half, *range(half), *range(grid.azimuth, half, -1)):
        for i in range(grid.layers + 1):
            vertex(i, last, k)
    for i, j, k in np.ndindex(grid.layers, last, grid.azimuth):
        square = ((j, k), (j + 1, k), (j + 1, k + 1), (j, k + 1))
        below = list(dict.fromkeys(vertex(i, *at) for at in square))
        above = list(dict.fromkeys(vertex(i + 1, *at) for at in square))
        raw.Add(ngm.Element3D(1, below + above))
        if i == 0:
            raw.Add(ngm.Element2D(1, below[::-1]))
        if i == grid.layers - 1:
            raw.Add(ngm.Element2D(2, above))
        for at, is_plane in ((0, k == 0), (grid.azimuth, k == grid.azimuth - 1)):
            if is_plane:
                ring = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                raw.Add(ngm.Element2D(3, [vertex(*corner, at) for corner in ring]))
        if j == last - 1:
            ring = ((i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1))
            raw.Add(ngm.Element2D(4, [vertex(one, last, at) for one, at in ring]))
    for i in range(grid.layers):
        raw.Add(ngm.Element1D([vertex(i, last, half), vertex(i + 1, last, half)], index=1))
    raw.SetCD2Name(1, "axis")
    for i, k in np.ndindex(grid.layers + 1, half + 1):
        pair = vertex(i, last, k), vertex(i, last, grid.azimuth - k)
        raw.AddPointIdentification(*pair, 1, ngm.IdentificationType.PERIODIC)
    mesh = ng.Mesh(raw)
    linear = ng.H1(mesh, order=1)
    chart = [ng.GridFunction(linear) for _ in range(4)]
    for function, values in zip(chart, np.array(charts).T, strict=True):
        function.vec.FV().NumPy()[:] = values
    length = ng.sqrt(chart[0] ** 2 + chart[1] ** 2 + chart[2] ** 2)
    far, near = 0.5 * ng.exp(chart[3]), 0.5 * squared * ng.exp(-chart[3])
    target = (
        (far + near) * chart[0] / length,
        (far - near) * chart[1] / length,
        (far - near) * chart[2] / length,
    )
    space = ng.VectorH1(mesh, order=grid.order)
    shift, surface = ng.GridFunction(space), ng.GridFunction(space)
    parts = zip(shift.components, surface.components, target, (ng.x, ng.y, ng.z), strict=True)
    on_fiber = np.array(list(space.components[0].GetDofs(mesh.Boundaries("fiber"))), dtype=bool)
    for inside, outside, goal, straight in parts:
        inside.Set(goal - straight)
        # the fiber's shape from its own surface
        outside.Set(goal - straight, definedon=mesh.Boundaries("fiber"))
        inside.vec.FV().NumPy()[on_fiber] = outside.vec.FV().NumPy()[on_fiber]
    # planes stay planes
    for part, name in ((0, "cut"), (2, "plane")):
        flat = np.array(list(space.components[part].GetDofs(mesh.Boundaries(name))), dtype=bool)
        shift.components[part].vec.FV().NumPy()[flat] = 0.0
    mesh.SetDeformation(shift)
    return mesh, shift
