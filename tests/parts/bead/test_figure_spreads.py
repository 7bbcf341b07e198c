from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from drawn_bead import SHEAR, SPEED, made_up, sheared
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fibermelt.fiber.models import unbounded_model
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.surroundings import surroundings
from fibermelt.parts.bead.figures.alignment import (
    STARTS,
    alignment_words,
    figure_alignment,
    isotropic_angles,
    within_quarter_turn,
)
from fibermelt.parts.bead.figures.cell import cell_words
from fibermelt.parts.bead.figures.extremes import EXTREMES, extremes_words, figure_extremes
from fibermelt.parts.bead.figures.positions import figure_positions, positions_words, worst_places
from fibermelt.parts.bead.figures.pressure_history import figure_history, history_words
from fibermelt.parts.bead.figures.profiles import figure_profiles, profiles_words, relative_angle
from fibermelt.parts.bead.figures.spread import MEAN, MEDIAN
from fibermelt.parts.bead.figures.surroundings import read_instant
from fibermelt.parts.flow.figures.lines import features, regular
from fibermelt.parts.flow.figures.streamlines import streamlines_words
from fibermelt.parts.flow.figures.timeline import on_fibers
from fibermelt.report.kit.style import Words
from fibermelt.report.kit.tables import number, short

ROUNDING = 1e-12

GRID = np.pi / STARTS
"""Spacing of the starts that stand for all [rad]."""


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return made_up()


def _line(axes: Axes, color: str) -> np.ndarray:
    (found,) = [
        line for line in axes.lines if line.get_color() == color and len(line.get_xdata()) > 10
    ]
    return np.asarray(found.get_ydata())


def _panels(figure: Figure) -> list[Axes]:
    """Axes with a panel's letter."""
    return [axes for axes in figure.axes if any(t.get_text()[1:3] == "  " for t in axes.texts)]


def test_mean_and_median_are_those_of_the_stored_extremes(results: xr.Dataset) -> None:
    steady = regular(results)
    for axes, (_, location, kind) in zip(
        _panels(figure_extremes.draw(results)), EXTREMES, strict=True
    ):
        stored = 1e-6 * results["extreme"].sel(location=location, kind=kind)
        for color, expected in (
            (MEAN, stored.mean("initial_angle")),
            (MEDIAN, stored.median("initial_angle")),
        ):
            drawn = _line(axes, color)
            np.testing.assert_allclose(drawn[steady], expected[steady], rtol=ROUNDING)
            assert np.isnan(drawn[~steady]).all()


def test_envelopes_are_the_stored_bounds(results: xr.Dataset) -> None:
    bounds = 1e-6 * results["extreme_bounds"].sel(location=2, kind="min").to_numpy()
    band = _panels(figure_extremes.draw(results))[1].collections[0].get_paths()[0].vertices
    for line, (low, high) in zip(results["streamline"].to_numpy(), bounds, strict=True):
        here = band[band[:, 0] == line, 1]
        assert here.min() == pytest.approx(low)
        assert here.max() == pytest.approx(high)


def test_a_streamline_near_a_corner_does_not_set_the_scale_and_is_told(results: xr.Dataset) -> None:
    wild = results.copy(deep=True)
    first = {"streamline": 0, "location": 2}
    wild["extreme"][first] *= 50.0
    wild["extreme_bounds"][first] *= 50.0
    calm, drawn = _panels(figure_extremes.draw(results))[1], _panels(figure_extremes.draw(wild))[1]
    assert drawn.get_ylim() == calm.get_ylim()
    mean = 1e-6 * float(wild["extreme"][first].sel(kind="min").mean())
    assert short(mean, 3) in [text.get_text() for text in drawn.texts]
    assert not any("−" in text.get_text() for text in calm.texts)
    assert "beyond the scales" in extremes_words(wild).caption
    assert "beyond the scales" not in extremes_words(results).caption


def test_one_fiber_is_drawn_with_its_extremes(results: xr.Dataset) -> None:
    start = np.degrees(results["initial_angle"].to_numpy())
    for axes, side, angle, kind in zip(
        _panels(figure_history.draw(results)),
        ("lowest", "highest"),
        (0.0, -90.0),
        ("min", "max"),
        strict=False,
    ):
        fiber = int(np.argmin(np.abs(start - angle)))
        drawn = [np.asarray(line.get_ydata()) for line in axes.lines]
        stored = on_fibers(results, side, 9)[fiber]
        assert any(len(y) == len(stored) and np.allclose(y, stored, rtol=1e-12) for y in drawn)
        ends = (
            1e-6 * results["extreme_pressure"][9, fiber].sel(location=[1, 2], kind=kind).to_numpy()
        )
        marks = [float(y[0]) for y in drawn if len(y) == 1]
        np.testing.assert_allclose(marks, ends)
        rise = 1e-6 * results["extreme"][9, fiber].sel(location=[1, 2], kind=kind).to_numpy()
        told = " ".join(text.get_text() for text in axes.texts)
        assert all(f"{number(value, 3)} MPa at Loc. {k}" in told for k, value in enumerate(rise, 1))


def test_words_on_one_fiber_follow_its_numbers(results: xr.Dataset) -> None:
    deep = results.copy(deep=True)
    deep["extreme_pressure"] -= 1e6
    assert history_words(deep).alt != history_words(results).alt


def test_all_fibers_of_the_marked_streamlines_are_drawn(results: xr.Dataset) -> None:
    panels = [axes for axes in figure_profiles.draw(results).axes if len(axes.lines) > 5]
    expected = [
        values(results, row)
        for row in (3, 9, 17)
        for values in (
            lambda r, k: on_fibers(r, "lowest", k),
            lambda r, k: on_fibers(r, "highest", k),
            relative_angle,
        )
    ]
    for axes, values in zip(panels, expected, strict=True):
        drawn = [np.asarray(line.get_ydata()) for line in axes.lines]
        for one in values:
            assert any(len(y) == len(one) and np.allclose(y, one) for y in drawn)


def test_relative_angles_end_near_the_streamline_and_never_jump(results: xr.Dataset) -> None:
    row = 9
    angle = relative_angle(results, row)
    assert np.abs(angle[:, -1]).max() <= 90.0
    way = np.degrees(np.arctan2(results["v"][row], results["u"][row]).to_numpy())
    stored = np.degrees(results["angle"].to_numpy()[row])
    np.testing.assert_allclose(np.sin(np.radians(2 * (angle - stored + way))), 0.0, atol=1e-9)
    turned = np.abs(np.diff(way)) > 0
    assert np.abs(np.diff(angle, axis=1))[:, ~turned].max() < 30.0


@given(
    st.floats(-3.0, 3.0),
    st.floats(0.2, 5.0),
    st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=8, unique_by=lambda x: round(x, 1)),
)
def test_all_starts_follow_from_three(shear: float, stretch: float, start: list[float]) -> None:
    p0 = np.array(start)

    def later(theta: np.ndarray) -> np.ndarray:
        return np.arctan2(np.sin(theta) / stretch, stretch * np.cos(theta) + shear * np.sin(theta))

    even = np.pi * (np.arange(STARTS) + 0.5) / STARTS
    found = isotropic_angles(p0, later(p0))
    assert found is not None
    # Starts are at least 0.05 rad apart, which magnifies rounding by its inverse square.
    np.testing.assert_allclose(np.sin(found - later(even)), 0.0, atol=1e-8)


def test_two_directions_do_not_tell_of_all() -> None:
    start = np.array([-0.5 * np.pi, 0.0, 0.5 * np.pi])
    assert isotropic_angles(start, start) is None


def test_bands_of_all_starts_are_exact(results: xr.Dataset) -> None:
    when = float(results["zone_time"][0, 2])
    even = np.pi * (np.arange(STARTS) + 0.5) / STARTS
    exact = np.degrees(within_quarter_turn(sheared(even, np.array(when))))
    axes = _panels(figure_alignment.draw(results))[2]
    for band, share in zip(axes.collections, (0.9, 0.5), strict=True):
        at = band.get_paths()[0].vertices
        inner = at[at[:, 0] == 10, 1]
        ends = np.quantile(exact, [0.5 - share / 2, 0.5 + share / 2])
        np.testing.assert_allclose([inner.min(), inner.max()], ends, atol=np.degrees(GRID))
    assert when * SHEAR > 1.0


def test_positions_are_the_stored_ones(results: xr.Dataset) -> None:
    for axes, (_, location, kind) in zip(
        _panels(figure_positions.draw(results)), EXTREMES, strict=True
    ):
        points = np.vstack([cloud.get_offsets() for cloud in axes.collections])
        stored = [
            1e3 * results[f"extreme_{name}"].sel(location=location, kind=kind).to_numpy()
            for name in "xy"
        ]
        expected = np.column_stack([part.ravel() for part in stored])
        order = [np.lexsort(np.round(part, 9).T) for part in (points, expected)]
        np.testing.assert_allclose(points[order[0]], expected[order[1]])


def test_bounds_are_reached_where_the_deformation_is_fastest(results: xr.Dataset) -> None:
    # Made up: the rate, and so the bound, is largest at y = 4 mm, between zones 1 and 2.
    assert worst_places(results, 0, "min")[3, 1] == pytest.approx(4e-3, abs=2e-4)
    passed = 12e-3 - results["zone_time"][3].to_numpy() * SPEED
    for location, zone in ((1, 0), (2, 1)):
        found = worst_places(results, location, "max")[3, 1]
        assert found == pytest.approx(passed[zone], abs=2e-4)


@pytest.mark.parametrize("ratio", [3.0, 6.0])
def test_a_fiber_moves_as_a_rigid_body_in_the_flow_drawn_around_it(ratio: float) -> None:
    model = unbounded_model("ellipse", Ellipse(1.0, ratio))
    around = surroundings(model)
    L = np.array([[3.0, -2.0], [7.0, -3.0]])
    angle, a, mu = 0.7, 4e-5, 800.0
    results = xr.Dataset(
        {
            "angle": (("streamline", "initial_angle", "point"), [[[angle]]]),
            "gradient": (("streamline", "point", "row", "column"), [[L]]),
            "cell_point": (("n", "component"), around.points),
            "cell_triangle": (("triangle", "corner"), around.cells),
            "cell_edge": (("edge", "along"), around.lines),
            "cell_velocity": (("n", "mode", "component"), around.velocity),
            "cell_pressure": (("n", "mode"), around.pressure),
            "viscosity": (("streamline", "point"), [[mu]]),
            **{
                name: (("streamline", "point"), [[k + 1.0]])
                for k, name in enumerate(("time", "pressure", "u", "v"))
            },
        }
    )
    found = read_instant(results, 0, 0, 0, a)
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, -sin], [sin, cos]])
    D = turn.T @ (0.5 * (L + L.T)) @ turn
    spin = 0.5 * (L[1, 0] - L[0, 1]) + model.response.shape_factor * D[0, 1]
    on_rim = np.isclose(around.points[:, 0] ** 2 + (ratio * around.points[:, 1]) ** 2, 1.0)
    assert on_rim.sum() > 20
    rim = a * around.points[on_rim] @ turn.T
    rigid = spin * np.column_stack([-rim[:, 1], rim[:, 0]])
    np.testing.assert_allclose(found.around[on_rim], rigid, atol=1e-9 * a)
    np.testing.assert_allclose(found.speed[on_rim], np.hypot(*(rigid + np.array([3.0, 4.0])).T))
    # The surface pressure is the response's, whose points are others: its peak is compared.
    peak = mu * np.abs(model.response.basis @ [D[0, 0], D[0, 1]]).max()
    assert np.abs(found.pressure[on_rim]).max() == pytest.approx(peak, rel=0.02)


def test_marked_streamlines_are_the_studys() -> None:
    asked = made_up().assign_attrs(config="[streamlines]\nfeatures = [7, 3, 40, 3]")
    assert [feature.number for feature in features(asked)] == [3, 7]
    many = made_up().assign_attrs(config="[streamlines]\nfeatures = [1, 2, 3, 4, 5, 6, 7]")
    assert len({feature.color for feature in features(many)}) == 5


def test_fibers_in_space_are_drawn() -> None:
    flat = made_up(angles=6)
    rise = np.linspace(-0.4, 0.8, 6)
    space = flat.assign(
        initial_elevation=("initial_angle", rise),
        elevation=(flat["angle"].dims, np.broadcast_to(rise[:, None], flat["angle"].shape)),
    )
    assert "out of the plane" in history_words(space).caption
    assert "out of the plane" not in history_words(flat).caption
    for plate in (figure_history, figure_profiles, figure_alignment):
        assert plate.draw(space).axes


@pytest.mark.parametrize(
    "words", [alignment_words, extremes_words, positions_words, streamlines_words]
)
def test_corners_are_told_of_where_a_streamline_passes_one(
    results: xr.Dataset, words: Callable[[xr.Dataset], Words]
) -> None:
    near = results["near_singularity"]
    assert "sharp corner" in words(results.assign(near_singularity=near * 0 + 1)).caption
    assert "sharp corner" not in words(results.assign(near_singularity=near * 0)).caption


def test_both_ways_across_are_told_to_be_one_fiber_where_they_enter(results: xr.Dataset) -> None:
    start = results["initial_angle"]
    edges = np.linspace(-0.5 * np.pi, 0.5 * np.pi, start.size)
    told = "Fibers that enter at ±90° are the same fiber."
    assert told in profiles_words(results.assign_coords(initial_angle=edges)).caption
    assert told not in profiles_words(results.assign_coords(initial_angle=edges / 2)).caption


def test_a_circle_is_told_no_worst_orientation(results: xr.Dataset) -> None:
    told = "the orientation with the lowest pressure"
    assert told in cell_words(results).caption
    circle = results.assign(aspect_ratio=results["aspect_ratio"] * 0 + 1.0)
    assert told not in cell_words(circle).caption
    assert "as at any other; the lowest pressure is" in cell_words(circle).caption
