from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from drawn_bead import AREA, made_up
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.flow.lagrange import LagrangeTriangle
from fibermelt.report.carpet import weave
from fibermelt.report.drawing import curves
from fibermelt.report.lines import at_time, features, initial_angles, rest
from fibermelt.report.scene import SIDES, Scene, Window, _lattice, by_area, inside, read_scene
from fibermelt.report.style import round_up, share_within

ROUNDING = 1e-12
"""Relative; sums of a few thousand areas."""

WHOLE = Window(-100.0, 100.0, -100.0, 100.0)


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return made_up()


@pytest.fixture(scope="module")
def scene(results: xr.Dataset) -> Scene:
    return read_scene(results)


def _area(line: np.ndarray) -> float:
    x, y = line.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("order", range(1, 7))
def test_nodes_are_counted_as_the_flow_counts_them(order: int) -> None:
    places = np.array(list(_lattice(order))) / order
    np.testing.assert_allclose(places, LagrangeTriangle(order).nodes, atol=ROUNDING)


def test_outline_goes_once_around_the_melt(scene: Scene) -> None:
    assert _area(scene.outline) == pytest.approx(AREA, rel=ROUNDING)


def test_sides_are_what_they_are_called(scene: Scene) -> None:
    assert tuple(scene.sides) == SIDES
    np.testing.assert_allclose(scene.sides["left wall"][:, 0], -1.5)
    np.testing.assert_allclose(scene.sides["right wall"][:, 0], 1.5)
    np.testing.assert_allclose(scene.sides["bed"][:, 1], 0.0)
    np.testing.assert_allclose(scene.sides["outlet"][:, 0], 12.0)
    np.testing.assert_allclose(scene.sides["inlet"][:, 1], 12.0)
    np.testing.assert_allclose(scene.sides["downstream surface"][:, 1], 3.0)
    np.testing.assert_allclose(scene.lips, [[-1.5, 3.0], [1.5, 3.0]])
    np.testing.assert_allclose(scene.contact, [-2.0, 0.0])
    assert scene.bead_height == pytest.approx(3.0)
    assert scene.capillary_entrance == pytest.approx(8.0)


def test_small_triangles_and_edges_cover_the_melt(scene: Scene, results: xr.Dataset) -> None:
    _, area = by_area(scene, scene.points[:, 0], WHOLE)
    assert area.sum() == pytest.approx(AREA, rel=ROUNDING)
    cells = results.sizes["cell"]
    boundary = len(scene.outline) - len(SIDES)
    # Each triangle has three edges, each inner edge two triangles; a boundary edge has two steps.
    assert len(scene.edges) == (3 * cells + boundary // 2) // 2


def test_a_window_shows_only_what_reaches_into_it(scene: Scene) -> None:
    window = Window(5.0, 6.0, 0.0, 1.0)
    corners = scene.points[inside(scene, window)]
    assert len(corners)
    assert corners[..., 0].max(axis=1).min() > 5.0
    assert corners[..., 0].min(axis=1).max() < 6.0


def test_straight_edges_are_two_points_and_bent_ones_all() -> None:
    points = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.5, 0.1]])
    assert len(curves(points, np.array([[0, 1, 2]]), 0.05).vertices) == 2
    assert len(curves(points, np.array([[0, 3, 2]]), 0.05).vertices) == 3


def test_strips_cover_what_lies_between_the_lines_and_reproduce_values(
    results: xr.Dataset,
) -> None:
    carpet = weave(results)
    assert carpet is not None
    triangles = carpet.triangles
    x = 1e-3 * np.asarray(triangles.x)
    # Linear in time along each line, as x is on both straight legs; the corner lies between.
    np.testing.assert_allclose(carpet.values(results["x"].to_numpy()), x, atol=1e-15)
    corners = np.stack([triangles.x, triangles.y], -1)[triangles.triangles]
    (ax, ay), (bx, by) = np.diff(corners, axis=1).transpose(1, 2, 0)
    lines = [1e3 * np.stack([results["x"][k], results["y"][k]], -1) for k in (0, -1)]
    between = abs(_area(np.vstack([lines[0], lines[1][::-1]])))
    # Strips may fold where the lines turn sharply: at most one point's spacing along each line.
    assert 0.5 * np.abs(ax * by - ay * bx).sum() == pytest.approx(between, rel=0.02)


def test_one_streamline_has_no_strips() -> None:
    assert weave(made_up(count=1)) is None


def test_the_papers_streamlines_are_marked(results: xr.Dataset) -> None:
    marked = features(results)
    assert [feature.number for feature in marked] == [4, 10, 18]
    assert len({feature.color for feature in marked}) == 3
    assert sorted([*rest(results), *(feature.row for feature in marked)]) == list(range(22))


@pytest.mark.parametrize(("count", "numbers"), [(11, [2, 5, 9]), (2, [1, 2]), (1, [1])])
def test_of_other_counts_those_with_the_same_flux_are_marked(
    count: int, numbers: list[int]
) -> None:
    bead = made_up(count=count).drop_attrs()
    assert [feature.number for feature in features(bead)] == numbers


def test_values_at_a_time_lie_on_the_line(results: xr.Dataset) -> None:
    time = results["time"].to_numpy()[3]
    middle = np.full((results.sizes["streamline"], 1), 0.5 * (time[4] + time[5]))
    y = results["y"].to_numpy()[3]
    assert at_time(results, "y", middle)[3, 0] == pytest.approx(0.5 * (y[4] + y[5]))


@pytest.mark.parametrize(("count", "words"), [(1, "1 initial angle"), (13, "13 initial angles")])
def test_angles_are_counted_in_words(count: int, words: str) -> None:
    assert initial_angles(made_up(count=1, angles=count)) == words


@given(st.floats(1e-8, 1e8))
def test_scales_end_at_a_round_number_not_below(value: float) -> None:
    end = round_up(value)
    assert value * (1 - 1e-11) <= end <= 1.6 * value
    assert round_up(end) == pytest.approx(end, rel=1e-9)


@given(st.integers(1, 99))
def test_share_is_by_weight_and_blind_to_sign(percent: int) -> None:
    values = np.arange(1.0, 101.0) * np.where(np.arange(100) % 2, 1, -1)
    assert share_within(values, np.ones(100), percent / 100) in {percent, percent + 1}
    heavy = np.where(np.abs(values) <= 10, 1e6, 1.0)
    assert share_within(values, heavy, percent / 100) <= 10
