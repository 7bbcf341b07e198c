"""Quantiles of fibers that start isotropic: closed forms, counts, and their own estimate."""

from __future__ import annotations

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Ellipse,
    FiberResponse,
    extremes,
    follow,
    isotropic_angles,
    isotropic_pressure,
    pressure_bounds,
    surface_pressure,
    unbounded_ellipse,
)
from fibermelt.fiber.support import FINE
from fibermelt.history import FlowHistory

FEW = examples(15)  # each follows fibers
MU = 817.0
ZONES = (1.0, 1.5, 2.2)  # when the zones are reached, of three seconds
LEVELS = (0.05, 0.5, 0.95)
COUNT = 200
NEAREST = np.pi / FINE + 1e-8  # of the largest: the nearest phase, and the support's table


def lopsided() -> FiberResponse:
    """A response without the fiber's mirror symmetry, with corners: as a coarse mesh gives it."""
    s = 2.0 * np.pi * np.arange(64) / 64
    first = -5.0 * np.cos(2.0 * s) + 0.7 * np.sin(2.0 * s) - 0.8 * np.cos(6.0 * s)
    second = 2.0 * np.sin(2.0 * s) + 0.5 * np.cos(4.0 * s) + 0.6 * np.sin(8.0 * s)
    return FiberResponse(5.0, 0.9, s, np.stack([first, second], axis=-1))


RESPONSES = {
    "ellipse": unbounded_ellipse(Ellipse(1.0, 6.0)),
    "slender": unbounded_ellipse(Ellipse(1.0, 40.0)),
    "nearly round": unbounded_ellipse(Ellipse(1.0, 1.05)),
    "lopsided": lopsided(),
}


def history(seed: int, points: int = 60, rate: float = 3.0) -> FlowHistory:
    """A smooth random history through shear, extension and turning."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 3.0, points)
    waves = np.sin(np.outer(t, [1.0, 2.0, 3.0]) + rng.uniform(0.0, 6.0, 3))
    a, b, c = (rate * (waves @ rng.normal(size=3)) for _ in range(3))
    L = np.stack([np.stack([a, b], -1), np.stack([c, -a], -1)], axis=-2)
    plane = np.stack([np.cos(t), np.sin(t)], axis=-1)
    return FlowHistory(t, plane, plane, L, np.zeros(points))


def extension(rate: float, time: float, points: int = 5) -> FlowHistory:
    """Stretching along x at an even rate."""
    t = np.linspace(0.0, time, points)
    L = np.broadcast_to(np.diag([rate, -rate]), (points, 2, 2))
    plane = np.stack([np.ones(points), np.zeros(points)], axis=-1)
    return FlowHistory(t, plane, plane, L, np.zeros(points))


@pytest.mark.parametrize("name", RESPONSES)
def test_the_nearest_phase_is_near_enough(name: str) -> None:
    support = RESPONSES[name].support
    phase = np.random.default_rng(1).uniform(-30.0, 30.0, 5000)
    for near, exact in zip(support.near(phase), support.both(phase), strict=True):
        assert near == pytest.approx(exact, abs=NEAREST * support.largest)


@FEW
@given(st.integers(0, 10_000), st.sampled_from(list(RESPONSES)))
def test_they_are_those_of_fibers_that_are_followed(seed: int, name: str) -> None:
    path, response = history(seed), RESPONSES[name]
    motion = follow(path, response.shape_factor, isotropic_angles(COUNT))
    pressure = surface_pressure(path, response, MU, motion)
    value = extremes(path, pressure, motion, ZONES).value
    found = isotropic_pressure(path, response, MU, ZONES, COUNT, LEVELS)
    room = NEAREST * pressure_bounds(path, response, MU).highest.max()
    for one, values in (
        (found.lowest, pressure.lowest),
        (found.highest, pressure.highest),
        (found.extremes, value),
    ):
        followed = np.moveaxis(np.quantile(values, LEVELS, axis=0), 0, -1)
        assert one == pytest.approx(followed, abs=room)
    half = np.moveaxis(np.quantile(value[::2], LEVELS, axis=0), 0, -1)
    error = np.abs(half - np.moveaxis(np.quantile(value, LEVELS, axis=0), 0, -1))
    assert found.extremes_error == pytest.approx(error, abs=4.0 * room)


@pytest.mark.parametrize("count", [200, 2000])
@pytest.mark.parametrize("level", [0.7, 0.8, 0.95])
def test_extension_in_closed_form(level: float, count: int) -> None:
    """Stretched along x the phase is -2 theta, and tan(theta) falls as exp(-2 xi rate t)."""
    response, path = RESPONSES["ellipse"], extension(2.0, 1.2)
    pull = np.exp(-2.0 * response.shape_factor * 2.0 * path.time)
    found = isotropic_pressure(path, response, MU, None, count, (1.0 - level, level))
    room = NEAREST * 2.0 * MU * response.support.largest

    def phases(share: float) -> np.ndarray:
        return 2.0 * np.arctan(pull * np.tan(0.5 * np.pi * share))

    # h rises with |phi| from where it is as high as at phi = 0: there |phi| itself has quantiles;
    # phi + pi is small where the lowest pressure is deep. An arc has two ends, one fiber at each
    # may be in or out
    low, high = (2.0 * MU * response.support(phases(level + by / count)) for by in (-2, 2))
    above = response.support(phases(level - 2 / count)) > response.support(np.zeros(1))
    assert above[0]
    assert np.all((found.highest[:, 1] >= low - room)[above])
    assert np.all((found.highest[:, 1] <= high + room)[above])
    least, most = (
        -2.0 * MU * response.support(np.pi - phases(1.0 - level + by / count)) for by in (-2, 2)
    )
    assert np.all((found.lowest[:, 0] >= least - room) & (found.lowest[:, 0] <= most + room))


def test_the_share_below_is_what_is_counted_among_many() -> None:
    """Of evenly spaced fibers an arc holds its share but for one at either end."""
    many, path, response = 20_000, history(7), RESPONSES["ellipse"]
    motion = follow(path, response.shape_factor, isotropic_angles(many))
    highest = surface_pressure(path, response, MU, motion).highest
    found = isotropic_pressure(path, response, MU, ZONES, COUNT, LEVELS)
    room = NEAREST * pressure_bounds(path, response, MU).highest
    for k, level in enumerate(LEVELS):
        below = np.mean(highest < found.highest[:, k] - room, axis=0)
        assert np.all(below <= level + 2.0 / COUNT)
        assert np.all(np.mean(highest <= found.highest[:, k] + room, axis=0) >= level - 2 / COUNT)


def test_the_error_falls_with_the_count_and_is_what_is_estimated() -> None:
    response, path = RESPONSES["ellipse"], history(3)
    exact = isotropic_pressure(path, response, MU, None, 40_000).extremes
    errors, estimates = [], []
    for count in (100, 1000, 10_000):
        found = isotropic_pressure(path, response, MU, None, count)
        errors.append(np.mean(np.abs(found.extremes - exact)))
        estimates.append(np.mean(found.extremes_error))
    # the order is one: a quantile is off by what lies to the next fiber; a third is left for luck
    assert np.all(np.array(errors[1:]) < 0.3 * np.array(errors[:-1]))
    ratio = np.array(estimates) / np.array(errors)
    assert np.all((ratio > 0.3) & (ratio < 10.0))


def test_a_circle_has_one_pressure() -> None:
    path, circle = history(1), unbounded_ellipse(Ellipse(1.0, 1.0))
    found = isotropic_pressure(path, circle, MU, ZONES)
    bounds = pressure_bounds(path, circle, MU)
    for k in range(3):
        assert found.highest[:, k] == pytest.approx(bounds.highest, rel=1e-12)
        assert found.lowest[:, k] == pytest.approx(bounds.lowest, rel=1e-12)
    before = path.time <= ZONES[0]
    swell = (path.time >= ZONES[1]) & (path.time <= ZONES[2])
    assert found.extremes[0, 1] == pytest.approx(bounds.highest.max(), rel=1e-12)
    assert found.extremes[1, 1] == pytest.approx(bounds.highest[before].max(), rel=1e-12)
    assert found.extremes[2, 0] == pytest.approx(bounds.lowest[swell].min(), rel=1e-12)
    assert found.extremes_error == pytest.approx(0.0, abs=1e-12 * bounds.highest.max())


def test_paths_do_not_notice_each_other() -> None:
    paths, response = [history(seed) for seed in range(5)], RESPONSES["ellipse"]
    zones = np.linspace(ZONES, np.add(ZONES, 0.5), 5)
    whole = isotropic_pressure(FlowHistory.stack(paths), response, MU, zones)
    room = 1e-9 * np.abs(whole.lowest).max()
    for k, path in enumerate(paths):
        alone = isotropic_pressure(path, response, MU, zones[k])
        for name in ("lowest", "highest", "extremes", "extremes_error"):
            assert getattr(alone, name) == pytest.approx(getattr(whole, name)[k], abs=room)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, 2.2])
def test_fibers_beyond_all_measure_of_alignment(angle: float) -> None:
    """A stretch by exp(900): every quantile is that of the aligned."""
    response, path = RESPONSES["ellipse"], extension(3.0, 300.0, 201)
    c, s = np.cos(angle), np.sin(angle)
    Q = np.array([[c, -s], [s, c]])
    plane = path.position[:, :2]
    path = FlowHistory(path.time, plane, plane, Q @ path.plane_gradient @ Q.T, path.pressure)
    found = isotropic_pressure(path, response, MU, None)
    aligned = 3.0 * MU * response.support(np.array([np.pi, 0.0]))
    room = NEAREST * 3.0 * MU * response.support.largest
    assert found.lowest[-1] == pytest.approx(np.full(3, -aligned[0]), abs=room)
    assert found.highest[-1] == pytest.approx(np.full(3, aligned[1]), abs=room)


def test_a_melt_at_rest_presses_on_no_fiber() -> None:
    found = isotropic_pressure(extension(0.0, 1.0), RESPONSES["ellipse"], MU, None)
    assert not np.any(found.lowest)
    assert not np.any(found.highest)
    assert not np.any(found.extremes)


@pytest.mark.parametrize("count", [0, -3, 2.5, True])
def test_no_count_of_fibers(count: object) -> None:
    with pytest.raises(ConfigError, match=r"count = .*: must be a whole number of at least 1"):
        isotropic_pressure(history(1), RESPONSES["ellipse"], MU, None, count)  # type: ignore[arg-type]
