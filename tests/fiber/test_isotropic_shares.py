"""Exact quantiles of fibers that start isotropic: closed forms, counts, what may not matter."""

from __future__ import annotations

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.fiber import (
    Ellipse,
    FiberResponse,
    extremes,
    follow,
    isotropic_angles,
    isotropic_pressure,
    population,
    pressure_bounds,
    shares,
    surface_pressure,
    unbounded_ellipse,
    unions,
)
from fibermelt.fiber.level_sets import LEVEL_TOLERANCE, level_sets
from fibermelt.fiber.roots import bracketed_roots
from fibermelt.fiber.support import SupportFunction
from fibermelt.history import FlowHistory

FEW = examples(15)  # each follows fibers
MU = 817.0
LEVELS = (0.05, 0.5, 0.95)
COUNT = 20_000
SPLINED = 5 * LEVEL_TOLERANCE  # level sets and support table, over the largest pressure
BRACKET = 1e-8  # of the extremes' search, ten times, over the largest pressure


def lopsided() -> FiberResponse:
    """A response without the fiber's mirror symmetry, with corners: as a coarse mesh gives it."""
    s = 2.0 * np.pi * np.arange(64) / 64
    first = -5.0 * np.cos(2.0 * s) + 0.7 * np.sin(2.0 * s) - 0.8 * np.cos(6.0 * s)
    second = 2.0 * np.sin(2.0 * s) + 0.5 * np.cos(4.0 * s) + 0.6 * np.sin(8.0 * s)
    return FiberResponse(5.0, 0.9, s, np.stack([first, second], axis=-1))


def valleys_on_the_axes() -> FiberResponse:
    """An even response whose valleys are at the phases 0 and pi, each its own image."""
    s = 2.0 * np.pi * np.arange(64) / 64
    basis = np.stack([np.cos(2.0 * s), 3.0 * np.sin(2.0 * s)], axis=-1)
    return FiberResponse(2.0, 0.6, s, basis)


RESPONSES = {
    "ellipse": unbounded_ellipse(Ellipse(1.0, 6.0)),
    "slender": unbounded_ellipse(Ellipse(1.0, 40.0)),
    "nearly round": unbounded_ellipse(Ellipse(1.0, 1.05)),
    "lopsided": lopsided(),
    "on the axes": valleys_on_the_axes(),
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


def turned(path: FlowHistory, angle: float) -> FlowHistory:
    """The same flow in axes turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    Q = np.array([[c, -s], [s, c]])
    gradient = Q @ path.plane_gradient @ Q.T
    return FlowHistory(
        path.time, path.position[..., :2], path.velocity[..., :2], gradient, path.pressure
    )


def sampled(path: FlowHistory, response: FiberResponse, middle: float, count: int = COUNT):
    """Pressures of evenly spaced fibers, one by one, and their extremes."""
    motion = follow(path, response.shape_factor, isotropic_angles(count))
    pressure = surface_pressure(path, response, MU, motion)
    return pressure, extremes(path, pressure, motion, middle).value


@pytest.mark.parametrize("level", [0.6, 0.8, 0.95])
def test_extension_in_closed_form(level: float) -> None:
    """Stretched along x the phase is -2 theta, and tan(theta) falls as exp(-2 xi rate t)."""
    response, path = RESPONSES["ellipse"], extension(2.0, 1.2)
    found = isotropic_pressure(path, response, MU, 0.6, (1.0 - level, level))
    pull = np.exp(-2.0 * response.shape_factor * 2.0 * path.time)
    # h rises with |phi| from where it is as high as at phi = 0: there |phi| itself has quantiles
    phase = 2.0 * np.arctan(pull * np.tan(0.5 * np.pi * level))
    above = response.support(phase) > response.support(np.zeros(1))
    assert above[0]
    exact = 2.0 * MU * response.support(phase)
    scale = SPLINED * 2.0 * MU * response.support.largest
    assert found.highest[above, 1] == pytest.approx(exact[above], abs=scale)
    # phi + pi is small where the lowest pressure is deep: the share of those beyond the level
    phase = np.pi - 2.0 * np.arctan(pull * np.tan(0.5 * np.pi * (1.0 - level)))
    above = response.support(phase) > response.support(np.zeros(1))
    assert np.all(above)
    exact = -2.0 * MU * response.support(phase)
    assert found.lowest[:, 0] == pytest.approx(exact, abs=scale)


def test_a_slender_fiber_at_the_start() -> None:
    """``h`` tends to ``2 (r_e + 1) |cos(phi)|`` on the compressed half: quantiles of a cosine."""
    ratio = 100.0
    found = isotropic_pressure(
        extension(1.0, 1e-9), unbounded_ellipse(Ellipse(1.0, ratio)), MU, 5e-10, (0.6, 0.8, 0.95)
    )
    exact = 2.0 * (ratio + 1.0) * MU * np.cos(np.pi * (1.0 - np.array([0.6, 0.8, 0.95])))
    # what is left out is (1 - cos^2)/(r_e cos)^2 of it, 9.5/r_e^2 at the lowest level
    assert found.highest[0] == pytest.approx(exact, rel=10.0 / ratio**2)


def test_a_circle_has_one_pressure() -> None:
    path = history(1)
    found = isotropic_pressure(path, unbounded_ellipse(Ellipse(1.0, 1.0)), MU, 1.5)
    bounds = pressure_bounds(path, unbounded_ellipse(Ellipse(1.0, 1.0)), MU)
    for k in range(3):
        assert found.highest[:, k] == pytest.approx(bounds.highest, rel=1e-12)
        assert found.lowest[:, k] == pytest.approx(bounds.lowest, rel=1e-12)
    before = path.time < 1.5
    assert found.extremes[0, 1] == pytest.approx(bounds.highest[before].max(), rel=1e-12)
    assert found.extremes[1, 0] == pytest.approx(bounds.lowest[~before].min(), rel=1e-12)


@pytest.mark.parametrize("name", list(RESPONSES))
def test_the_share_below_is_what_is_counted(name: str) -> None:
    """Of evenly spaced fibers an arc holds its share but for one at its ends."""
    response, path = RESPONSES[name], history(7)
    pressure, extreme = sampled(path, response, 1.5)
    found = isotropic_pressure(path, response, MU, 1.5, LEVELS)
    arcs = response.level_sets.valleys
    top = pressure_bounds(path, response, MU).highest
    for k, level in enumerate(LEVELS):
        for values, quantile in (
            (pressure.highest, found.highest[:, k]),
            (pressure.lowest, found.lowest[:, k]),
        ):
            room = SPLINED * top
            below = np.mean(values < quantile - room, axis=0)
            assert np.all(below <= level + arcs / COUNT)
            assert np.all(np.mean(values <= quantile + room, axis=0) >= level - arcs / COUNT)
        # a union of so many points' arcs has few pieces, as neighbours' arcs overlap
        quantile, room, pieces = found.extremes[..., k], SPLINED * top.max(), 20
        assert np.all(np.mean(extreme < quantile - room, axis=0) <= level + pieces / COUNT)
        assert np.all(np.mean(extreme <= quantile + room, axis=0) >= level - pieces / COUNT)


def test_samples_converge_to_the_exact_quantiles() -> None:
    response, path = RESPONSES["ellipse"], history(3)
    found = isotropic_pressure(path, response, MU, 1.5, LEVELS)
    errors = []
    for count in (200, 2000, 20_000):
        pressure, extreme = sampled(path, response, 1.5, count)
        pointwise = np.quantile(pressure.highest, LEVELS, axis=0).T - found.highest
        most = np.moveaxis(np.quantile(extreme, LEVELS, axis=0), 0, -1) - found.extremes
        errors.append([np.mean(np.abs(pointwise)), np.mean(np.abs(most))])
    # the order is one: a sample is off by its own distance to the next; a third is left for luck
    assert np.all(np.array(errors[1]) < 0.3 * np.array(errors[0]))
    assert np.all(np.array(errors[2]) < 0.3 * np.array(errors[1]))


@FEW
@given(st.integers(0, 10_000), st.floats(-np.pi, np.pi))
def test_turned_axes_change_nothing(seed: int, angle: float) -> None:
    one, response = history(seed), RESPONSES["ellipse"]
    two = turned(one, angle)
    found, other = (isotropic_pressure(path, response, MU, 1.5) for path in (one, two))
    room = SPLINED * pressure_bounds(one, response, MU).highest.max()
    for name in ("lowest", "highest", "extremes"):
        assert getattr(other, name) == pytest.approx(getattr(found, name), abs=room)


def test_mirrored_axes_change_nothing() -> None:
    one, response = history(11), RESPONSES["ellipse"]
    M = np.diag([1.0, -1.0])
    two = FlowHistory(
        one.time,
        one.position[:, :2],
        one.velocity[:, :2],
        M @ one.plane_gradient @ M,
        one.pressure,
    )
    found, mirrored = (isotropic_pressure(path, response, MU, 1.5) for path in (one, two))
    room = SPLINED * pressure_bounds(one, response, MU).highest.max()
    for name in ("lowest", "highest", "extremes"):
        assert getattr(mirrored, name) == pytest.approx(getattr(found, name), abs=room)


def test_paths_do_not_notice_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    paths, response = [history(seed) for seed in range(5)], RESPONSES["ellipse"]
    middle = np.linspace(1.0, 2.0, 5)
    whole = isotropic_pressure(FlowHistory.stack(paths), response, MU, middle)
    monkeypatch.setattr(population, "BLOCK", 2 * 60)
    cut = isotropic_pressure(FlowHistory.stack(paths[::-1]), response, MU, middle[::-1])
    room = BRACKET * pressure_bounds(FlowHistory.stack(paths), response, MU).highest.max()
    for name in ("lowest", "highest", "extremes"):
        assert getattr(cut, name)[::-1] == pytest.approx(getattr(whole, name), abs=room)
    alone = isotropic_pressure(paths[3], response, MU, middle[3])
    assert alone.lowest == pytest.approx(whole.lowest[3], abs=room)
    assert alone.extremes == pytest.approx(whole.extremes[3], abs=room)


@FEW
@given(st.integers(0, 10_000), st.sampled_from(list(RESPONSES)))
def test_points_left_out_change_nothing(seed: int, name: str) -> None:
    """All points looked at, from no bound below, without the first search."""
    path, response = history(seed), RESPONSES[name]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(unions, "FEW_POINTS", 0)
        found = isotropic_pressure(path, response, MU, 1.5)

    def everything(sets, points, asked):
        problems, n = asked.share.size, points.amplitude.size
        problem, point = (part.ravel() for part in np.indices((problems, n)))
        # the last axis of the problems is the location
        here = (path.time[point] < 1.5) == (problem % 2 == 0)
        asked = unions.Problems(
            asked.share, asked.opposite, np.zeros(problems), point[here], problem[here]
        )
        return unions.extreme_quantiles(sets, points, asked)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(population, "extreme_quantiles", everything)
        patch.setattr(unions, "FEW_POINTS", 1 << 20)
        whole = isotropic_pressure(path, response, MU, 1.5)
    room = BRACKET * pressure_bounds(path, response, MU).highest.max()
    assert whole.extremes == pytest.approx(found.extremes, abs=room)


@pytest.mark.parametrize("name", ["ellipse", "slender", "nearly round", "on the axes"])
def test_mirror_images_of_arcs_are_arcs(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path, even = history(5), RESPONSES[name]
    found = isotropic_pressure(path, even, MU, 1.5)
    assert even.level_sets.image is not None
    monkeypatch.setattr(SupportFunction, "even", False)
    plain = FiberResponse(even.aspect_ratio, even.shape_factor, even.surface, even.basis)
    assert plain.level_sets.image is None
    other = isotropic_pressure(path, plain, MU, 1.5)
    room = SPLINED * pressure_bounds(path, even, MU).highest.max()
    for field in ("lowest", "highest", "extremes"):
        assert getattr(other, field) == pytest.approx(getattr(found, field), abs=room)


@pytest.mark.parametrize("name", ["ellipse", "lopsided"])
def test_the_outermost_levels_are_the_bounds(name: str) -> None:
    # a weak flow, which leaves no range of directions to fewer fibers than are sampled
    path, response = history(2, rate=0.4), RESPONSES[name]
    found = isotropic_pressure(path, response, MU, 1.5, (0.0, 1.0))
    bounds = pressure_bounds(path, response, MU)
    room = SPLINED * bounds.highest.max()
    assert found.highest[:, 1] == pytest.approx(bounds.highest, abs=room)
    assert found.highest[:, 0] == pytest.approx(bounds.mildest_highest, abs=room)
    assert found.lowest[:, 0] == pytest.approx(bounds.lowest, abs=room)
    assert found.lowest[:, 1] == pytest.approx(bounds.mildest_lowest, abs=room)
    _, extreme = sampled(path, response, 1.5)
    # between two of the fibers followed an extreme may be further, by the square of their distance
    near = 1e-4 * bounds.highest.max()
    assert found.extremes[..., 0] == pytest.approx(extreme.min(axis=0), abs=near)
    assert found.extremes[..., 1] == pytest.approx(extreme.max(axis=0), abs=near)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, 2.2])
def test_fibers_beyond_all_measure_of_alignment(angle: float) -> None:
    """A stretch by exp(900): the spread is zero, and every quantile is that of the aligned."""
    response, path = RESPONSES["ellipse"], turned(extension(3.0, 300.0, 201), angle)
    found = isotropic_pressure(path, response, MU, 150.0)
    aligned = 3.0 * MU * response.support(np.array([np.pi, 0.0]))
    room = SPLINED * aligned.max()
    assert found.lowest[-1] == pytest.approx(np.full(3, -aligned[0]), abs=room)
    assert found.highest[-1] == pytest.approx(np.full(3, aligned[1]), abs=room)


def test_a_melt_at_rest_presses_on_no_fiber() -> None:
    found = isotropic_pressure(extension(0.0, 1.0), RESPONSES["ellipse"], MU, 0.5)
    assert not np.any(found.lowest)
    assert not np.any(found.highest)
    assert not np.any(found.extremes)


@pytest.mark.parametrize("name", list(RESPONSES))
def test_level_sets_end_where_the_level_is(name: str) -> None:
    support = RESPONSES[name].support
    sets = level_sets(support)
    level = sets.lowest + (sets.highest - sets.lowest) * np.linspace(0.003, 0.997, 101)
    left, right = sets.ends(*sets.locate(level))
    phase = 2.0 * np.pi * (np.arange(20_000) + 0.5) / 20_000
    below = support(phase) < level[:, None]
    inside = np.zeros_like(below)
    for start, end in zip(left, right, strict=True):
        assert np.all(end >= start)
        away = np.mod(phase - start[:, None], 2.0 * np.pi)
        inside |= away < (end - start)[:, None]
    # an arc's two ends may fall between the same two of the phases
    assert np.all(np.sum(inside != below, axis=1) <= 2 * sets.valleys)
    index, fraction = sets.locate(level)
    assert sets.level(index, fraction) == pytest.approx(level, rel=1e-12)


def test_the_share_of_an_arc_is_an_argument() -> None:
    """The module's formula, at one point, against the initial angles that end in the arc."""
    path, response = history(4), RESPONSES["ellipse"]
    motion = follow(path, response.shape_factor, isotropic_angles(COUNT))
    double = np.linspace(0.0, 2.0, 60)
    found = shares.alignment(motion.deformation, double)
    assert found.along**2 + found.across**2 + found.spread**2 == pytest.approx(1.0, abs=1e-12)
    middle, half = 1.1, 0.4
    real = np.cos(half) - found.along * np.cos(middle) - found.across * np.sin(middle)
    share = np.arctan2(found.spread * np.sin(half), real) / np.pi
    phase = double - 2.0 * motion.angle
    away = np.abs(np.mod(phase - middle + np.pi, 2.0 * np.pi) - np.pi)
    assert np.mean(away < half, axis=0) == pytest.approx(share, abs=1.0 / COUNT + 1e-12)


def test_roots_stay_in_their_brackets() -> None:
    goal = np.array([0.001, 0.2, 0.5, 0.9])
    kink = bracketed_roots(
        lambda x, at: np.where(x < 0.3, 0.1 * x, 0.03 + 5.0 * (x - 0.3)) - goal[at],
        np.zeros(4),
        np.ones(4),
        (-goal, 3.53 - goal),
        1e-12,
    )
    exact = np.where(goal < 0.03, goal / 0.1, 0.3 + (goal - 0.03) / 5.0)
    assert kink == pytest.approx(exact, abs=1e-12)
    smooth = bracketed_roots(
        lambda x, at: x**3 - goal[at],
        np.zeros(4),
        np.ones(4),
        (-goal, 1.0 - goal),
        1e-9,
        smooth=True,
    )
    assert smooth == pytest.approx(np.cbrt(goal), abs=1e-9)


def test_roots_of_functions_that_do_not_cross() -> None:
    low, high = np.zeros(3), np.ones(3)
    # zero up to a half; positive throughout; negative throughout
    ends = np.array([0.0, 1.0, -2.0]), np.array([0.5, 2.0, -1.0])
    found = bracketed_roots(
        lambda x, at: np.choose(at, [np.maximum(x - 0.5, 0.0), 1.0 + x, x - 2.0]),
        low,
        high,
        ends,
        1e-9,
    )
    assert found == pytest.approx([0.5, 0.0, 1.0], abs=1e-9)


def test_arcs_that_run_over_the_half_turn() -> None:
    """Two problems: overlapping arcs with one over the end, and no arc at all."""
    begin, end = np.array([0.5, 0.7, 3.0]), np.array([1.0, 1.2, 3.3])
    gaps = unions._gaps(begin, end, np.array([0, 0, 0]), 2)
    over = 3.3 - np.pi
    assert gaps == pytest.approx([(0.5 - over) + (3.0 - 1.2), np.pi], abs=1e-12)
