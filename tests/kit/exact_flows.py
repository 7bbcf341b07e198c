"""Flows that are known exactly, on meshes of our own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from fibermelt.fields.field import Field

Array = NDArray[np.float64]
Index = NDArray[np.int64]

JITTER = 0.15
"""Parts of an edge by which inner nodes are moved, so that no mesh is symmetric by luck."""


@dataclass(frozen=True)
class Mesh:
    """Nodes (n, 2 or 3) and simplices."""

    points: Array
    cells: Index


@dataclass(frozen=True)
class ExactFlow:
    """A Stokes flow in closed form, in SI; points are (n, 3)."""

    name: str
    geometry: str
    mesh: Callable[[int], Mesh]
    velocity: Callable[[Array], Array]
    gradient: Callable[[Array], Array]
    pressure: Callable[[Array], Array]


def _jitter(points: Array, h: float, is_inner: NDArray[np.bool_]) -> Array:
    moved = points.copy()
    moved[is_inner] += JITTER * h * np.random.default_rng(7).uniform(-1, 1, points.shape)[is_inner]
    return moved


@cache
def rectangle(n: int, length: float = 2.0, height: float = 1.0) -> Mesh:
    """Return [0, length] x [0, height] in triangles with edges of height / n."""
    nx = round(n * length / height)
    x, y = np.meshgrid(np.linspace(0, length, nx + 1), np.linspace(0, height, n + 1))
    points = np.column_stack([x.ravel(), y.ravel()])
    is_inner = np.all((points > 0) & (points < [length, height]), axis=1)
    a = (np.arange(n)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    b, c, d = a + 1, a + nx + 2, a + nx + 1
    cells = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return Mesh(_jitter(points, height / n, is_inner), cells)


def _kuhn(shape: tuple[int, int, int]) -> Index:
    """Return six tetrahedra for each brick of a grid of so many nodes."""
    number = np.arange(np.prod(shape)).reshape(shape)
    corner = number[:-1, :-1, :-1].ravel()
    steps = (shape[1] * shape[2], shape[2], 1)
    cells = []
    for axes in permutations(range(3)):
        first = corner + steps[axes[0]]
        second = first + steps[axes[1]]
        cells.append(np.column_stack([corner, first, second, second + steps[axes[2]]]))
    return np.concatenate(cells)


@cache
def box(n: int, size: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    """Return a box from the origin in n bricks along each side, six tetrahedra each."""
    axes = [np.linspace(0, s, n + 1) for s in size]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    is_inner = np.all((points > 0) & (points < size), axis=1)
    return Mesh(_jitter(points, min(size) / n, is_inner), _kuhn((n + 1, n + 1, n + 1)))


@cache
def pipe(n: int, length: float = 1.0) -> Mesh:
    """Return a pipe of radius 1 along x: a square grid 2 n wide drawn onto the disk."""
    s = np.linspace(-1, 1, 2 * n + 1)
    a, b = np.meshgrid(s, s, indexing="ij")
    # the square's map to the disk that keeps lines smooth (elliptical grid mapping)
    y, z = a * np.sqrt(1 - b**2 / 2), b * np.sqrt(1 - a**2 / 2)
    x = np.linspace(0, length, max(2, round(n * length)) + 1)
    count = len(x)
    disk = np.column_stack([y.ravel(), z.ravel()])
    points = np.column_stack([np.repeat(x, len(disk)), np.tile(disk, (count, 1))])
    return Mesh(points, _kuhn((count, 2 * n + 1, 2 * n + 1)))


def _constant(L: Array) -> Callable[[Array], Array]:
    return lambda x: np.tile(L, (len(x), 1, 1))


def _linear(name: str, geometry: str, mesh: Callable[[int], Mesh], L: Array) -> ExactFlow:
    plane = L.copy()
    if geometry == "axisymmetric":
        plane[2, 2] = 0.0
    return ExactFlow(
        name, geometry, mesh, lambda x: x @ plane.T, _constant(L), lambda x: np.zeros(len(x))
    )


def _slit_gradient(x: Array) -> Array:
    L = np.zeros((len(x), 3, 3))
    L[:, 0, 1] = 6.0 * (1.0 - 2.0 * x[:, 1])
    return L


def _pipe_gradient(x: Array) -> Array:
    L = np.zeros((len(x), 3, 3))
    L[:, 0, 1], L[:, 0, 2] = -4.0 * x[:, 1], -4.0 * x[:, 2]
    return L


def _mill_velocity(x: Array) -> Array:
    X, Y = 2.0 * x[:, 0], 2.0 * x[:, 1]
    return np.column_stack([np.sin(X) * np.cos(Y), -np.cos(X) * np.sin(Y), 0 * X])


def _mill_gradient(x: Array) -> Array:
    X, Y = 2.0 * x[:, 0], 2.0 * x[:, 1]
    L = np.zeros((len(x), 3, 3))
    L[:, 0, 0] = 2 * np.cos(X) * np.cos(Y)
    L[:, 0, 1] = -2 * np.sin(X) * np.sin(Y)
    L[:, 1, 0] = 2 * np.sin(X) * np.sin(Y)
    L[:, 1, 1] = -2 * np.cos(X) * np.cos(Y)
    return L


COUETTE = _linear("couette", "planar", rectangle, np.array([[0.0, 2.0, 0], [0, 0, 0], [0, 0, 0]]))
ROTATION = _linear("rotation", "spatial", box, np.array([[0.0, -3.0, 1], [3, 0, -2], [-1, 2, 0]]))
EXTENSION = _linear("extension", "axisymmetric", rectangle, np.diag([2.0, -1.0, -1.0]))
SLIT = ExactFlow(
    "slit",
    "planar",
    rectangle,
    lambda x: np.column_stack([6.0 * x[:, 1] * (1.0 - x[:, 1]), 0 * x[:, 0], 0 * x[:, 0]]),
    _slit_gradient,
    lambda x: 12.0 * (2.0 - x[:, 0]),
)
PIPE = ExactFlow(
    "pipe",
    "spatial",
    pipe,
    lambda x: np.column_stack([2.0 * (1 - x[:, 1] ** 2 - x[:, 2] ** 2), 0 * x[:, 0], 0 * x[:, 0]]),
    _pipe_gradient,
    lambda x: 8.0 * (1.0 - x[:, 0]),
)
TUBE = ExactFlow(
    "tube",
    "axisymmetric",
    rectangle,
    lambda x: np.column_stack([2.0 * (1 - x[:, 1] ** 2), 0 * x[:, 0], 0 * x[:, 0]]),
    lambda x: _pipe_gradient(np.column_stack([x[:, :2], 0 * x[:, 0]])),
    lambda x: 8.0 * (2.0 - x[:, 0]),
)
MILL = ExactFlow(
    "mill",
    "planar",
    rectangle,
    _mill_velocity,
    _mill_gradient,
    lambda x: np.zeros(len(x)),
)
"""Four rolls: ``psi = sin 2x sin 2y / 2``, cells between stagnation points."""

FLOWS = (COUETTE, ROTATION, EXTENSION, SLIT, PIPE, TUBE, MILL)


def embedded(points: Array) -> Array:
    """Return points (n, 2 or 3) with three coordinates."""
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])


def exact_field(flow: ExactFlow, n: int) -> Field:
    """Return a field with the exact values at its nodes."""
    mesh = flow.mesh(n)
    x = embedded(mesh.points)
    zero = np.zeros(len(x))
    return Field(
        geometry=flow.geometry,
        points=x,
        cells=mesh.cells,
        velocity=flow.velocity(x),
        gradient=flow.gradient(x),
        gradient_error=zero,
        divergence=zero,
        pressure=flow.pressure(x),
        viscosity=None,
        temperature=None,
        near_wall=np.zeros(len(x), dtype=bool),
    )
