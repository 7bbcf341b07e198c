"""What holds for every model of the fiber, whatever the flow: held against random flows.

The confined cell, the unbounded ellipse and the spheroid in the plane through the whole of
`follow`, `surface_pressure` and `extremes`; the triaxial ellipsoid through its field.
"""

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.fiber import (
    CellNumerics,
    Ellipse,
    Ellipsoid,
    Extremes,
    FiberModel,
    Motion,
    SurfacePressure,
    confined_model,
    ellipsoid_field,
    extremes,
    follow,
    jeffery_period,
    orbit,
    solve_cell,
    surface_pressure,
    unbounded_ellipsoid,
    unbounded_model,
)
from fibermelt.fiber.orbit import tumbling_period
from fibermelt.history import FlowHistory, simple_shear

pytestmark = pytest.mark.verification

FEW = examples(15)
FIBER = Ellipse(1.0, 6.0)
MU = 817.0
POINTS = 60
ZONES = np.array([0.3, 0.5, 0.9])
TABLE = 1e-7
"""Share of the largest pressure by which a table of a support function may be off: its own
tolerance is 1e-8, an extreme may come from either side of a node."""
ANGLE = 1e-7
"""[rad]: `follow` keeps 1e-8 over a path on either side of a comparison, and a flow that spreads
directions apart stretches what is left."""
EXACT = 1e-11
"""Rounding, times the aspect ratio squared."""

seeds = st.integers(0, 2**32 - 1)
turns = st.floats(-np.pi, np.pi)
factors = st.floats(0.1, 30.0)
MODELS = ("confined-ellipse", "ellipse", "spheroid")


@pytest.fixture(scope="module")
def models() -> dict[str, FiberModel]:
    """Three models; the cell is large enough for the confined fiber to tumble."""
    cell = solve_cell(FIBER, 20.0, CellNumerics(order=4, estimate=False))
    unbounded = [unbounded_model("ellipse", FIBER), unbounded_model("spheroid", FIBER)]
    return {model.name: model for model in [confined_model(cell.response), *unbounded]}


def history(time: np.ndarray, velocity: np.ndarray, L: np.ndarray) -> FlowHistory:
    position = np.zeros_like(velocity)
    return FlowHistory(time, position, velocity, L, np.zeros_like(time))


def wandering(seed: int) -> FlowHistory:
    """Smooth random gradients of a few units, over a time of one."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, POINTS)
    waves = np.sin(np.outer(t, rng.uniform(0.0, 6.0, 3)) + rng.uniform(0.0, 6.0, 3))
    a, b, c = (waves * rng.normal(0.0, 3.0, 3)).T
    L = np.stack([np.stack([a, b], axis=-1), np.stack([c, -a], axis=-1)], axis=-2)
    velocity = np.stack([1.0 + 0.2 * t, 0.3 * np.cos(t)], axis=-1)
    return history(t, velocity, L)


def chain(
    model: FiberModel,
    path: FlowHistory,
    angles: np.ndarray,
    mu: float = MU,
    zones: np.ndarray = ZONES,
) -> tuple[Motion, SurfacePressure, Extremes]:
    motion = follow(path, model.response.shape_factor, angles)
    pressure = surface_pressure(path, model.response, mu, motion)
    return motion, pressure, extremes(path, pressure, motion, zones)


def starts(seed: int) -> np.ndarray:
    return np.random.default_rng(seed + 1).uniform(-np.pi, np.pi, 5)


def assert_same_pressure(one: SurfacePressure, other: SurfacePressure, factor: float = 1.0) -> None:
    """Compare, with what the angle's tolerance does to the pressure of a tip of curvature r_e^2."""
    scale = factor * np.abs(one.highest).max() * (TABLE + 36.0 * ANGLE)
    assert other.lowest == pytest.approx(factor * one.lowest, abs=scale)
    assert other.highest == pytest.approx(factor * one.highest, abs=scale)


@FEW
@pytest.mark.parametrize("name", MODELS)
@given(seed=seeds, turn=turns)
def test_frame_indifference(
    models: dict[str, FiberModel], name: str, seed: int, turn: float
) -> None:
    """Flow and fibers turned together: the same pressures at the same places."""
    model, path, angles = models[name], wandering(seed), starts(seed)
    c, s = np.cos(turn), np.sin(turn)
    Q = np.array([[c, -s], [s, c]])
    turned = history(path.time, path.velocity[:, :2] @ Q.T, Q @ path.plane_gradient @ Q.T)
    motion, pressure, found = chain(model, path, angles)
    motion2, pressure2, found2 = chain(model, turned, angles + turn)
    assert motion2.angle - turn == pytest.approx(motion.angle, abs=ANGLE)
    assert_same_pressure(pressure, pressure2)
    same = found2.index == found.index  # ties between neighbours go either way
    assert np.mean(same) > 0.5
    turned_by = found2.angle[same] - found.angle[same]
    assert np.sin(turned_by) == pytest.approx(0.0, abs=ANGLE)  # modulo the fiber's half turn


@FEW
@pytest.mark.parametrize("name", MODELS)
@given(seed=seeds, factor=factors)
def test_pressures_are_linear_in_viscosity(
    models: dict[str, FiberModel], name: str, seed: int, factor: float
) -> None:
    model, path, angles = models[name], wandering(seed), starts(seed)
    motion, pressure, found = chain(model, path, angles)
    motion2, pressure2, found2 = chain(model, path, angles, factor * MU)
    assert np.array_equal(motion2.angle, motion.angle)
    assert pressure2.lowest == pytest.approx(factor * pressure.lowest, rel=1e-14)
    assert pressure2.highest == pytest.approx(factor * pressure.highest, rel=1e-14)
    assert found2.value == pytest.approx(factor * found.value, rel=1e-14)


@FEW
@pytest.mark.parametrize("name", MODELS)
@given(seed=seeds, factor=factors)
def test_a_faster_flow_is_the_same_in_less_time(
    models: dict[str, FiberModel], name: str, seed: int, factor: float
) -> None:
    """Linear in ``L``: over the same strain the angles are the same, the pressures in ratio."""
    model, path, angles = models[name], wandering(seed), starts(seed)
    fast = history(path.time / factor, factor * path.velocity, factor * path.gradient)
    motion, pressure, _ = chain(model, path, angles)
    motion2, pressure2, _ = chain(model, fast, angles, zones=ZONES / factor)
    assert motion2.angle == pytest.approx(motion.angle, abs=ANGLE)
    assert motion2.spin == pytest.approx(
        factor * motion.spin, abs=factor * 100.0 * ANGLE * np.abs(path.gradient).max()
    )
    assert_same_pressure(pressure, pressure2, factor)


@FEW
@pytest.mark.parametrize("name", MODELS)
@given(seed=seeds)
def test_both_ends_are_alike(models: dict[str, FiberModel], name: str, seed: int) -> None:
    model, path, angles = models[name], wandering(seed), starts(seed)
    motion, pressure, found = chain(model, path, angles)
    motion2, pressure2, found2 = chain(model, path, angles + np.pi)
    assert motion2.angle - np.pi == pytest.approx(motion.angle, abs=1e-10)  # the same maps
    scale = EXACT * np.abs(pressure.highest).max() * 36.0
    assert pressure2.lowest == pytest.approx(pressure.lowest, abs=scale)
    assert pressure2.highest == pytest.approx(pressure.highest, abs=scale)
    assert found2.value == pytest.approx(found.value, abs=scale)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("start", [0.0, 0.4, -1.3])
def test_the_closed_orbit_returns(models: dict[str, FiberModel], name: str, start: float) -> None:
    """After a period the fiber has turned once, clockwise, and sees what it saw."""
    model = models[name]
    period = tumbling_period(model.response.shape_factor, 2.0)
    assert period is not None
    path = simple_shear(2.0, period, 400)
    motion = follow(path, model.response.shape_factor, np.array([start]))
    pressure = surface_pressure(path, model.response, MU, motion)
    assert motion.angle[0, -1] == pytest.approx(start - 2.0 * np.pi, abs=1e-8)
    scale = np.abs(pressure.highest).max() * TABLE
    assert pressure.lowest[0, -1] == pytest.approx(pressure.lowest[0, 0], abs=scale)
    turn = orbit(model.response, 2.0, MU)
    assert turn.period == period
    # 400 points of an orbit miss its extreme by less than the whole surface's bound allows
    assert pressure.lowest.min() >= turn.min_pressure * (1.0 + TABLE)
    assert pressure.lowest.min() == pytest.approx(turn.min_pressure, rel=1e-2)


@pytest.mark.parametrize("name", ["ellipse", "spheroid"])
@pytest.mark.parametrize("ratio", [1.0, 3.0, 6.0, 8.0, 10.0])
def test_periods_of_table_1_by_following_the_fiber(name: str, ratio: float) -> None:
    """In time, not by the formula: at ``T_Jef`` it has turned once, to 1e-8 of the period."""
    model = unbounded_model("ellipse" if name == "ellipse" else "spheroid", Ellipse(1.0, ratio))
    period = jeffery_period(ratio, 1.0)
    start = 0.5 * np.pi  # across the flow it turns fastest: an angle is a time there
    path = simple_shear(1.0, period, 400)
    motion = follow(path, model.response.shape_factor, np.array([start]), 1e-10)
    late = (start - 2.0 * np.pi - motion.angle[0, -1]) / motion.spin[0, -1]
    assert abs(late) <= 1e-8 * period


@FEW
@given(seed=seeds)
def test_an_ellipsoid_of_three_axes_in_any_frame(seed: int) -> None:
    """Velocity, pressure and spin turn with the flow; in ``L`` they are linear."""
    rng = np.random.default_rng(seed)
    body = Ellipsoid((3.0, 2.0, 1.0))
    one, two = (traceless(rng) for _ in range(2))
    Q, R = rotation(rng), rotation(rng)
    x = rng.normal(size=(20, 3))
    x *= (rng.uniform(3.1, 20.0, 20) / np.linalg.norm(x, axis=-1))[:, None]  # outside for sure
    here = ellipsoid_field(body, one, x, Q)
    there = ellipsoid_field(body, R @ one @ R.T, x @ R.T, R @ Q)
    scale = EXACT * np.linalg.norm(one) * 20.0
    assert there.velocity == pytest.approx(here.velocity @ R.T, abs=scale)
    assert there.pressure == pytest.approx(here.pressure, abs=scale)
    assert there.angular_velocity == pytest.approx(R @ here.angular_velocity, abs=scale)
    factor = float(rng.uniform(-3.0, 3.0))
    other = ellipsoid_field(body, two, x, Q)
    both = ellipsoid_field(body, one + factor * two, x, Q)
    scale = EXACT * (np.linalg.norm(one) + 3.0 * np.linalg.norm(two)) * 20.0
    assert both.velocity == pytest.approx(here.velocity + factor * other.velocity, abs=scale)
    assert both.pressure == pytest.approx(here.pressure + factor * other.pressure, abs=scale)


@FEW
@given(seed=seeds)
def test_half_a_turn_about_an_axis_of_an_ellipsoid(seed: int) -> None:
    """Changes nothing: the same extremes, at the places turned with it."""
    rng = np.random.default_rng(seed)
    response = unbounded_ellipsoid(Ellipsoid((3.0, 2.0, 1.0)))
    L = traceless(rng)
    here = response.extremes(L)
    scale = EXACT * np.abs(here.highest - here.lowest)
    for signs in ([1, -1, -1], [-1, 1, -1], [-1, -1, 1]):
        H = np.diag(np.array(signs, dtype=float))
        there = response.extremes(H @ L @ H)
        assert there.lowest == pytest.approx(here.lowest, abs=scale)
        assert there.highest == pytest.approx(here.highest, abs=scale)
        at = response.surface_pressure(L, H @ there.where_lowest)
        assert at == pytest.approx(here.lowest, abs=scale)


@FEW
@given(seed=seeds, power=st.floats(-200.0, 200.0), sign=st.sampled_from([-1.0, 1.0]))
def test_extremes_of_an_ellipsoid_scale_with_the_flow(seed: int, power: float, sign: float) -> None:
    """Over any range of rates: nothing vanishes or overflows on the way."""
    response = unbounded_ellipsoid(Ellipsoid((3.0, 2.0, 1.0)))
    factor = sign * 10.0**power
    L = traceless(np.random.default_rng(seed))
    here, there = response.extremes(L), response.extremes(factor * L)
    ends = sorted([sign * float(here.lowest), sign * float(here.highest)])
    scale = EXACT * np.abs(here.highest - here.lowest)
    found = [float(value) / abs(factor) for value in (there.lowest, there.highest)]
    assert found == pytest.approx(ends, abs=scale)


def traceless(rng: np.random.Generator) -> np.ndarray:
    L = rng.normal(size=(3, 3))
    return L - np.trace(L) / 3.0 * np.eye(3)


def rotation(rng: np.random.Generator) -> np.ndarray:
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return Q * np.sign(np.linalg.det(Q))
