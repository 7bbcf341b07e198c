"""Fields on simplices: points are found, values are interpolated."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from exact_flows import (
    FLOWS,
    PIPE,
    SLIT,
    ExactFlow,
    Mesh,
    box,
    embedded,
    exact_field,
    pipe,
    rectangle,
)

from fibermelt.errors import ConfigError
from fibermelt.fields.field import Field, Place
from fibermelt.fields.simplices import facets, sharp_nodes, signed_sizes

ROUNDING = 1e-12
"""Values of order one through a few products."""


def any_field(mesh: Mesh) -> Field:
    return exact_field(
        ExactFlow(
            "any",
            "planar" if mesh.cells.shape[1] == 3 else "spatial",
            lambda _: mesh,
            lambda x: x,
            lambda x: np.zeros((len(x), 3, 3)),
            lambda x: x[:, 0],
        ),
        1,
    )


def inside_points(mesh: Mesh, each: int) -> np.ndarray:
    """Return random points inside cells, so many in each."""
    k = mesh.cells.shape[1]
    weights = np.random.default_rng(3).dirichlet(np.ones(k), (len(mesh.cells), each))
    return np.einsum("mek,mkd->med", weights, mesh.points[mesh.cells]).reshape(-1, k - 1)


@pytest.mark.parametrize("mesh", [rectangle(6), box(4), pipe(3)])
def test_every_point_inside_is_found_and_mapped_back(mesh: Mesh) -> None:
    field = any_field(mesh)
    xyz = inside_points(mesh, 3)
    place = field.locate(xyz)
    assert place.found.all()
    back = field.evaluate(field.points, place)[:, : xyz.shape[1]]
    np.testing.assert_allclose(back, xyz, atol=ROUNDING)
    assert place.weights.min() > -1e-8


def comb() -> Mesh:
    """Return a rectangle without every other column of its upper half: no walk gets across."""
    mesh = rectangle(8)
    centre = mesh.points[mesh.cells].mean(axis=1)
    tooth = (centre[:, 0] * 8 // 1) % 2 == 0
    return Mesh(mesh.points, mesh.cells[(centre[:, 1] < 0.2) | tooth])


def test_points_across_a_gap_are_found_from_any_guess() -> None:
    mesh = comb()
    field = any_field(mesh)
    xyz = inside_points(mesh, 2)
    far = np.random.default_rng(5).permutation(len(xyz))
    start = field.locate(xyz[far])
    place = field.locate(xyz, start)
    assert place.found.all()
    np.testing.assert_allclose(field.evaluate(field.points, place)[:, :2], xyz, atol=ROUNDING)


def test_graded_and_stretched_cells_hide_no_point() -> None:
    mesh = rectangle(10)
    points = mesh.points * [1.0, 1e-3]
    points[:, 0] = points[:, 0] ** 4
    mesh = Mesh(points, mesh.cells[::3])  # most cells without a neighbour
    keep = np.abs(signed_sizes(mesh.points, mesh.cells)) > 0
    mesh = Mesh(points, mesh.cells[keep])
    field = any_field(mesh)
    assert field.locate(inside_points(mesh, 2)).found.all()


def test_points_outside_are_told() -> None:
    field = exact_field(SLIT, 4)
    xyz = np.array(
        [[0.5, 0.5, 0], [-0.1, 0.5, 0], [3.0, 0.5, 0], [0.5, np.nan, 0], [0.5, 1.001, 0]]
    )
    place = field.locate(xyz)
    np.testing.assert_array_equal(place.found, [True, False, False, False, False])
    u = field.velocity_at(place)
    assert np.all(np.isfinite(u[0]))
    assert np.all(np.isnan(u[1:]))
    # a guess that was outside starts anew
    again = field.locate(xyz, place)
    np.testing.assert_array_equal(again.found, place.found)
    assert len(field.locate(np.empty((0, 3))).cell) == 0
    with pytest.raises(ConfigError, match=r"points have shape \(3,\), expected"):
        field.locate(np.zeros(3))


@pytest.mark.parametrize("flow", FLOWS, ids=lambda flow: flow.name)
def test_velocity_is_exact_for_quadratics(flow: ExactFlow) -> None:
    field = exact_field(flow, 5)
    xyz = embedded(inside_points(flow.mesh(5), 1))
    place = field.locate(xyz)
    error = np.abs(field.velocity_at(place) - flow.velocity(xyz)).max()
    if flow.name == "mill":  # third derivatives of 8, edges of 0.2 and a little more
        assert 1e-5 < error < 8 * 0.3**3 / 12
    else:
        assert error < 10 * ROUNDING
        if flow in (SLIT, PIPE):  # which linear interpolation does not do
            assert np.abs(field.evaluate(field.velocity, place) - flow.velocity(xyz)).max() > 1e-2


def test_removed_trace_is_given_back_to_the_velocity() -> None:
    field = exact_field(SLIT, 4)
    x = field.points
    for geometry, share in (("planar", 2), ("axisymmetric", 3)):
        L = np.zeros((len(x), 3, 3))
        L[:, 0, 0] = 2 * x[:, 0]
        removed = np.zeros((3, 3))
        removed[range(share), range(share)] = 1 / share
        other = Field(
            geometry,
            x,
            field.cells,
            np.column_stack([x[:, 0] ** 2, 0 * x[:, 0], 0 * x[:, 0]]),
            L - L[:, :1, :1] * removed,
            np.zeros(len(x)),
            L[:, 0, 0],
            None,
            None,
            None,
            np.zeros(len(x), dtype=bool),
        )
        xyz = embedded(inside_points(SLIT.mesh(4), 1))
        u = other.velocity_at(other.locate(xyz))
        np.testing.assert_allclose(u[:, 0], xyz[:, 0] ** 2, atol=ROUNDING)


def test_neighbours_share_their_facets() -> None:
    for mesh in (rectangle(3), box(2)):
        found = facets(mesh.cells)
        k = mesh.cells.shape[1]
        for cell, row in enumerate(found.neighbour):
            for corner, other in enumerate(row):
                facet = set(np.delete(mesh.cells[cell], corner))
                if other >= 0:
                    assert facet <= set(mesh.cells[other])
        count = {3: 2 * (6 + 3), 4: 6 * 2 * 4}[k]
        assert len(found.boundary) == count


@pytest.mark.parametrize("mesh", [rectangle(3), box(3)])
def test_where_a_single_cell_is_missing_there_is_no_boundary(mesh: Mesh) -> None:
    k = mesh.cells.shape[1]
    whole = facets(mesh.cells)
    hole = int(np.flatnonzero((whole.neighbour >= 0).all(axis=1))[0])
    cells = np.delete(mesh.cells, hole, axis=0)
    found = facets(cells)
    assert len(found.boundary) == len(whole.boundary)
    assert len(facets(cells, over_slivers=False).boundary) == len(whole.boundary) + k
    # from each of its facets the walk goes round all of the others
    corners = set(mesh.cells[hole].tolist())
    around = np.isin(cells, list(corners)).sum(axis=1) == k - 1
    cell = first = int(np.flatnonzero(around)[0])
    met = []
    for _ in range(k):
        met.append(cell)
        (apart,) = np.flatnonzero(~np.isin(cells[cell], list(corners)))
        cell = int(found.neighbour[cell, apart])
    assert cell == first
    assert len(set(met)) == k


def test_only_edges_into_the_flow_are_sharp() -> None:
    assert sharp_nodes(rectangle(4).points, facets(rectangle(4).cells)).size == 0
    assert sharp_nodes(pipe(4).points, facets(pipe(4).cells)).size == 0
    for mesh, axes in ((rectangle(4), 2), (box(4), 3)):
        centre = mesh.points[mesh.cells].mean(axis=1)
        cells = mesh.cells[~np.all(centre[:, :2] > 0.5, axis=1)]
        sharp = sharp_nodes(mesh.points, facets(cells))
        assert len(sharp) == (1 if axes == 2 else 5)
        np.testing.assert_allclose(mesh.points[sharp][:, :2], 0.5, atol=0.1)


def test_place_keeps_what_was_found() -> None:
    place = Place(np.array([3, -1]), np.array([[0.2, 0.3], [0.1, 0.1]]))
    np.testing.assert_array_equal(place.found, [True, False])
    np.testing.assert_allclose(place.weights.sum(axis=1), 1)


def test_field_is_told_in_a_line() -> None:
    assert repr(exact_field(SLIT, 4)) == "Field(planar, 45 points, 64 cells)"


def test_field_is_unchanging() -> None:
    field = copy.copy(exact_field(SLIT, 3))
    with pytest.raises(ValueError, match="read-only"):
        field.velocity[0] = 1.0


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"geometry": "round"}, "geometry = "),
        ({"velocity": np.zeros((3, 3))}, "velocity has shape"),
        ({"pressure": np.full(45, np.nan)}, r"pressure\[0\] = nan is not finite"),
        ({"cells": np.zeros((1, 4), dtype=int)}, "expected .m, 3.: a planar field"),
        ({"cells": np.array([[0, 1, 99]])}, "cells name point 99"),
        ({"cells": np.array([[0, 1, 1]])}, "cell 0 has no size"),
    ],
)
def test_what_is_no_field_is_refused(change: dict[str, object], match: str) -> None:
    field = exact_field(SLIT, 4)
    assert len(field.points) == 45
    names = list(Field.__dataclass_fields__)
    given = {name: getattr(field, name) for name in names} | change
    with pytest.raises(ConfigError, match=match):
        Field(**given)
