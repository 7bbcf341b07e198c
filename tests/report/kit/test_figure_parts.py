from __future__ import annotations

from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from drawn_bead import AREA, made_up, rescaled
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg

from fibermelt.flow.lagrange import LagrangeTriangle
from fibermelt.parts.flow.figures.carpet import Carpet, weave
from fibermelt.parts.flow.figures.lines import at_time, features, initial_angles, rest
from fibermelt.report.kit.drawing import curves, spread_out
from fibermelt.report.kit.scene import SIDES, Scene, Window, _lattice, by_area, inside, read_scene
from fibermelt.report.kit.style import STYLE, Roomy, add_axes, new_figure, round_up, share_within

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


def _painted(carpet: Carpet) -> float:
    triangles = carpet.triangles
    corners = np.stack([triangles.x, triangles.y], -1)[triangles.triangles]
    (ax, ay), (bx, by) = np.diff(corners, axis=1).transpose(1, 2, 0)
    return float(0.5 * np.abs(ax * by - ay * bx).sum())


def _between(results: xr.Dataset) -> float:
    """Return the area between the first and the last line [mm2]."""
    lines = [1e3 * np.stack([results["x"][k], results["y"][k]], -1) for k in (0, -1)]
    return abs(_area(np.vstack([lines[0], lines[1][::-1]])))


def test_carpet_covers_what_lies_between_the_lines_and_reproduces_values(
    results: xr.Dataset,
) -> None:
    carpet = weave(results)
    assert carpet is not None
    held = carpet.when.size
    x, stored = 1e-3 * np.asarray(carpet.triangles.x), results["x"].to_numpy()
    # Linear in time along each line, as x is on both straight legs; the corner lies between.
    np.testing.assert_allclose(carpet.values(stored)[:held], x[:held], atol=1e-15)
    # The corner of a line is cut by at most the distance of its points.
    assert _painted(carpet) == pytest.approx(_between(results), rel=2e-3)


def _hairpins(scale: float = 1.0) -> xr.Dataset:
    """Return a bead whose left half of lines doubles back into a heel before it goes on."""
    bead = made_up(count=6)
    s = np.linspace(0.0, 1.0, bead.sizes["point"])
    reach = np.array([4.2, 4.0, 3.6, 0.0, 0.0, 0.0])[:, None] * np.exp(-(((s - 0.45) / 0.03) ** 2))
    x = bead["x"].to_numpy() - 1e-3 * reach
    results = bead.assign(x=(("streamline", "point"), x))
    return rescaled(results, scale) if scale != 1.0 else results


@pytest.mark.parametrize("scale", [1.0, 0.05, 20.0])
def test_carpet_is_painted_once_where_lines_double_back_at_every_scale(scale: float) -> None:
    results = _hairpins(scale)
    carpet = weave(results)
    assert carpet is not None
    # Strips that fold paint a place twice: their area is more than what lies between the lines.
    assert _painted(carpet) == pytest.approx(_between(results), rel=5e-3)


def test_carpet_is_a_membrane_no_value_lies_beyond_those_on_the_lines() -> None:
    results = _hairpins()
    carpet = weave(results)
    assert carpet is not None
    stored = np.sin(4e3 * results["x"].to_numpy()) * np.cos(3e3 * results["y"].to_numpy())
    values, held = carpet.values(stored), carpet.when.size
    assert values[held:].max() <= values[:held].max() + ROUNDING
    assert values[held:].min() >= values[:held].min() - ROUNDING
    np.testing.assert_allclose(carpet.values(np.ones_like(stored)), 1.0, rtol=1e-9)
    # A linear field is harmonic, and flat ends along x hold one that rises across them.
    x = carpet.values(results["x"].to_numpy())
    width = np.ptp(results["x"].to_numpy())
    assert np.abs(x - 1e-3 * np.asarray(carpet.triangles.x)).max() < 0.01 * width


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


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=6), st.floats(0.1, 3.0))
def test_labels_keep_their_order_and_their_distance_and_move_no_more_than_they_must(
    wanted: list[float], least: float
) -> None:
    places = np.array(wanted)
    moved = spread_out(places, least)
    order = np.argsort(places, kind="stable")
    assert (np.diff(moved[order]) >= least * (1 - 1e-9)).all()
    assert moved.mean() == pytest.approx(places.mean(), abs=1e-9)
    if (np.diff(places[order]) >= least).all():
        np.testing.assert_array_equal(moved, places)


@pytest.mark.parametrize("end", [2.3e-3, 0.15, 7.6, 20.0, 3e7])
def test_numbers_along_x_do_not_run_together(end: float) -> None:
    with mpl.rc_context(STYLE):
        axes = add_axes(new_figure(190, 60), 13, 10, 55, 45)
    axes.set_xlim(0.0, end)
    low, high = axes.get_xlim()
    with mpl.rc_context(STYLE):
        FigureCanvasAgg(axes.figure).draw()
        labels = [t.label1 for t in axes.xaxis.get_major_ticks() if low <= t.get_loc() <= high]
        boxes = [label.get_window_extent() for label in labels]
    assert len(boxes) >= 2
    assert all(one.x1 < other.x0 for one, other in pairwise(boxes))


def test_numbers_reach_no_farther_beyond_an_axis_than_they_may() -> None:
    with mpl.rc_context(STYLE):
        axes = add_axes(new_figure(190, 60), 60, 10, 55, 45)
        axes.set_xlim(0.0, 0.15)
        axes.xaxis.set_major_locator(Roomy(4, beyond=0.0))
        FigureCanvasAgg(axes.figure).draw()
        ticks = [t for t in axes.xaxis.get_major_ticks() if 0.0 <= t.get_loc() <= 0.15]
        boxes = [tick.label1.get_window_extent() for tick in ticks]
    frame = axes.get_window_extent()
    assert boxes
    assert all(frame.x0 <= box.x0 and box.x1 <= frame.x1 for box in boxes)


@pytest.mark.parametrize("scale", [1e-3, 0.05, 1.0, 7.0])
def test_the_scene_of_a_bead_scales_with_it(results: xr.Dataset, scale: float) -> None:
    one, other = read_scene(results), read_scene(rescaled(results, scale))
    for name in SIDES:
        np.testing.assert_allclose(other.sides[name], scale * one.sides[name], rtol=1e-9)
    assert other.width == pytest.approx(scale * one.width)
