"""Flow histories: what they take over, and what they refuse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from fibermelt.errors import HistoryError
from fibermelt.fiber import follow
from fibermelt.history import FlowHistory, simple_shear

PLAIN = {
    "time": [0, 1, 3],
    "position": [[0, 0]] * 3,
    "velocity": [[0, 0]] * 3,
    "gradient": [[[0, 2], [0, 0]]] * 3,
    "pressure": [0, 0, 0],
}


def test_lists_of_integers_are_taken() -> None:
    history = FlowHistory(**PLAIN)
    assert len(history) == 3
    assert history.shear_rate == pytest.approx([2.0, 2.0, 2.0])
    assert all(getattr(history, name).dtype == np.float64 for name in PLAIN)


def test_what_a_history_was_made_of_may_change_afterwards() -> None:
    time = np.array([0.0, 1.0, 3.0])
    history = FlowHistory(**{**PLAIN, "time": time})
    time[:] = 0.0
    assert history.time.tolist() == [0.0, 1.0, 3.0]


@pytest.mark.parametrize("name", list(PLAIN))
def test_a_history_and_a_bundle_stay_as_they_are(name: str) -> None:
    # `follow` keeps the last path's map for the next set of angles: it must not go stale
    history = simple_shear(1.0, 3.0, 4)
    for kept in (history, FlowHistory.stack([history, history])):
        with pytest.raises(ValueError, match="read-only"):
            getattr(kept, name)[...] = 0.0


def test_a_history_with_another_gradient_is_another() -> None:
    history = simple_shear(1.0, 3.0, 4)
    faster = replace(history, gradient=2.0 * history.gradient)
    slow, fast = (follow(one, 0.9, np.array([0.3])).angle[0, -1] for one in (history, faster))
    long = follow(simple_shear(1.0, 6.0, 4), 0.9, np.array([0.3])).angle[0, -1]
    assert fast == pytest.approx(long, abs=1e-12)  # twice the rate for half the time: rounding
    assert abs(fast - slow) > 0.1


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("time", "soon", "history: time is no array of numbers"),
        ("pressure", [[0, 0], [0]], "history: pressure is no array of numbers"),
        ("time", 1.0, r"history: time has shape \(\), expected \(\.\.\., n\)"),
        ("time", [0.0], "1 points of time"),
        ("time", [0.0, 1.0, 1.0], r"time\[2\] = 1 s follows 1 s"),
        ("time", [0.0, 2.0, 1.0], r"time\[2\] = 1 s follows 2 s"),
        ("time", [0.0, 1.0, np.inf], r"time\[2\] = inf is not finite"),
        ("velocity", [[0, 0]] * 2, r"velocity has shape \(2, 2\), expected \(3, 2\)"),
        ("gradient", [[[1, 0], [0, 0]]] * 3, r"gradient\[0\] has trace 1 1/s"),
    ],
)
def test_what_no_history_can_be(name: str, value: object, message: str) -> None:
    with pytest.raises(HistoryError, match=message):
        FlowHistory(**{**PLAIN, name: value})


@pytest.mark.parametrize(
    ("duration", "points", "message"),
    [(1.0, 0, "0 points of time"), (1.0, 1, "1 points of time"), (0.0, 5, "follows 0 s")],
)
def test_a_shear_without_time(duration: float, points: int, message: str) -> None:
    with pytest.raises(HistoryError, match=message):
        simple_shear(1.0, duration, points)


LINEAR = np.array([[0.3, 1.0, 0.0], [0.1, -0.5, 0.2], [0.0, 0.0, 0.2]])
"""A steady flow ``u = L x`` without symmetry: no transposed gradient fits it."""


AXIS = np.array([0.0, 0.0, 1.0])


def linear(points: int, duration: float = 3.0) -> FlowHistory:
    """Return a path of the flow of `LINEAR`, exact."""
    t = np.linspace(0.0, duration, points)
    x = np.stack([expm(LINEAR * time) @ [1.0, 1.0, 0.5] for time in t])
    L = np.tile(LINEAR, (points, 1, 1))
    return FlowHistory(t, x, x @ LINEAR.T, L, np.zeros(points))


def test_the_plane_is_a_part_of_space() -> None:
    flat = simple_shear(2.0, 3.0, 5)
    assert flat.planar
    assert flat.position.shape == (5, 3)
    assert flat.gradient.shape == (5, 3, 3)
    assert flat.plane_gradient == pytest.approx(flat.gradient[:, :2, :2], abs=0.0)
    lifted = replace(flat, position=flat.position + 4.0 * AXIS)
    assert lifted.planar
    assert not linear(5).planar
    swirl = replace(flat, velocity=flat.velocity + AXIS)
    assert not swirl.planar
    with pytest.raises(HistoryError, match="leaves the plane of x and y"):
        follow(swirl, 0.9, [0.3])


def test_a_plane_that_is_given_as_one_is_not_looked_for() -> None:
    flat = simple_shear(2.0, 3.0, 5)
    assert vars(flat)["planar"]
    assert not flat.plane_gradient.flags.writeable
    # a copy is given in space, and comes to the same
    whole = replace(flat, pressure=flat.pressure)
    assert "planar" not in vars(whole)
    assert whole.planar
    assert np.array_equal(whole.plane_gradient, flat.plane_gradient)


def test_stacked_and_taken_apart() -> None:
    paths = [linear(9), replace(linear(9), viscosity=np.full(9, 3.0))]
    both = FlowHistory.stack(paths)
    assert both.time.shape == (2, 9)
    assert len(both) == 9
    assert both.viscosity is None  # one of them does not know it
    for line, path in zip(both.lines, paths, strict=True):
        assert np.array_equal(line.position, path.position)
    assert paths[0].lines == (paths[0],)
    with pytest.raises(HistoryError, match=r"histories of \[5, 9\] points cannot be stacked"):
        FlowHistory.stack([linear(5), linear(9)])


@pytest.mark.parametrize(("points", "kept"), [(9, [0, 2, 4, 6, 8]), (8, [0, 1, 3, 5, 7])])
def test_every_second_point_and_both_ends(points: int, kept: list[int]) -> None:
    whole = FlowHistory.stack([linear(points), linear(points)])
    assert np.array_equal(whole.every_second().time, whole.time[:, kept])


def test_an_exact_history_fits_itself_to_second_order() -> None:
    found = [linear(points).consistency() for points in (51, 101, 201)]
    assert all(one.told == () for one in found)
    for name in ("transport", "steadiness"):
        first, second, third = (getattr(one, name) for one in found)
        assert np.log2(first / second) == pytest.approx(2.0, abs=0.05)
        assert np.log2(second / third) == pytest.approx(2.0, abs=0.05)


def test_what_does_not_fit_is_told_with_how_much() -> None:
    good = linear(201)
    turned = replace(good, gradient=good.gradient.swapaxes(-1, -2)).consistency()
    assert len(turned.told) == 1
    assert "transposed" in turned.told[0]
    assert turned.steadiness > 0.3
    scaled = replace(good, position=1e3 * good.position).consistency()
    assert "dx/dt = u" in scaled.told[0]
    assert scaled.transport == pytest.approx(0.999, abs=1e-3)
    absolute = replace(good, pressure=np.linspace(2e6, 101325.0, 201)).consistency()
    assert "absolute" in absolute.told[0]
    unsteady = replace(good, gradient=2.0 * good.gradient).consistency()
    assert "not steady" in unsteady.told[0]
    wave = np.cos(np.arange(9))[:, None, None] * LINEAR
    coarse = replace(linear(9), gradient=wave).consistency()
    assert any("9 points are few" in line for line in coarse.told)


def test_straight_paths_of_rounded_velocities_fit() -> None:
    """Where ``L u = 0`` the velocity changes by rounding, which once was all of it."""
    rng = np.random.default_rng(1)
    shear = simple_shear(3.0, 2.0, 101)
    way = np.linspace(0.0, 10.0, 101)[:, None] * [1.0, 0.0, 0.0]
    rounded = np.tile([5.0, 0.0, 0.0], (101, 1)) + 1e-14 * rng.normal(size=(101, 3))
    straight = replace(shear, position=way, velocity=rounded)
    assert straight.consistency().told == ()
    assert straight.consistency().steadiness < 1e-12
    # as in the middle of a channel, where the gradient is rounding, too
    noise = 1e-14 * rng.normal(size=(101, 3, 3))
    noise -= np.trace(noise, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3.0
    assert replace(straight, gradient=noise).consistency().told == ()
    turned = replace(straight, gradient=straight.gradient.swapaxes(-1, -2)).consistency()
    assert "transposed" in turned.told[0]
    assert turned.steadiness == pytest.approx(1.0, abs=1e-6)


def test_what_a_history_says_of_itself() -> None:
    assert repr(simple_shear(2.0, 3.0, 5)) == (
        "FlowHistory(5 points in the plane, 3 s, strain 6, pressure 0 to 0 Pa)"
    )
    assert repr(FlowHistory.stack([linear(5), linear(5)])).startswith(
        "FlowHistory(2 paths, 5 points in space"
    )
