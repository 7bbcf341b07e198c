"""Streamlines in flows whose streamlines are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from square import square_field

from fibermelt.errors import ConvergenceError
from fibermelt.flow.problem import Deposition, Nozzle
from fibermelt.flow.streamlines import _first_below, inlet_seeds
from fibermelt.flow.tracing import Rules, follow_lines, trace
from fibermelt.history import FlowHistory
from fibermelt.melt import Newtonian

TOLERANCE = 1e-9


def test_shear_flow_is_traced_exactly() -> None:
    field = square_field(2)
    seeds = np.array([[0.0, 0.25], [0.0, 0.75]])
    for path, y in zip(trace(field, seeds, 0.9, TOLERANCE, 0.1), (0.25, 0.75), strict=True):
        np.testing.assert_allclose(path.position[:, 1], y, atol=1e-14)
        assert path.position[-1, 0] == pytest.approx(0.9, abs=1e-9)
        assert path.time[-1] == pytest.approx(0.9 / (1 + y), rel=1e-9)


def test_a_circle_is_followed_to_the_tolerance() -> None:
    field = square_field(2)
    x, y = field.points.T
    circling = replace(field, velocity=np.column_stack([y + 0.2, -(x + 0.2)]))
    seed = np.array([[0.05, 0.7]])
    (path,) = trace(circling, seed, 0.6, TOLERANCE, 0.1)
    radius = np.hypot(*(path.position + 0.2).T)
    # every step may miss by the tolerance, and misses add up at worst
    assert np.ptp(radius) < len(radius) * TOLERANCE
    turned = np.arctan2(0.25, 0.9) - np.arctan2(*(path.position[-1] + 0.2))
    assert path.time[-1] == pytest.approx(-turned, rel=1e-6)
    between, time = path.at(np.linspace(0, path.arclength[-1], 77))
    assert np.all(np.diff(time) > 0)
    np.testing.assert_allclose(np.hypot(*(between + 0.2).T), radius[0], rtol=1e-5)


def test_a_line_that_leaves_the_field_is_an_error() -> None:
    field = square_field(1)
    rising = replace(field, velocity=np.tile([0.1, 1.0], (len(field.points), 1)))
    with pytest.raises(ConvergenceError, match="streamline 1 is stuck there or leaves the mesh"):
        trace(rising, np.array([[0.1, 0.5]]), 0.9, TOLERANCE, 0.1)


def test_steps_out_of_the_field_are_taken_back() -> None:
    # no point of a step that has left says where the next one begins to search a curved triangle
    field = square_field(2, bend=0.3)
    (path,) = follow_lines(field, np.array([[0.0, 0.6]]), Rules(TOLERANCE, 20.0))
    assert path.end == "left"
    assert path.position[-1] == pytest.approx([1.0, 0.6], abs=1e-4)


def test_lines_say_how_they_end() -> None:
    field = square_field(2)
    x, y = field.points.T
    # to the right above y = 1/2, at rest there, and a corner flow that stops at the origin
    sliding = replace(field, velocity=np.column_stack([y - 0.5, 0 * y]))
    seeds = np.array([[0.1, 0.9], [0.1, 0.6], [0.1, 0.7]])
    rules = Rules(TOLERANCE, 0.1, outlet=0.8, most_time=5.0, least_speed=0.11)
    ends = [path.end for path in follow_lines(sliding, seeds, rules)]
    assert ends == ["arrived", "still", "arrived"]
    stopping = replace(field, velocity=np.column_stack([-x, -y]))
    (path,) = follow_lines(stopping, np.array([[0.4, 0.8]]), Rules(TOLERANCE, 0.1, most_time=3.0))
    assert path.end == "late"
    assert path.at(np.array([path.length]))[1] == pytest.approx(3.0, rel=1e-12)
    assert path.time[-1] >= 3.0
    (path,) = follow_lines(field, np.array([[0.4, 0.8]]), Rules(TOLERANCE, 0.1))
    assert path.end == "left"
    assert path.position[-1] == pytest.approx([1.0, 0.8], abs=1e-6)


def test_time_and_what_lies_between_the_steps_are_held_to_the_tolerance() -> None:
    """``x = 0.9 exp(-t)`` on a straight way, where no step misses its position."""
    field = square_field(2)
    x, y = field.points.T
    slowing = replace(field, velocity=np.column_stack([-x, 0 * y]))
    seed = np.array([[0.9, 0.5]])
    misses = []
    for between in (False, True):
        rules = Rules(1e-7, 0.5, most_time=4.0, between=between)
        (path,) = follow_lines(slowing, seed, rules)
        xy, time = path.at(np.linspace(0.0, path.length, 400))
        misses.append(np.max(np.abs(xy[:, 0] - 0.9 * np.exp(-time))))
    assert misses[0] > 1e-3
    assert misses[1] < len(path.time) * 1e-7


@pytest.mark.parametrize("count", [1, 2, 22, 101])
def test_seeds_share_the_flux_equally(count: int) -> None:
    nozzle = Nozzle()
    fraction, x = inlet_seeds(Deposition(nozzle, Newtonian(817.0)), count)
    z = x / nozzle.inlet_width + 0.5
    np.testing.assert_allclose(3 * z**2 - 2 * z**3, fraction, atol=1e-14)
    np.testing.assert_allclose(x, -x[::-1], atol=1e-16)
    np.testing.assert_allclose(np.diff(fraction), 1 / count)


def falling(*height: float) -> FlowHistory:
    """Return a line through points at these heights, a second apart."""
    n = len(height)
    position = np.stack([np.zeros(n), height], axis=-1)
    return FlowHistory(
        np.arange(float(n)), position, np.ones((n, 2)), np.zeros((n, 2, 2)), np.zeros(n)
    )


def test_when_a_line_passes_a_height() -> None:
    line = falling(4.0, 3.0, 1.0, 2.5, 0.0)
    assert _first_below(line, 2.0) == 1.5
    assert _first_below(line, 3.0) == 1.0
    assert _first_below(line, 0.0) == 4.0


@pytest.mark.parametrize("level", [5.0, 4.0, -1.0])
def test_a_line_that_never_passes_a_height(level: float) -> None:
    # the first point was once taken for the last one's neighbour
    with pytest.raises(ConvergenceError, match=r"take more streamlines\.points"):
        _first_below(falling(4.0, 3.0, 0.0), level)


def test_when_paths_cross_a_plane() -> None:
    """Either way, at once where a path begins in it, and never."""
    lines = FlowHistory.stack([falling(4.0, 2.0, 0.0), falling(0.0, 1.0, 4.0), falling(3, 5, 6)])
    assert lines.time_across(1, 3.0) == pytest.approx([0.5, 1.0 + 2.0 / 3.0, 0.0], rel=1e-15)
    assert np.isnan(lines.time_across(1, 4.5)).tolist() == [True, True, False]
    assert lines.time_across(0, 0.0).tolist() == [0.0, 0.0, 0.0]
