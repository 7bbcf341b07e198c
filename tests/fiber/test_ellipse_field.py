"""The flow around an unbounded ellipse satisfies what defines it, each to rounding.

Biharmonic velocities and harmonic pressures have exact mean values over circles (Pizzetti), so that
derivatives need no small steps: ``mean(u) - u = (rho^2/4) lap u``, ``mean(p n) = (rho/2) grad p``.
"""

import numpy as np
import pytest

from fibermelt.fiber import (
    Ellipse,
    EllipseField,
    ellipse_field,
    ellipse_pressure,
    ellipse_spin,
    ellipse_torque,
)
from fibermelt.verify.averages import circle_rule

pytestmark = pytest.mark.verification

RATIOS = [1.0, 1.5, 6.0, 30.0]
EXACT = 1e-12  # asked for: rounding, amplified by the aspect ratio
ANGLE = 0.7
GRADIENT = np.array([[0.3, 1.4], [-0.5, -0.3]])
STRAIN = 0.5 * (GRADIENT + GRADIENT.T)
NORMAL, _ = circle_rule(128)  # harmonics fall below rounding before 128
SPINS = [None, 0.0, 2.5]


def surface(fiber: Ellipse, s: np.ndarray) -> np.ndarray:
    z = (fiber.half_length * np.cos(s) + 1j * fiber.semi_minor * np.sin(s)) * np.exp(1j * ANGLE)
    return np.stack([z.real, z.imag], axis=-1)


def outside(fiber: Ellipse, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Random points, and for each a radius that keeps clear of the fiber."""
    rng = np.random.default_rng(7)
    s, away = rng.uniform(0.0, 2.0 * np.pi, count), 10.0 ** rng.uniform(-0.5, 1.5, count)
    tip = np.stack([np.cos(s), np.sin(s) / fiber.aspect_ratio], axis=-1)
    points = fiber.half_length * (tip + away[:, None] * np.stack([np.cos(s), np.sin(s)], axis=-1))
    turn = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
    return points @ turn.T, 0.25 * away * fiber.half_length


def field(ratio: float, points: np.ndarray, spin: float | None = None) -> EllipseField:
    return ellipse_field(Ellipse(42e-6, ratio), GRADIENT, ANGLE, points, spin)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("spin", SPINS)
def test_no_slip(ratio: float, spin: float | None) -> None:
    fiber = Ellipse(42e-6, ratio)
    points = surface(fiber, np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 60))
    flow = field(ratio, points, spin)
    rigid = flow.spin * np.stack([-points[:, 1], points[:, 0]], axis=-1)
    assert flow.velocity == pytest.approx(rigid, rel=0.0, abs=EXACT * fiber.half_length)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("spin", SPINS)
def test_balances_of_mass_and_momentum(ratio: float, spin: float | None) -> None:
    points, radii = outside(Ellipse(42e-6, ratio))
    centre = field(ratio, points, spin)
    for part in (1.0, 0.5):
        rho = part * radii[:, None]
        around = field(ratio, points[:, None, :] + rho[..., None] * NORMAL, spin)
        flux = np.mean(np.sum(around.velocity * NORMAL, axis=-1), axis=-1)
        assert flux == pytest.approx(0.0, abs=EXACT * np.max(np.abs(around.velocity)))
        laplacian = 4.0 * (np.mean(around.velocity, axis=1) - centre.velocity) / rho**2
        slope = 2.0 * np.mean(around.pressure[..., None] * NORMAL, axis=1) / rho
        # the velocity's own rounding over rho^2, and the pressure's over rho
        noise = EXACT * (
            np.max(np.abs(around.velocity), axis=(1, 2)) / rho[:, 0] ** 2
            + np.max(np.abs(around.pressure), axis=1) / rho[:, 0]
        )
        assert np.all(np.abs(laplacian - slope) <= noise[:, None])
        mean = np.mean(around.pressure, axis=1)
        assert mean == pytest.approx(centre.pressure, abs=EXACT * np.max(np.abs(around.pressure)))
    # the test has teeth: the pressure's slope is far above the noise near the fiber
    near = np.argmin(radii)
    assert np.max(np.abs(slope[near])) > 1e6 * noise[near]


@pytest.mark.parametrize("ratio", RATIOS)
def test_gradient_is_the_velocity_s(ratio: float) -> None:
    points, radii = outside(Ellipse(42e-6, ratio))
    estimates = []
    for part in (1.0, 0.5):
        rho = part * radii[:, None]
        around = field(ratio, points[:, None, :] + rho[..., None] * NORMAL, 0.4).velocity
        estimates.append(
            2.0 * np.mean(around[..., :, None] * NORMAL[:, None, :], axis=1) / rho[..., None]
        )
    # mean(u n) = (rho/2)(grad u + (rho^2/8) grad lap u): two radii leave nothing
    exact = (4.0 * estimates[1] - estimates[0]) / 3.0
    gradient = field(ratio, points, 0.4).gradient
    assert gradient == pytest.approx(exact, rel=0.0, abs=1e3 * EXACT)  # |u| over the radius


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("spin", SPINS)
def test_force_and_torque(ratio: float, spin: float | None) -> None:
    """The traction over any circle around the fiber gives the fiber's force and torque."""
    fiber = Ellipse(42e-6, ratio)
    radius = 2.0 * fiber.half_length
    flow = field(ratio, radius * NORMAL, spin)
    viscous = flow.gradient + np.swapaxes(flow.gradient, -1, -2)
    traction = np.einsum("nij,nj->ni", viscous, NORMAL) - flow.pressure[:, None] * NORMAL
    length = 2.0 * np.pi * radius
    assert np.mean(traction, axis=0) == pytest.approx(0.0, abs=EXACT)
    moment = NORMAL[:, 0] * traction[:, 1] - NORMAL[:, 1] * traction[:, 0]
    torque = float(np.mean(moment)) * radius * length
    scale = EXACT * radius * length
    assert torque == pytest.approx(flow.torque, abs=scale)
    if spin is None:
        assert flow.torque == pytest.approx(0.0, abs=scale)
        assert flow.spin == ellipse_spin(fiber, GRADIENT, ANGLE)
    else:
        assert flow.torque == ellipse_torque(fiber, GRADIENT, ANGLE, spin)


def test_torque_of_a_circle() -> None:
    """``-4 pi mu a^2 (w - W)``, Lamb's rotating cylinder."""
    torque = ellipse_torque(Ellipse(2.0, 1.0), GRADIENT, ANGLE, 3.0)
    assert torque == pytest.approx(-16.0 * np.pi * (3.0 - 0.5 * (-0.5 - 1.4)), rel=EXACT)


@pytest.mark.parametrize("spin", SPINS)
def test_far_field_and_its_rate(spin: float | None) -> None:
    """The disturbance falls like ``1/r``, the pressure like ``1/r^2``."""
    sizes = []
    for distance in (1e3, 2e3):
        points = 42e-6 * distance * NORMAL
        flow = field(6.0, points, spin)
        disturbance = np.max(np.abs(flow.velocity - points @ GRADIENT.T))
        sizes.append((disturbance, np.max(np.abs(flow.pressure))))
        assert disturbance < 42e-6 * 3.0 / distance * np.linalg.norm(GRADIENT)
    ratios = np.array(sizes[0]) / np.array(sizes[1])
    assert ratios == pytest.approx([2.0, 4.0], rel=1e-5)  # the next term is (a/r)^2 smaller


@pytest.mark.parametrize("ratio", RATIOS)
def test_surface_pressure_is_the_response_s(ratio: float) -> None:
    s = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, 60)
    turn = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
    local = turn.T @ STRAIN @ turn
    exact = ellipse_pressure(ratio, local[0, 0], local[0, 1], s)
    flow = field(ratio, surface(Ellipse(42e-6, ratio), s))
    assert flow.pressure == pytest.approx(exact, rel=0.0, abs=10.0 * EXACT * np.max(np.abs(exact)))
