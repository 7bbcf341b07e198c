"""A rigid spheroid in a thinning melt, its axis in the plane of a planar flow, in 3D (NGSolve).

The cell of `fibermelt.fiber.cell.thinning` in three dimensions: far field ``D x`` with ``D = d
[[cos phi, sin phi], [sin phi, -cos phi]]`` in the plane of the fiber's axis, nothing across,
half-length ``a = 1``. The fiber turns about z alone; no torque acts on it.

Coordinates are confocal: ``(x, y, z) = (A e_x, B e_y, B e_z)``, ``e`` on the unit sphere, ``A + B =
exp(s)``, ``A - B = c^2 exp(-s)``, ``c^2 = 1 - 1/r_e^2``, the sphere included. The plane's mirror
and half a turn about z leave the flow unchanged, so the quarter ``x >= 0``, ``z >= 0`` is solved.
On its cut ``x = 0`` the velocities ``u_x, u_y`` at ``(0, -y, z)`` are the opposite of those at
``(0, y, z)``, ``u_z`` and ``p`` the same: a periodic boundary with a sign. Velocity of order k,
continuous pressure of order k - 1 on hexahedra, prisms at the pole.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import Any

import netgen.meshing as ngm
import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.cell.torque_free import TorqueFreeCell
from fibermelt.fiber.checks import checked_number, checked_positive
from fibermelt.fiber.spheroid import Spheroid
from fibermelt.fiber.spheroid_data import SpheroidNumerics, ThinningSpheroid
from fibermelt.melt import ViscosityLaw
from fibermelt.threads import exclusive

__all__ = ["SpheroidCell", "solve_thinning_spheroid"]

Array = NDArray[np.float64]

MOST_SLENDER = 50.0
"""Largest aspect ratio: the number of elements from tip to side would have to grow beyond."""

LARGEST_ANGLE = 0.4
"""Largest element from the tip to the equator [rad]: on the sides a line without deformation, where
the melt is stiff, crosses them; the highest pressure was 10 % off with elements twice as large."""

EXTRA_QUADRATURE = 1
"""Additional integration order: 0, 1 and 2 differ by less than the elements' error (5e-4 of the
lowest pressure at order 3), and order 3 and 1 have four points a direction."""

READINGS = 12
"""Intervals along a side of an element between points at which its surface is read: an extreme
between two of them is off by ``(1/24)^2/2`` of the pressure's bend over the element, some 1e-4."""


@exclusive
def solve_thinning_spheroid(
    fiber: Spheroid,
    law: ViscosityLaw,
    rate: float,
    phase: float,
    numerics: SpheroidNumerics | None = None,
) -> ThinningSpheroid:
    """Return what a free spheroid in an unbounded melt answers to one planar strain.

    Parameters
    ----------
    fiber : Spheroid
        The fiber, prolate or a sphere, its axis in the flow's plane; its size does not matter.
    law : ViscosityLaw
        The melt.
    rate : float
        ``gamma_dot = 2 d`` of the far field [1/s], positive.
    phase : float
        ``phi`` [rad]: ``D_11 = d cos phi``, ``D_12 = d sin phi`` in the fiber's axes. In simple
        shear that of a fiber at the angle ``theta`` to the stream is ``pi/2 - 2 theta``.
    numerics : SpheroidNumerics, optional
        The elements; 8600 coupled unknowns by default, 1.5 s a Newton step.

    Raises
    ------
    ConfigError
        If a number is out of its range, or the fiber a disc or more slender than 50.
    ConvergenceError
        If Newton's method does not converge.
    """
    cell = SpheroidCell(fiber, law, SpheroidNumerics() if numerics is None else numerics)
    return cell.solved(checked_positive("rate", rate, "1/s", "100"), checked_number("phase", phase))


class SpheroidCell(TorqueFreeCell):
    """A spheroid in a quarter of space.

    Parameters
    ----------
    fiber, law, numerics
        As in `solve_thinning_spheroid`.
    """

    def __init__(self, fiber: Spheroid, law: ViscosityLaw, numerics: SpheroidNumerics) -> None:
        refuse_other("fiber", fiber, Spheroid)
        refuse_other("numerics", numerics, SpheroidNumerics)
        if not 1.0 <= fiber.aspect_ratio <= MOST_SLENDER:
            msg = (
                f"fiber.aspect_ratio = {fiber.aspect_ratio:g}: the elements around a spheroid in a "
                f"thinning melt are laid out for 1 (a sphere) to {MOST_SLENDER:g}"
            )
            raise ConfigError(msg)
        self.fiber = fiber
        mesh, self._shift = _mesh(fiber.aspect_ratio, numerics)
        order = numerics.order
        given = "fiber|edge"
        along = ng.H1(mesh, order=order, dirichlet=given, dirichlet_bbnd="axis")
        across = ng.H1(mesh, order=order, dirichlet=given + "|plane")
        odd, even = [-1.0], [1.0]
        u, w = ng.Periodic(along, phase=odd), ng.Periodic(across, phase=even)
        p = ng.Periodic(ng.H1(mesh, order=order - 1), phase=even)
        super().__init__(u * u * w * p, law, EXTRA_QUADRATURE)
        side = np.linspace(0.0, 1.0, READINGS + 1)
        square = [(x, y) for x in side for y in side]
        half = [(x, y) for x, y in square if x + y <= 1.0 + 0.5 / READINGS]
        rules = {
            shape: ng.IntegrationRule(points, [0.0] * len(points))
            for shape, points in ((ng.ET.QUAD, square), (ng.ET.TRIG, half))
        }
        self._surface = mesh.MapToAllElements(rules, mesh.Boundaries("fiber"))
        r = fiber.aspect_ratio
        points = np.asarray(ng.CF((ng.x, r * ng.y, r * ng.z))(self._surface)).reshape(-1, 3)
        self.places = points / np.linalg.norm(points, axis=1, keepdims=True)

    def start_from(self, other: SpheroidCell) -> None:
        """Start from the flow of another cell of the same fiber and elements."""
        self.flow.vec.data = other.flow.vec
        self.spin, self.started = other.spin, other.started

    def solved(self, rate: float, phase: float) -> ThinningSpheroid:
        """Return the answer at a rate [1/s] and a phase [rad]."""
        found = self.answer(rate, phase)
        return ThinningSpheroid(
            aspect_ratio=self.fiber.aspect_ratio,
            rate=rate,
            phase=phase,
            spin=found.spin,
            places=self.places,
            pressure=found.pressure,
            unknowns=self.unknowns,
            steps=found.steps,
        )

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


def _graded(first: float, total: float, count: int, largest: float = np.inf) -> Array:
    """Return the ends of ``count`` intervals that fill ``total``.

    The first is ``first``, the others grow in geometric progression up to ``largest``, or to what
    it takes to leave room for small ones: one and a half times the mean. Equal parts if ``first``
    is not small.
    """
    if first * count >= total:
        return np.linspace(0.0, total, count + 1)
    most, power = max(largest, 1.5 * total / count), np.arange(count)

    def ends(growth: float) -> Array:
        return np.cumsum(np.minimum(first * growth**power, most))

    growth = brentq(lambda g: float(ends(g)[-1]) - total, 1.0, 1e3)
    return np.concatenate([[0.0], ends(growth)[:-1], [total]])


class _Vertices:
    """Vertices of the quarter by their place ``(i, j, k)``: outward, from the tip, around.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-].
    numerics : SpheroidNumerics
        The division.
    """

    def __init__(self, aspect_ratio: float, numerics: SpheroidNumerics) -> None:
        self.squared = 1.0 - aspect_ratio**-2
        start = np.log1p(1.0 / aspect_ratio)
        outward = np.log(numerics.outer + np.sqrt(numerics.outer**2 - self.squared)) - start
        first = numerics.first_layer / aspect_ratio, numerics.first_angle / aspect_ratio
        self.shells = start + _graded(first[0], outward, numerics.layers)
        self.angles = _graded(first[1], 0.5 * np.pi, numerics.meridian, LARGEST_ANGLE)
        self.around = np.linspace(0.0, np.pi, numerics.azimuth + 1)
        self.raw = ngm.Mesh(dim=3)
        self.number: dict[tuple[int, int, int], Any] = {}
        self.charts: list[tuple[float, ...]] = []

    def __call__(self, i: int, j: int, k: int) -> Any:
        """Return the vertex, one at the pole for every azimuth."""
        key = (i, j, k if j > 0 else 0)
        if key not in self.number:
            nu, psi, shell = self.angles[j], self.around[k], self.shells[i]
            e = (np.cos(nu), np.sin(nu) * np.cos(psi), np.sin(nu) * np.sin(psi))
            far, near = 0.5 * np.exp(shell), 0.5 * self.squared * np.exp(-shell)
            point = ((far + near) * e[0], (far - near) * e[1], (far - near) * e[2])
            self.number[key] = self.raw.Add(ngm.MeshPoint(ngm.Pnt(*point)))
            self.charts.append((*e, shell))
        return self.number[key]


def _mesh(aspect_ratio: float, numerics: SpheroidNumerics) -> tuple[Any, Any]:
    """Return the curved quarter of space and the deformation that has to outlive it."""
    vertex = _Vertices(aspect_ratio, numerics)
    raw = vertex.raw
    layers, last, azimuth = numerics.layers, numerics.meridian, numerics.azimuth
    half = azimuth // 2
    for index, name in enumerate(("fiber", "edge", "plane", "cut"), 1):
        raw.Add(ngm.FaceDescriptor(surfnr=index, domin=1, domout=0, bc=index))
        raw.SetBCName(index - 1, name)
    raw.SetMaterial(1, "melt")
    # numbered alike on both halves of the cut, from the axis on: faces that are identified must
    # have their vertices in the same order
    for k in (half, *range(half), *range(azimuth, half, -1)):
        for i in range(layers + 1):
            vertex(i, last, k)

    def face(index: int, corners: Iterable[tuple[int, int, int]]) -> None:
        raw.Add(ngm.Element2D(index, list(dict.fromkeys(vertex(*at) for at in corners))))

    for i, j, k in np.ndindex(layers, last, azimuth):
        square = ((j, k), (j + 1, k), (j + 1, k + 1), (j, k + 1))
        shells = [list(dict.fromkeys(vertex(at, *one) for one in square)) for at in (i, i + 1)]
        raw.Add(ngm.Element3D(1, shells[0] + shells[1]))
    for j, k in np.ndindex(last, azimuth):
        square = ((j, k), (j + 1, k), (j + 1, k + 1), (j, k + 1))
        face(1, ((0, *one) for one in square[::-1]))
        face(2, ((layers, *one) for one in square))
    for i, j, k in product(range(layers), range(last), (0, azimuth)):
        face(3, ((i, j, k), (i + 1, j, k), (i + 1, j + 1, k), (i, j + 1, k)))
    for i, k in np.ndindex(layers, azimuth):
        ring = ((i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1))
        face(4, ((one, last, at) for one, at in ring))
    _identify(vertex, numerics)
    mesh = ng.Mesh(raw)
    shift = _curved(mesh, vertex, numerics.order)
    mesh.SetDeformation(shift)
    return mesh, shift


def _identify(vertex: _Vertices, numerics: SpheroidNumerics) -> None:
    """Name the cut's fixed line, and which of its vertices are the same by half a turn."""
    last, half = numerics.meridian, numerics.azimuth // 2
    for i in range(numerics.layers):
        line = [vertex(i, last, half), vertex(i + 1, last, half)]
        vertex.raw.Add(ngm.Element1D(line, index=1))
    vertex.raw.SetCD2Name(1, "axis")
    for i, k in np.ndindex(numerics.layers + 1, half + 1):
        pair = vertex(i, last, k), vertex(i, last, numerics.azimuth - k)
        vertex.raw.AddPointIdentification(*pair, 1, ngm.IdentificationType.PERIODIC)


def _curved(mesh: Any, vertices: _Vertices, order: int) -> Any:
    """Return the deformation that curves the elements.

    Unit vectors ``e`` are linear between vertices and divided by their length, which is smooth
    across the pole, where the azimuth is not.
    """
    linear = ng.H1(mesh, order=1)
    chart = [ng.GridFunction(linear) for _ in range(4)]
    for function, values in zip(chart, np.array(vertices.charts).T, strict=True):
        function.vec.FV().NumPy()[:] = values
    length = ng.sqrt(chart[0] ** 2 + chart[1] ** 2 + chart[2] ** 2)
    far, near = 0.5 * ng.exp(chart[3]), 0.5 * vertices.squared * ng.exp(-chart[3])
    sizes = (far + near, far - near, far - near)
    space = ng.VectorH1(mesh, order=order)
    shift, surface = ng.GridFunction(space), ng.GridFunction(space)
    fiber = mesh.Boundaries("fiber")
    # planes stay planes, and the fiber takes its shape from its own surface
    flat = (("cut",), (), ("plane",))
    for axis, straight in enumerate((ng.x, ng.y, ng.z)):
        goal = sizes[axis] * chart[axis] / length - straight
        shift.components[axis].Set(goal)
        surface.components[axis].Set(goal, definedon=fiber)
        values = shift.components[axis].vec.FV().NumPy()
        own = _dofs(space.components[axis], "fiber")
        values[own] = surface.components[axis].vec.FV().NumPy()[own]
        for name in flat[axis]:
            values[_dofs(space.components[axis], name)] = 0.0
    return shift


def _dofs(space: Any, boundary: str) -> NDArray[np.bool_]:
    """Return which coefficients of a space belong to a boundary."""
    return np.array(list(space.GetDofs(space.mesh.Boundaries(boundary))), dtype=np.bool_)
