"""What a fiber feels near a singular corner, against the exact field where a wall ends.

The field of Michael (1958), ``psi = r^(3/2) (sin 3/2 theta + sin 1/2 theta)``: the melt above, the
wall at theta = pi, the free surface at theta = 0, lengths in half-lengths of the fiber.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import Ellipse, pressure_bounds, unbounded_ellipse
from fibermelt.fiber.corner import felt_path, felt_rate
from fibermelt.history import FlowHistory

RATIO = 6.0
RESPONSE = unbounded_ellipse(Ellipse(1.0, RATIO))
MU = 817.0

QUADRATURE = 2e-4
"""Of the mean over an ellipse next to the corner: 1e-4 off what twice as many points give."""


def stretching(place: np.ndarray) -> np.ndarray:
    """Return ``D_11`` and ``D_12`` at places (..., 2), (..., 2)."""
    x, y = np.moveaxis(place, -1, 0)
    r, theta = np.hypot(x, y), np.arctan2(y, x)
    first = 1.5 * np.cos(1.5 * theta) + 0.5 * np.cos(0.5 * theta)
    second = -1.5 * np.sin(1.5 * theta) + 0.5 * np.sin(0.5 * theta)
    along, across = 0.5 * first / np.sqrt(r), 0.5 * second / np.sqrt(r)
    c, s = np.cos(2.0 * theta), np.sin(2.0 * theta)
    return np.stack([along * c - across * s, along * s + across * c], axis=-1)


def velocity(place: np.ndarray) -> np.ndarray:
    """Return the velocity at places (..., 2), whose strain is `stretching`."""
    r, theta = np.hypot(*place.T), np.arctan2(place[:, 1], place[:, 0])
    radial = np.sqrt(r) * (1.5 * np.cos(1.5 * theta) + 0.5 * np.cos(0.5 * theta))
    turning = -1.5 * np.sqrt(r) * (np.sin(1.5 * theta) + np.sin(0.5 * theta))
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([radial * c - turning * s, radial * s + turning * c], axis=-1)


def streamline(height: float, reach: float = 30.0, points: int = 601) -> FlowHistory:
    """Return a path past the corner, at ``height`` above it; its gradient has no spin."""
    theta = np.linspace(np.pi - 1e-3, 1e-3, 20 * points)
    r = height * (np.sqrt(2.0) / (np.sin(1.5 * theta) + np.sin(0.5 * theta))) ** (2.0 / 3.0)
    near = r < reach
    place = np.stack([r * np.cos(theta), r * np.sin(theta)], axis=-1)[near]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1))])
    even = np.linspace(0.0, way[-1], points)
    place = np.stack([np.interp(even, way, place[:, k]) for k in range(2)], axis=-1)
    D = stretching(place)
    gradient = np.stack([D, np.stack([D[:, 1], -D[:, 0]], axis=-1)], axis=-2)
    return FlowHistory(even, place, velocity(place), gradient, np.zeros(points))


def from_corner(path: FlowHistory) -> np.ndarray:
    return np.linalg.norm(path.position, axis=-1)


def mean_rate(place: np.ndarray, angle: float) -> float:
    """Return the rate of the mean gradient over an ellipse, by Gauss' points and even angles."""
    node, weight = np.polynomial.legendre.leggauss(24)
    radius, around = np.meshgrid(0.5 * (1.0 + node), 2.0 * np.pi * (np.arange(96) + 0.5) / 96)
    share = weight * radius / (weight * radius).sum()
    x, y = radius * np.cos(around), radius * np.sin(around) / RATIO
    c, s = np.cos(angle), np.sin(angle)
    inside = place + np.stack([c * x - s * y, s * x + c * y], axis=-1)
    return 2.0 * float(np.linalg.norm(np.einsum("ij,ijk->k", share, stretching(inside))))


def test_the_field_is_one_of_a_wall_that_ends() -> None:
    """Differences of the velocity are the gradient; the wall holds the melt, the surface slips."""
    step, place = 1e-5, np.array([[0.3, 0.8], [-1.2, 0.4], [0.9, 0.1]])
    right, left, above, below = (
        velocity(place + step * np.array(way)) for way in ((1, 0), (-1, 0), (0, 1), (0, -1))
    )
    du_dx, du_dy = (right - left) / (2 * step), (above - below) / (2 * step)
    found = np.stack([du_dx[:, 0], 0.5 * (du_dx[:, 1] + du_dy[:, 0])], axis=-1)
    assert stretching(place) == pytest.approx(found, rel=1e-8)
    assert du_dx[:, 0] == pytest.approx(-du_dy[:, 1], rel=1e-8)
    assert velocity(np.array([[-2.0, 0.0]])) == pytest.approx(0.0, abs=1e-15)
    assert stretching(np.array([[2.0, 0.0]]))[0, 1] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("height", [1.05 / RATIO, 0.3, 0.6, 1.0, 1.5, 3.0, 8.0])
def test_no_fiber_that_fits_into_the_melt_feels_more(height: float) -> None:
    path = streamline(height)
    felt = felt_rate(path, from_corner(path), 1.0)
    for at in range(0, len(path), 15):
        place = path.position[at, :2]
        if np.linalg.norm(place) > 10.0:
            continue
        for angle in np.linspace(0.0, np.pi, 24, endpoint=False):
            lowest = place[1] - np.hypot(np.sin(angle), np.cos(angle) / RATIO)
            if lowest > 0.0:
                assert mean_rate(place, angle) < felt[at] * (1.0 + QUADRATURE)


def test_far_from_the_corner_it_is_the_rate_that_is_there() -> None:
    path = streamline(1.0)
    distance = from_corner(path)
    for a, room in ((1e-2, 2e-2), (1e-3, 2e-3)):  # a over the distance, and what is met within a
        felt = felt_rate(path, distance, a)
        assert np.all(felt >= path.shear_rate)
        assert felt == pytest.approx(path.shear_rate, rel=room)


def test_it_has_a_limit_at_the_corner_which_falls_with_longer_fibers() -> None:
    """Ever nearer, the rate grows without bound; what is felt stays, and goes as ``a^(-1/2)``."""
    most = []
    for height in (1e-2, 1e-3, 1e-4):
        path = streamline(height, reach=2.0, points=4001)
        felt = felt_rate(path, from_corner(path), 1.0)
        most.append(felt.max())
        assert path.shear_rate.max() > 0.9 / np.sqrt(height)
    # The field's largest K is that of the wall and of the surface: 2, once on the way
    assert most == pytest.approx([2.0 * 2.4] * 3, rel=2e-2)
    longer = felt_rate(path, from_corner(path), 4.0)
    assert longer.max() == pytest.approx(0.5 * most[-1], rel=2e-2)


def test_the_limit_is_that_of_a_spheroid_whose_middle_is_on_the_corner() -> None:
    """The mean of ``|t|^-q`` along the axis, weighed by the cross-sections, for any index."""
    t, weight = np.polynomial.legendre.leggauss(400)
    t, weight = 0.5 * (1.0 + t), 0.5 * weight
    path = FlowHistory(
        [0.0, 1.0], np.zeros((2, 2)), np.zeros((2, 2)), [[[0, 1], [0, 0]]] * 2, [0.0, 0.0]
    )
    for n in (1.0, 0.5, 0.2):
        q = 1.0 / (1.0 + n)
        # in s = t^(1 - q), where the integrand is smooth
        mean = 1.5 * np.sum(weight * (1.0 - t ** (2.0 / (1.0 - q)))) / (1.0 - q)
        felt = felt_rate(path, np.full(2, 0.1), 1.0, index=n)
        assert felt == pytest.approx(0.1**q * mean, rel=1e-9)


def test_a_line_nearer_to_the_corner_is_judged_above_its_neighbour() -> None:
    """The nearest point of each line, from five half-lengths to a tenth of one."""
    lines = [streamline(height) for height in (5.0, 2.0, 1.0, 0.5, 0.2, 0.1)]
    most = [felt_rate(line, from_corner(line), 1.0).max() for line in lines]
    assert np.all(np.diff(most) > -1e-2 * most[-1])
    assert all(felt > line.shear_rate.max() for felt, line in zip(most[:3], lines[:3], strict=True))


def test_pressures_go_with_what_is_felt_and_the_gradients_error_adds() -> None:
    path = streamline(0.5)
    distance = from_corner(path)
    bounds = pressure_bounds(felt_path(path, distance, 1.0), RESPONSE, MU)
    felt, plain = felt_rate(path, distance, 1.0), pressure_bounds(path, RESPONSE, MU)
    assert bounds.lowest == pytest.approx(plain.lowest * felt / path.shear_rate, rel=1e-12)
    rough = felt_rate(path, distance, 1.0, error=0.1 * path.shear_rate / np.sqrt(2.0))
    assert rough == pytest.approx(1.1 * felt, rel=1e-12)


def test_paths_at_once_are_each_their_own_and_melt_at_rest_feels_nothing() -> None:
    lines = [streamline(height) for height in (0.3, 1.0)]
    both = FlowHistory.stack(lines)
    found = felt_rate(both, from_corner(both), 1.0)
    for one, alone in zip(found, lines, strict=True):
        assert np.array_equal(one, felt_rate(alone, from_corner(alone), 1.0))
    still = replace(both, gradient=0.0 * both.gradient)
    assert not felt_path(still, from_corner(still), 1.0).gradient.any()


def test_a_fiber_of_no_length() -> None:
    path = streamline(1.0)
    with pytest.raises(ConfigError, match=r"fiber.half_length = 0 m: must be positive"):
        felt_rate(path, from_corner(path), 0.0)
