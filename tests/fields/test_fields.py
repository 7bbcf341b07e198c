"""Gradients recovered from other solvers' files: observed orders, estimates that bracket."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import pyvista
from dialects import DIALECTS, Sample, sample, vtu
from exact_flows import MILL, ExactFlow, Mesh, box, embedded, rectangle

from fibermelt.fields.mapping import FieldMap
from fibermelt.fields.reading import read_field

pytestmark = pytest.mark.verification


def _swirl_velocity(x: np.ndarray) -> np.ndarray:
    X, Y, Z = 2 * x.T
    return np.column_stack(
        [
            np.sin(X) * np.cos(Y) * np.cos(Z),
            np.cos(X) * np.sin(Y) * np.cos(Z),
            -2 * np.cos(X) * np.cos(Y) * np.sin(Z),
        ]
    )


def _swirl_gradient(x: np.ndarray) -> np.ndarray:
    s, c = np.sin(2 * x), np.cos(2 * x)
    L = np.empty((len(x), 3, 3))
    for i, factor in enumerate((1.0, 1.0, -2.0)):
        for j in range(3):
            product = np.full(len(x), 2.0 * factor)
            for k in range(3):
                own = s if k == i else c
                slope = c if k == i else -s
                product *= slope[:, k] if k == j else own[:, k]
            L[:, i, j] = product
    return L


SWIRL = ExactFlow(
    "swirl", "spatial", box, _swirl_velocity, _swirl_gradient, lambda x: np.sin(x[:, 0])
)


def _jet_velocity(x: np.ndarray) -> np.ndarray:
    """Return ``u = (r cos x, -r^2 sin x ...)``: ``psi = r^3 sin(x) / 3`` turned about x."""
    r = x[:, 1]
    return np.column_stack([r * np.sin(x[:, 0]), -(r**2) * np.cos(x[:, 0]) / 3, 0 * r])


def _jet_gradient(x: np.ndarray) -> np.ndarray:
    r = x[:, 1]
    s, c = np.sin(x[:, 0]), np.cos(x[:, 0])
    L = np.zeros((len(x), 3, 3))
    L[:, 0, 0], L[:, 0, 1] = r * c, s
    L[:, 1, 0], L[:, 1, 1] = r**2 * s / 3, -2 * r * c / 3
    L[:, 2, 2] = -r * c / 3
    return L


def _ring(n: int) -> Mesh:
    mesh = rectangle(n)
    return Mesh(mesh.points + np.array([0.0, 0.5]), mesh.cells)


RING = ExactFlow(
    "ring", "axisymmetric", _ring, _jet_velocity, _jet_gradient, lambda x: np.sin(x[:, 0])
)
"""Without divergence around an axis that it does not touch."""

RESOLUTIONS = {"mill": (16, 32), "swirl": (7, 14), "ring": (12, 24)}


@pytest.mark.parametrize("flow", [MILL, SWIRL, RING], ids=lambda flow: flow.name)
def test_gradient_is_of_third_order_inside_and_at_walls(tmp_path: Path, flow: ExactFlow) -> None:
    inside, wall = [], []
    axis = "x" if flow.geometry == "axisymmetric" else ""
    for n in RESOLUTIONS[flow.name]:
        field = read_field(vtu(tmp_path, sample(flow, n)), FieldMap(axis=axis))
        error = np.linalg.norm(field.gradient - flow.gradient(field.points), axis=(1, 2))
        inside.append(np.sqrt(np.mean(error[~field.near_wall] ** 2)))
        wall.append(np.sqrt(np.mean(error[field.near_wall] ** 2)))
        # above the error nearly everywhere, what lies between nodes included, and not by orders of
        # magnitude of the gradient
        assert np.mean(field.gradient_error >= error) > 0.99
        size = np.median(np.linalg.norm(flow.gradient(field.points), axis=(1, 2)))
        assert np.median(field.gradient_error) < 0.2 * size
        assert np.abs(field.divergence).max() < 3 * error.max()
    # the cubic's order; meshes are moved at random, which costs or gives a quarter
    assert np.log2(inside[0] / inside[1]) == pytest.approx(3.0, abs=0.4)
    assert np.log2(wall[0] / wall[1]) == pytest.approx(3.0, abs=0.5)


def of_cells(folder: Path, flow: ExactFlow, n: int) -> Path:
    """Write a flow as a solver of finite volumes has it: its mean in each cell."""
    mesh = flow.mesh(n)
    d = mesh.points.shape[1]
    centre = mesh.points[mesh.cells].mean(axis=1, keepdims=True)
    # exact for quadratics: the corners, drawn to the middle
    inner = embedded((centre + (mesh.points[mesh.cells] - centre) / np.sqrt(d + 2)).reshape(-1, d))
    grid = pyvista.UnstructuredGrid({{2: 5, 3: 10}[d]: mesh.cells}, embedded(mesh.points))
    grid.cell_data["U"] = flow.velocity(inner).reshape(-1, d + 1, 3).mean(axis=1)
    path = folder / f"cells{n}.vtu"
    grid.save(path)
    return path


@pytest.mark.parametrize("flow", [MILL, SWIRL], ids=lambda flow: flow.name)
def test_gradient_of_values_in_cells_is_of_second_order_at_walls(
    tmp_path: Path, flow: ExactFlow
) -> None:
    """Planes through the cells at a node left the first order there, and half the estimate."""
    wall = []
    for n in RESOLUTIONS[flow.name]:
        field = read_field(of_cells(tmp_path, flow, n))
        error = np.linalg.norm(field.gradient - flow.gradient(field.points), axis=(1, 2))
        wall.append(np.sqrt(np.mean(error[field.near_wall] ** 2)))
        assert np.mean(field.gradient_error[field.near_wall] >= error[field.near_wall]) > 0.95
        assert np.mean(field.gradient_error[~field.near_wall] >= error[~field.near_wall]) > 0.99
    # as above; corners, of which a coarse mesh has many, fall faster
    assert np.log2(wall[0] / wall[1]) == pytest.approx(2.0, abs=0.4)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_at_two_resolutions(tmp_path: Path, dialect: str) -> None:
    """The order of the gradient and of the pressure between nodes, which is linear: second."""
    at = np.random.default_rng(1).uniform([0.3, 0.2], [1.7, 0.8], (400, 2))
    slope, pressure, speed = [], [], []
    for n in (12, 24):
        data = sample(MILL, n)
        x = embedded(data.mesh.points)
        data = Sample(data.mesh, data.velocity, np.sin(3 * x[:, 0]) * x[:, 1])
        field = read_field(DIALECTS[dialect](tmp_path, data))
        place = field.locate(at)
        L = field.evaluate(field.gradient, place)
        assert field.pressure is not None
        p = field.evaluate(field.pressure, place)
        u = field.velocity_at(place)
        here = embedded(at)
        slope.append(np.linalg.norm(L - MILL.gradient(here), axis=(1, 2)).mean())
        pressure.append(np.abs(p - np.sin(3 * at[:, 0]) * at[:, 1]).mean())
        speed.append(np.linalg.norm(u - MILL.velocity(here), axis=1).mean())
    assert np.log2(slope[0] / slope[1]) == pytest.approx(2.0, abs=0.3)
    assert np.log2(pressure[0] / pressure[1]) == pytest.approx(2.0, abs=0.2)
    # quadratic between nodes
    assert np.log2(speed[0] / speed[1]) == pytest.approx(3.0, abs=0.4)
