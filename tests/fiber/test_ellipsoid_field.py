"""The flow around a free ellipsoid satisfies what defines it, each to rounding.

As in two dimensions derivatives come from exact mean values over spheres: ``mean(u) - u = (rho^2/6)
lap u``, ``mean(p n) = (rho/3) grad p``.
"""

import numpy as np
import pytest

from fibermelt.fiber import (
    Ellipsoid,
    EllipsoidField,
    body_axes,
    ellipsoid_field,
    unbounded_ellipsoid,
)
from fibermelt.verify.averages import sphere_rule

pytestmark = pytest.mark.verification

SIZE = 42e-6
SHAPES = {
    "sphere": (1.0, 1.0, 1.0),
    "nearly a sphere": (1.0 + 1e-9, 1.0, 1.0),
    "prolate": (1.0, 1.0 / 6.0, 1.0 / 6.0),
    "oblate": (0.1, 1.0, 1.0),
    "triaxial": (1.0, 0.5, 0.25),
    "slender and flat": (1.0, 0.08, 0.03),
}
EXACT = 1e-12
GRADIENT = np.array([[0.3, 1.1, -0.4], [-0.2, 0.5, 0.7], [0.6, -0.9, -0.8]])
ROTATION, _ = np.linalg.qr(np.array([[1.0, 2.0, 0.3], [-0.5, 1.0, 0.8], [0.2, -0.4, 1.0]]))
AXES = ROTATION * np.linalg.det(ROTATION)

shapes = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())


NORMALS, WEIGHTS = sphere_rule(20)


def body(shape: tuple[float, float, float]) -> Ellipsoid:
    return Ellipsoid((SIZE * shape[0], SIZE * shape[1], SIZE * shape[2]))


def eccentric(count: int) -> np.ndarray:
    vectors = np.random.default_rng(5).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def field(shape: tuple[float, float, float], points: np.ndarray) -> EllipsoidField:
    return ellipsoid_field(body(shape), GRADIENT, points, AXES)


@shapes
def test_no_slip_and_surface_pressure(shape: tuple[float, float, float]) -> None:
    where = eccentric(60)
    points = SIZE * (where * np.array(shape)) @ AXES.T
    flow = field(shape, points)
    rigid = np.cross(flow.angular_velocity, points)
    assert flow.velocity == pytest.approx(rigid, rel=0.0, abs=EXACT * SIZE)
    response = unbounded_ellipsoid(body(shape))
    pressure = response.surface_pressure(AXES.T @ GRADIENT @ AXES, where)
    scale = np.max(np.abs(pressure))
    assert flow.pressure == pytest.approx(pressure, rel=0.0, abs=EXACT * scale)


@shapes
def test_balances_of_mass_and_momentum(shape: tuple[float, float, float]) -> None:
    away = np.array([0.6, 1.0, 3.0, 20.0])[:, None]
    points = SIZE * (1.0 + away) * eccentric(4)
    centre = field(shape, points)
    for part in (0.3, 0.15):
        rho = part * SIZE * away
        around = field(shape, points[:, None, :] + rho[..., None] * NORMALS)
        disturbance = around.velocity - (points[:, None, :] + rho[..., None] * NORMALS) @ GRADIENT.T
        size = np.max(np.abs(disturbance), axis=(1, 2))
        flux = np.sum(disturbance * NORMALS, axis=-1) @ WEIGHTS
        # the disturbance is told from the whole velocity: rounding of that
        noise = EXACT * (size + 1e-3 * np.linalg.norm(points, axis=-1))
        assert np.all(np.abs(flux) <= noise)
        mean = np.einsum("kni,n->ki", disturbance, WEIGHTS)
        laplacian = 6.0 * (mean - (centre.velocity - points @ GRADIENT.T)) / rho**2
        slope = 3.0 * np.einsum("kn,ni,n->ki", around.pressure, NORMALS, WEIGHTS) / rho
        steepest = np.max(np.abs(around.pressure), axis=1) / rho[:, 0]
        allowed = noise / rho[:, 0] ** 2 + EXACT * steepest
        assert np.all(np.abs(laplacian - slope) <= 6.0 * allowed[:, None])
        assert np.all(np.max(np.abs(slope), axis=1)[:3] > 1e5 * allowed[:3])  # teeth
        assert around.pressure @ WEIGHTS == pytest.approx(
            centre.pressure, rel=0.0, abs=EXACT * np.max(np.abs(around.pressure))
        )


@shapes
def test_no_force_and_no_torque(shape: tuple[float, float, float]) -> None:
    """Over a sphere around the body ``mean(u)`` is the Stokeslet's, ``mean(n x u)`` the rotlet's.

    ``F/(6 pi mu r)`` and ``T/(12 pi mu r^2)``: all other decaying solutions average to nothing.
    """
    points = 3.0 * SIZE * NORMALS
    disturbance = field(shape, points).velocity - points @ GRADIENT.T
    scale = EXACT * SIZE
    assert WEIGHTS @ disturbance == pytest.approx(0.0, abs=scale)
    assert WEIGHTS @ np.cross(NORMALS, disturbance) == pytest.approx(0.0, abs=scale)


@shapes
def test_shear_traction_is_the_constant_tensor_s(shape: tuple[float, float, float]) -> None:
    """``du/dn`` at the surface, in the body's frame, is the tangential part of ``Sigma n``."""
    where = eccentric(20)
    own = AXES.T @ GRADIENT @ AXES
    normal = where / np.array(shape)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    traction = normal @ unbounded_ellipsoid(body(shape)).surface_stress(own)
    tangential = traction - np.sum(traction * normal, axis=-1, keepdims=True) * normal
    step = 1e-4 * SIZE * min(shape) ** 2
    slopes = []
    for reach in (step, 2.0 * step):
        points = (SIZE * where * np.array(shape) + reach * normal) @ AXES.T
        flow = field(shape, points)
        slip = (flow.velocity - np.cross(flow.angular_velocity, points)) @ AXES
        slopes.append(slip / reach)
    slope = 2.0 * slopes[0] - slopes[1]
    # one-sided differences: curvature leaves (step/radius)^2 = 1e-8, rounding 1e-16/1e-4/shape^2
    tolerance = (1e-6 + 1e-11 / min(shape) ** 2) * np.max(np.abs(traction))
    assert slope == pytest.approx(tangential, rel=0.0, abs=tolerance)


@shapes
def test_far_field_and_its_rate(shape: tuple[float, float, float]) -> None:
    """The stresslet's ``1/r^2`` and ``1/r^3``; its strength is the volume times ``T``."""
    sizes = []
    for distance in (200.0, 400.0):
        points = SIZE * distance * NORMALS
        flow = field(shape, points)
        disturbance = flow.velocity - points @ GRADIENT.T
        sizes.append((np.max(np.abs(disturbance)), np.max(np.abs(flow.pressure))))
        own = unbounded_ellipsoid(body(shape)).surface_stress(AXES.T @ GRADIENT @ AXES)
        stress = AXES @ own @ AXES.T
        stress -= np.trace(stress) / 3.0 * np.eye(3)
        # p = -3 n.S n/(4 pi r^3), S = V T: Batchelor's stresslet
        strength = -np.prod(shape) * np.einsum("ni,ij,nj->n", NORMALS, stress, NORMALS)
        far = strength / distance**3
        assert flow.pressure == pytest.approx(far, rel=0.0, abs=2e-4 * np.max(np.abs(far)))
    ratios = np.array(sizes[0]) / np.array(sizes[1])
    # the next term is (a/r)^2 smaller; far away the disturbance is 1e-8 of the velocity
    assert ratios == pytest.approx([4.0, 8.0], rel=2e-4)


def test_axes_from_a_director() -> None:
    for direction in eccentric(10):
        axes = body_axes(direction)
        assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-14)
        assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-14)
        assert axes[:, 0].tolist() == direction.tolist()
