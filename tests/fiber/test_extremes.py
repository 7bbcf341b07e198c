"""Pressures along a path, their extremes, bounds and quantiles."""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Ellipse,
    ellipse_extremes,
    extreme_bounds,
    extremes,
    follow,
    isotropic_angles,
    isotropic_pressure,
    jeffery_period,
    paper_angles,
    pressure_bounds,
    statistics,
    surface_pressure,
    unbounded_ellipse,
)
from fibermelt.history import FlowHistory, simple_shear

FEW = examples(25)  # each builds a table or a chain of arrays
RESPONSE = unbounded_ellipse(Ellipse(42e-6, 6.0))
MU = 817.0
ZONES = (1.0, 1.5, 2.2)  # when the zones are reached, of three seconds
TABLE = 1e-7  # ten times the support table's tolerance, over the largest pressure


def wandering(seed: int, points: int = 80) -> FlowHistory:
    """A smooth random history."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 3.0, points)
    waves = np.sin(np.outer(t, [1.0, 2.0, 3.0]) + rng.uniform(0.0, 6.0, 3))
    a, b, c = (waves @ rng.normal(size=3) for _ in range(3))
    L = np.stack([np.stack([a, b], -1), np.stack([c, -a], -1)], axis=-2)
    velocity = np.stack([np.cos(t), np.sin(t)], axis=-1)
    position = np.stack([np.sin(t), -np.cos(t)], axis=-1)
    return FlowHistory(t, position, velocity, L, 1e5 * np.cos(t))


def chain(history: FlowHistory, start: np.ndarray, mu: float = MU):
    motion = follow(history, RESPONSE.shape_factor, start)
    return motion, surface_pressure(history, RESPONSE, mu, motion)


def test_pressure_is_the_closed_form_along_a_path() -> None:
    history = wandering(1)
    motion, pressure = chain(history, paper_angles())
    c, s = np.cos(motion.angle), np.sin(motion.angle)
    D = history.strain_rate
    along = D[:, 0, 0] * (c * c - s * s) + 2.0 * D[:, 0, 1] * c * s
    across = D[:, 0, 1] * (c * c - s * s) - 2.0 * D[:, 0, 0] * c * s
    low, high = ellipse_extremes(6.0, along, across)
    scale = TABLE * MU * np.max(high)
    assert pressure.lowest == pytest.approx(MU * low, abs=scale)
    assert pressure.highest == pytest.approx(MU * high, abs=scale)
    assert pressure.tip == pytest.approx(-2.0 * 7.0 * MU * along, abs=scale)


def test_shear_the_right_way_round() -> None:
    """u_x = y stretches along +45 degrees: there the tips are sucked, at -45 pushed."""
    history = simple_shear(1.0, 1e-6, 2)
    _, pressure = chain(history, np.array([0.25 * np.pi, -0.25 * np.pi]))
    assert pressure.lowest[0, 0] == pytest.approx(-MU * 7.0, rel=1e-6)
    assert pressure.highest[1, 0] == pytest.approx(MU * 7.0, rel=1e-6)
    assert pressure.where_lowest[0, 0] == pytest.approx(0.0, abs=1e-6)
    assert pressure.where_highest[1, 0] == pytest.approx(0.0, abs=1e-6)


def test_a_slender_fiber_is_lowest_at_its_tip_as_it_turns_towards_alignment() -> None:
    history = simple_shear(1.0, jeffery_period(6.0, 1.0), 4001)
    motion, pressure = chain(history, np.array([0.5 * np.pi]))
    at = int(np.argmin(pressure.lowest[0]))
    folded = motion.angle[0, at] - np.pi * np.round(motion.angle[0, at] / np.pi)
    assert 0.0 < folded < 0.5 * np.pi  # before alignment
    assert motion.spin[0, at] < 0.0  # and turning towards it
    assert abs(pressure.where_lowest[0, at]) < 0.05  # within b^2/a of the tip
    # the extreme over the orbit, off by the square of the points' spacing
    assert pressure.lowest[0].min() == pytest.approx(-7.0 * MU, rel=1e-4)


def test_a_circle_does_not_notice_its_turning() -> None:
    circle = unbounded_ellipse(Ellipse(1.0, 1.0))
    history = simple_shear(1.0, jeffery_period(1.0, 1.0), 101)
    motion = follow(history, circle.shape_factor, paper_angles())
    pressure = surface_pressure(history, circle, MU, motion)
    assert pressure.lowest == pytest.approx(-2.0 * MU, rel=1e-12)
    assert pressure.highest == pytest.approx(2.0 * MU, rel=1e-12)


@FEW
@given(st.floats(1e-3, 1e6))
def test_pressures_are_proportional_to_the_viscosity(mu: float) -> None:
    history = wandering(2, 20)
    _, one = chain(history, paper_angles(), 1.0)
    _, other = chain(history, paper_angles(), mu)
    assert other.lowest == pytest.approx(mu * one.lowest, rel=1e-12)
    assert other.highest == pytest.approx(mu * one.highest, rel=1e-12)


@given(st.integers(0, 10_000), st.floats(-np.pi, np.pi), st.floats(0.2, 1.8))
def test_every_fiber_lies_between_the_bounds(seed: int, start: float, first: float) -> None:
    history = wandering(seed)
    motion, pressure = chain(history, np.array([start, start + 1.0]))
    bounds = pressure_bounds(history, RESPONSE, MU)
    room = TABLE * bounds.highest
    assert np.all(pressure.lowest >= bounds.lowest - room)
    assert np.all(pressure.lowest <= bounds.mildest_lowest + room)
    assert np.all(pressure.highest <= bounds.highest + room)
    assert np.all(pressure.highest >= bounds.mildest_highest - room)
    zones = (first, first + 0.3, first + 1.0)
    found = extremes(history, pressure, motion, zones)
    sides = extreme_bounds(history, bounds, zones)
    assert np.all(found.value >= sides[..., 0] - room.max())
    assert np.all(found.value <= sides[..., 1] + room.max())


def test_some_orientation_reaches_each_bound() -> None:
    history = simple_shear(2.0, 1e-6, 2)
    _, pressure = chain(history, isotropic_angles(3601))
    bounds = pressure_bounds(history, RESPONSE, MU)
    size = bounds.highest[0]
    # 0.05 degrees from the worst orientation
    assert pressure.lowest[:, 0].min() == pytest.approx(bounds.lowest[0], abs=1e-5 * size)
    assert pressure.lowest[:, 0].max() == pytest.approx(bounds.mildest_lowest[0], abs=1e-2 * size)
    assert pressure.highest[:, 0].max() == pytest.approx(bounds.highest[0], abs=1e-5 * size)


def test_extremes_are_where_they_say() -> None:
    history = wandering(3)
    motion, pressure = chain(history, paper_angles())
    found = extremes(history, pressure, motion, ZONES)
    assert found.value.shape == (13, 3, 2)
    before = history.time <= ZONES[0]
    swell = (history.time >= ZONES[1]) & (history.time <= ZONES[2])
    for place, here in enumerate((before | True, before, swell)):
        assert found.value[:, place, 0] == pytest.approx(pressure.lowest[:, here].min(axis=1))
        assert found.value[:, place, 1] == pytest.approx(pressure.highest[:, here].max(axis=1))
        assert np.all(here[found.index[:, place]])
    assert found.x == pytest.approx(np.sin(found.time))
    assert found.y == pytest.approx(-np.cos(found.time))
    assert found.pressure == pytest.approx(found.value + 1e5 * np.cos(found.time))
    fiber = np.take_along_axis(motion.angle, found.index.reshape(13, 6), axis=1).reshape(13, 3, 2)
    stream = history.direction[found.index]
    assert np.sin(found.angle - fiber + stream) == pytest.approx(0.0, abs=1e-12)
    phase = np.take_along_axis(pressure.phase, found.index.reshape(13, 6), axis=1)
    point = RESPONSE.curve.point(found.where)
    amplitude = pressure.amplitude[found.index]
    seen = np.cos(phase.reshape(13, 3, 2)) * point[..., 0]
    seen += np.sin(phase.reshape(13, 3, 2)) * point[..., 1]
    assert amplitude * seen == pytest.approx(found.value, abs=TABLE * np.abs(found.value).max())


def test_statistics_over_the_initial_angles() -> None:
    histories = [wandering(seed) for seed in range(3)]
    bundle = FlowHistory.stack(histories)
    motion, pressure = chain(bundle, paper_angles())
    zones = np.linspace(ZONES, np.add(ZONES, 0.5), 3)
    found = extremes(bundle, pressure, motion, zones)
    assert found.value.shape == (3, 13, 3, 2)
    numbers = statistics(found)
    assert numbers.mean == pytest.approx(found.value.mean(axis=1))
    assert np.all(numbers.lowest <= numbers.median)
    assert np.all(numbers.median <= numbers.highest)
    for k, history in enumerate(histories):
        single_motion, single = chain(history, paper_angles())
        alone = extremes(history, single, single_motion, zones[k])
        assert found.value[k] == pytest.approx(alone.value, rel=1e-7)
        assert numbers.x[k] == pytest.approx(alone.x.mean(axis=0))


def test_isotropic_quantiles() -> None:
    bundle = FlowHistory.stack([wandering(seed, 40) for seed in range(2)])
    zones = np.linspace(ZONES, np.add(ZONES, 0.5), 2)
    found = isotropic_pressure(bundle, RESPONSE, MU, zones, 20_000)
    bounds = pressure_bounds(bundle, RESPONSE, MU)
    sides = extreme_bounds(bundle, bounds, zones)
    assert found.lowest.shape == (2, 40, 3)
    assert found.extremes.shape == (2, 3, 2, 3)
    for quantiles in (found.lowest, found.highest, found.extremes):
        assert np.all(np.diff(quantiles, axis=-1) >= 0.0)
    assert np.all(found.lowest >= bounds.lowest[..., None] * (1.0 + TABLE))
    assert np.all(found.highest <= bounds.highest[..., None] * (1.0 + TABLE))
    room = TABLE * bounds.highest.max()
    assert np.all(found.extremes >= sides[..., :1] - room)
    assert np.all(found.extremes <= sides[..., 1:] + room)
    # at the start the orientations are isotropic: the quantiles are those of the support function
    phase = 2.0 * np.pi * np.arange(100_000) / 100_000
    exact = np.quantile(RESPONSE.support(phase), [0.05, 0.5, 0.95])
    amplitude = bounds.highest[:, :1] / RESPONSE.support.largest
    # 20,000 angles are 3e-4 apart as phases, in a slope below three
    assert found.highest[:, 0] == pytest.approx(amplitude * exact, rel=1e-3)
    assert found.lowest[:, 0] == pytest.approx(-amplitude * exact[::-1], rel=1e-3)


def test_bad_input() -> None:
    history = wandering(0)
    motion, pressure = chain(history, paper_angles())
    with pytest.raises(ConfigError, match="viscosity = 0"):
        surface_pressure(history, RESPONSE, 0.0, motion)
    with pytest.raises(ConfigError, match="point up to zone 1"):
        extremes(history, pressure, motion, (-1.0, 1.0, 2.0))
    with pytest.raises(ConfigError, match="point from zone 2 to zone 3"):
        extremes(history, pressure, motion, (1.0, 1.5, 1.5 - 1e-9))
    with pytest.raises(ConfigError, match=r"zone_time has shape \(\): .* 3 zones"):
        extremes(history, pressure, motion, 1.0)
    with pytest.raises(ConfigError, match="quantile levels"):
        isotropic_pressure(history, RESPONSE, MU, ZONES, levels=(0.5, 1.5))
