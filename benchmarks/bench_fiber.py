"""Every closed form of the fiber against the paper's own algorithm, and the cell's cost.

A fiber-step is a fiber's director, the lowest and the highest pressure on its surface, and where
they are, at one point of one streamline. Run on one core: ``OMP_NUM_THREADS=1``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import fibermelt as fm
from fibermelt.fiber import (
    CellNumerics,
    Ellipsoid,
    FiberModel,
    Spheroid,
    build_system,
    confined_model,
    even_frames,
    follow_directors,
    follow_ellipsoids,
    follow_newton,
    unbounded_ellipsoid,
    unbounded_model,
    unbounded_spheroid,
)
from fibermelt.fiber.spatial import follow_spatial, half_sphere, spatial_pressure
from fibermelt.flow.streamlines import Streamline
from timing import seconds

FIBER = fm.Ellipse(half_length=42e-6, aspect_ratio=6.0)
MU = 817.0
DOMAIN_SIZE = 4.0
TRIAXIAL = (6.0, 2.0, 1.0)
"""Semi-axes of an ellipsoid, three different ones."""

NEWTON_STEPS = 300
"""Steps of the paper's algorithm that are timed; its cost is the same at every step."""

FORMS = (
    "confined-ellipse",
    "ellipse",
    "spheroid in the plane",
    "spheroid in planar flow",
    "spheroid in any flow",
    "ellipsoid",
)


@pytest.fixture(scope="module")
def path(lines: tuple[Streamline, ...]) -> fm.FlowHistory:
    return fm.FlowHistory.stack([line.history for line in lines])


@pytest.fixture(scope="module")
def newton_rate(lines: tuple[Streamline, ...]) -> float:
    """Return the fiber-steps per second of the paper's algorithm.

    On the paper's own mesh, its matrix factorised once by the fastest solver at hand.
    """
    history, part = lines[9].history, slice(0, NEWTON_STEPS + 1)
    short = fm.FlowHistory(
        history.time[part],
        history.position[part],
        history.velocity[part],
        history.gradient[part],
        history.pressure[part],
    )
    system = build_system(FIBER, DOMAIN_SIZE, CellNumerics(mesh="paper"))
    return NEWTON_STEPS / seconds(lambda: follow_newton(system, FIBER, short, MU, 0.3))


def in_the_plane(model: FiberModel, path: fm.FlowHistory) -> object:
    """Follow the paper's 13 fibers, and find both extremes and their places at every point."""
    motion = fm.follow(path, model.response.shape_factor, fm.paper_angles())
    pressure = fm.surface_pressure(path, model.response, MU, motion)
    return pressure.lowest, pressure.highest, pressure.where_lowest, pressure.where_highest


def work(form: str, path: fm.FlowHistory) -> tuple[Callable[[], object], int]:
    """Return what is timed and the fibers on each streamline; what is solved once is not timed."""
    count = fm.paper_angles().size
    if form == "confined-ellipse":
        model = confined_model(fm.solve_cell(FIBER, DOMAIN_SIZE).response)
        return lambda: in_the_plane(model, path), count
    if form in ("ellipse", "spheroid in the plane"):
        plane = unbounded_model("ellipse" if form == "ellipse" else "spheroid", FIBER)
        return lambda: in_the_plane(plane, path), count
    response = unbounded_spheroid(Spheroid(FIBER.half_length, FIBER.aspect_ratio))
    factor, start = response.shape_factor, half_sphere(count)
    if form == "spheroid in planar flow":
        return lambda: [
            spatial_pressure(one, response, MU, follow_spatial(one, factor, start))
            for one in path.lines
        ], count
    gradient = path.gradient[..., None, :, :, :]
    if form == "spheroid in any flow":

        def directors() -> object:
            motion = follow_directors(path, factor, start)
            return response.extremes(gradient, motion.direction)

        return directors, count
    ellipsoid, frames = unbounded_ellipsoid(Ellipsoid(TRIAXIAL)), even_frames(count)

    def triaxial() -> object:
        motion = follow_ellipsoids(path, ellipsoid, frames)
        return ellipsoid.turned_extremes(gradient, motion.direction, motion.second)

    return triaxial, count


@pytest.mark.parametrize("form", FORMS)
def test_fiber_steps(
    benchmark: BenchmarkFixture, path: fm.FlowHistory, newton_rate: float, form: str
) -> None:
    """Fiber-steps per second of a closed form, the paper's algorithm beside it in the same run."""
    action, count = work(form, path)
    benchmark(action)
    steps = path.time.size * count
    rate = steps / benchmark.stats["median"]
    benchmark.extra_info |= {"steps": steps, "steps_per_second": rate}
    benchmark.extra_info |= {"newton_steps_per_second": newton_rate, "ratio": rate / newton_rate}
    print(
        f"\n{form}: {rate / 1e6:.2f} million fiber-steps/s, the paper's algorithm "
        f"{newton_rate:,.0f}/s: {rate / newton_rate:,.0f} times"
    )


def test_fiber_stage_against_the_papers_algorithm(
    benchmark: BenchmarkFixture,
    lines: tuple[Streamline, ...],
    path: fm.FlowHistory,
    newton_rate: float,
) -> None:
    """The chain's own: 22 x 13 trajectories, extremes at both locations, and where they are."""
    zones = np.array([line.zone_time for line in lines])
    cell = fm.solve_cell(FIBER, domain_size=DOMAIN_SIZE)
    angles = fm.paper_angles()

    def stage() -> object:
        motion = fm.follow(path, cell.shape_factor, angles)
        pressure = fm.surface_pressure(path, cell.response, MU, motion)
        return fm.extremes(path, pressure, motion, zones), pressure.where_lowest

    benchmark(stage)
    steps = path.time.size * angles.size
    scaled = steps / newton_rate
    ratio = scaled / benchmark.stats["median"]
    benchmark.extra_info |= {"steps": steps, "newton_scaled_s": scaled, "times_faster": ratio}
    print(f"\nfiber stage: {steps} steps, {ratio:,.0f} times faster than the paper's algorithm")


@pytest.mark.parametrize("estimate", [False, True])
def test_cell(benchmark: BenchmarkFixture, estimate: bool) -> None:
    """The cell's two solutions, without and with the error estimate."""
    numerics = CellNumerics(estimate=estimate)
    benchmark(lambda: fm.solve_cell(FIBER, DOMAIN_SIZE, numerics))


ENTRIES = 2000
"""Solves by a system's factors, a millisecond each: the shortest stay in the finite elements."""


def test_one_thread_is_not_slowed_by_the_lock(benchmark: BenchmarkFixture) -> None:
    """Solves that enter through the lock against the same without it, in turns, best of five."""
    system = build_system(FIBER, DOMAIN_SIZE, CellNumerics(order=3))
    load, plain = np.ones(system.free.size), system.solve.__wrapped__  # type: ignore[attr-defined]

    def cost(solve: Callable[[np.ndarray], np.ndarray]) -> float:
        return seconds(lambda: [solve(load) for _ in range(ENTRIES)])

    pairs = benchmark.pedantic(lambda: [(cost(system.solve), cost(plain)) for _ in range(5)])
    ratio = min(locked for locked, _ in pairs) / min(free for _, free in pairs)
    benchmark.extra_info["locked over plain"] = ratio
    assert ratio < 1.05  # a lock takes 1e-4 of a solve; the rest is what a busy machine adds
