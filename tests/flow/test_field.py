"""Fields on triangles: nodal bases, point location, interpolation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from square import square_field

from fibermelt.flow.lagrange import LagrangeTriangle

ROUNDING = 1e-11
"""Interpolating a polynomial of the field's degree leaves rounding only; degree 6 costs 1e-12."""


@pytest.mark.parametrize("order", range(1, 7))
def test_basis_is_nodal_and_sums_to_one(order: int) -> None:
    triangle = LagrangeTriangle(order)
    values, slopes = triangle.evaluate(triangle.nodes)
    assert len(triangle.nodes) == (order + 1) * (order + 2) // 2
    np.testing.assert_allclose(values, np.eye(len(values)), atol=ROUNDING)
    np.testing.assert_allclose(slopes.sum(axis=1), 0, atol=100 * ROUNDING)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_slopes_are_the_derivatives(order: int) -> None:
    triangle = LagrangeTriangle(order)
    at, h = np.array([[0.2, 0.3], [0.5, 0.1]]), 1e-6
    _, slopes = triangle.evaluate(at)
    for axis in (0, 1):
        step = h * np.eye(2)[axis]
        central = (triangle.evaluate(at + step)[0] - triangle.evaluate(at - step)[0]) / (2 * h)
        np.testing.assert_allclose(slopes[..., axis], central, atol=1e-8)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_split_covers_the_triangle_once(order: int) -> None:
    triangle = LagrangeTriangle(order)
    a, b, c = np.moveaxis(triangle.nodes[triangle.split()], 1, 0)
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert np.all(area > 0)
    assert area.sum() == pytest.approx(0.5)
    assert len(area) == order**2


@given(
    st.integers(1, 4),
    st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=20),
)
def test_polynomials_of_its_degree_are_exact(order: int, inside: list[tuple[float, float]]) -> None:
    field = square_field(order)
    xy = np.array(inside)
    values = (field.points @ [0.3, -0.7]) ** order
    place = field.locate(xy)
    assert place.found.all()
    np.testing.assert_allclose(
        field.evaluate(values, place), (xy @ [0.3, -0.7]) ** order, atol=ROUNDING
    )


def test_points_are_found_in_curved_triangles() -> None:
    field = square_field(3, bend=0.2)
    rng = np.random.default_rng(1)
    flat = rng.uniform(size=(200, 2))
    xy = flat + 0.2 * np.column_stack([np.zeros(200), flat[:, 0] ** 3])
    place = field.locate(xy)
    assert place.found.all()
    np.testing.assert_allclose(field.evaluate(field.points, place), xy, atol=ROUNDING)


def test_points_outside_are_told_from_those_inside() -> None:
    field = square_field(2)
    place = field.locate(np.array([[0.5, 0.5], [1.5, 0.5], [0.2, -0.1]]))
    assert place.found.tolist() == [True, False, False]
    values = field.evaluate(field.pressure, place)
    assert np.isnan(values).tolist() == [False, True, True]


def test_a_wrong_guess_is_walked_away_from() -> None:
    field = square_field(2, n=8)
    guess = field.locate(np.array([[0.05, 0.05]]))
    place = field.locate(np.array([[0.95, 0.9]]), guess)
    np.testing.assert_allclose(field.evaluate(field.points, place), [[0.95, 0.9]], atol=ROUNDING)


def test_shear_rate_of_simple_shear() -> None:
    np.testing.assert_allclose(square_field(2).shear_rate, 1.0, rtol=1e-15)
