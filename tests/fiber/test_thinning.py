"""A fiber of a thinning melt by its table: against the linear fiber, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Ellipse,
    LocalViscosity,
    ThinningResponse,
    follow,
    isotropic_pressure,
    orbit,
    paper_angles,
    pressure_bounds,
    surface_pressure,
    unbounded_ellipse,
)
from fibermelt.fiber.thinning import BLOCK
from fibermelt.fiber.thinning_motion import DIRECTIONS, FEWEST, TABLE_TOLERANCE, _turning
from fibermelt.history import FlowHistory
from fibermelt.melt import CarreauYasuda, Newtonian

LINEAR = unbounded_ellipse(Ellipse(1.0, 6.0))
MELT = Newtonian(817.0)
THINS = CarreauYasuda(10390.0, 0.35, 0.5)


def table(points: int = 257) -> ThinningResponse:
    """Return the closed form of an unbounded ellipse as a table."""
    phase = np.linspace(0.0, 0.5 * np.pi, points)
    low, high = LINEAR.support.both(phase)
    tip = LINEAR.tip[0] * np.cos(phase) + LINEAR.tip[1] * np.sin(phase)
    spin = LINEAR.shape_factor * np.sin(phase)
    rows = (spin[None], low[None], high[None], tip[None])
    return ThinningResponse.from_extremes(6.0, MELT, np.ones(1), *rows)


def history(points: int = 300, strength: float = 1.0) -> FlowHistory:
    """Return a path on which stretch, shear and vorticity change."""
    t = np.linspace(0.0, 3.0, points)
    gradient = np.zeros((points, 2, 2))
    gradient[:, 0, 0] = np.sin(3.0 * t)
    gradient[:, 1, 1] = -gradient[:, 0, 0]
    gradient[:, 0, 1] = 5.0 * np.cos(t)
    gradient[:, 1, 0] = -3.0 * np.sin(2.0 * t)
    zero = np.zeros((points, 2))
    return FlowHistory(t, zero, zero + 1.0, strength * gradient, t)


def test_a_newtonian_table_is_the_linear_fiber() -> None:
    path, found = history(), table()
    linear = follow(path, LINEAR.shape_factor, paper_angles())
    motion = follow(path, found, paper_angles())
    assert np.max(np.abs(motion.angle - linear.angle)) < TABLE_TOLERANCE
    assert np.max(np.abs(motion.spin - linear.spin)) < 1e-5
    exact = surface_pressure(path, LINEAR, 817.0, linear)
    pressure = surface_pressure(path, found, MELT, motion)
    largest = np.max(-exact.lowest)
    # linear between the table's knots
    assert np.max(np.abs(pressure.lowest - exact.lowest)) < 1e-5 * largest
    assert np.max(np.abs(pressure.highest - exact.highest)) < 1e-5 * largest
    assert np.max(np.abs(pressure.tip - exact.tip)) < 1e-5 * largest
    bounds = pressure_bounds(path, found, MELT)
    expected = pressure_bounds(path, LINEAR, 817.0)
    for name in ("lowest", "highest", "mildest_lowest", "mildest_highest"):
        gap = getattr(bounds, name) - getattr(expected, name)
        assert np.max(np.abs(gap)) < 1e-5 * largest, name


@pytest.mark.parametrize("strength", [1.0, 6.0])
def test_steep_intervals_are_integrated_for_the_fibers_themselves(strength: float) -> None:
    path, found = history(12, strength), table()
    assert np.any(_turning(path, found, TABLE_TOLERANCE).steep) == (strength == 6.0)
    angles = np.linspace(-7.0, 9.0, 33)  # more than a turn
    motion = follow(path, found, angles)
    linear = follow(path, LINEAR.shape_factor, angles)
    assert np.max(np.abs(motion.angle - linear.angle)) < TABLE_TOLERANCE


def test_intervals_take_as_many_directions_as_they_need() -> None:
    # of a melt with one term an interval's function has few harmonics; a longer one has more
    counts = []
    for points in (3000, 300, 60):
        spectrum = np.abs(_turning(history(points), table(), TABLE_TOLERANCE).spectrum)
        counts.append(int(np.count_nonzero(spectrum.max(axis=(0, 1)))))
    assert counts[0] == FEWEST // 2 < counts[-1] <= DIRECTIONS // 2
    assert counts == sorted(counts)


def test_quantiles_are_those_of_the_linear_response() -> None:
    path = history()
    found = isotropic_pressure(path, table(), MELT, None)
    linear = isotropic_pressure(path, LINEAR, 817.0, None)
    for name in ("lowest", "highest", "extremes"):
        values = getattr(linear, name)
        assert getattr(found, name) == pytest.approx(values, abs=1e-4 * np.max(np.abs(values)))


def test_both_pressures_are_read_at_one_place() -> None:
    one = table()
    grown = np.array([[1.0], [1.5], [2.5]])  # rows that differ, and no symmetry of their own
    rows = [grown * part[:, ::4] for part in (one.lowest, one.highest, one.tip)]
    found = ThinningResponse.from_extremes(
        6.0, THINS, np.array([1.0, 10.0, 100.0]), grown * np.zeros(rows[0].shape[1]), *rows
    )
    rate = np.geomspace(1.0, 99.0, 2 * 300).reshape(2, 300)
    phase = np.linspace(-9.0, 9.0, 2 * 70 * 300).reshape(2, 70, 300)  # more than are read at a time
    low, high = found.both_at(rate, phase)
    assert phase[0].size > BLOCK
    for values, at, sign in ((low, phase, 1.0), (high, phase + np.pi, -1.0)):
        expected = sign * found.lowest_at(rate[:, None], at)
        # a phase of 12 is rounded to 1e-15, a pressure rises by 10 a radian
        assert np.max(np.abs(values - expected)) < 1e-12


def test_a_few_directions_are_enough_for_a_table() -> None:
    # lowest and highest pressure are one smooth function over half a turn
    coarse, fine, phase = table(13), table(257), np.linspace(0.0, 2.0 * np.pi, 301)
    gap = np.abs(coarse.lowest_at(1.0, phase) - fine.lowest_at(1.0, phase))
    assert np.max(gap) < 6e-5 * fine.largest[0]


def test_an_orbit_is_jefferys() -> None:
    exact, found = orbit(LINEAR, 2.0, 817.0), orbit(table(), 2.0, MELT)
    assert exact.period is not None
    assert found.period == pytest.approx(exact.period, rel=1e-10)
    assert found.min_pressure == pytest.approx(exact.min_pressure, rel=1e-5)
    assert found.angle_at_min == pytest.approx(exact.angle_at_min, abs=1e-3)


def test_a_thinning_melt_has_to_be_named() -> None:
    path = history()
    motion = follow(path, LINEAR.shape_factor, paper_angles())
    with pytest.raises(ConfigError, match="LocalViscosity"):
        surface_pressure(path, LINEAR, THINS, motion)
    with pytest.raises(ConfigError, match="table is of"):
        surface_pressure(path, table(), THINS, motion)
    local = surface_pressure(path, LINEAR, LocalViscosity(THINS), motion)
    unit = surface_pressure(path, LINEAR, 1.0, motion)
    assert np.array_equal(local.lowest / unit.lowest > 0, np.ones_like(unit.lowest, dtype=bool))
    ratio = THINS.viscosity_at(path.shear_rate)
    assert np.allclose(local.lowest, ratio * unit.lowest, rtol=1e-12)
    law = surface_pressure(path, LINEAR, MELT, motion)
    assert np.array_equal(law.lowest, surface_pressure(path, LINEAR, 817.0, motion).lowest)


def test_a_table_is_stored_and_read() -> None:
    found = table()
    again = ThinningResponse.from_arrays(MELT, found.to_arrays())
    assert np.array_equal(
        again.lowest_at(1.0, np.arange(9.0)), found.lowest_at(1.0, np.arange(9.0))
    )
