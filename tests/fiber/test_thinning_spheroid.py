"""A spheroid of a thinning melt by the shipped table: limits, symmetries, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Spheroid,
    embed_planar,
    follow,
    paper_angles,
    surface_pressure,
    unbounded_spheroid,
    unbounded_thinning_spheroid,
)
from fibermelt.fiber.thinning_spheroid import spheroid_table, tip_rate
from fibermelt.history import FlowHistory
from fibermelt.melt import CarreauYasuda, Cross, Newtonian, PowerLaw

PHASES = np.linspace(0.0, 2.0 * np.pi, 41)


@pytest.mark.parametrize("aspect_ratio", [1.0, 3.3, 20.0])
def test_index_one_is_the_closed_form(aspect_ratio: float) -> None:
    fiber = Spheroid(42e-6, aspect_ratio)
    found, exact = unbounded_thinning_spheroid(fiber, Newtonian(817.0)), unbounded_spheroid(fiber)
    c, s = np.cos(PHASES), np.sin(PHASES)
    strain = embed_planar(np.moveaxis(np.array([[c, s], [s, -c]]), -1, 0))
    lowest, _ = exact.extreme_values(strain, [1.0, 0.0, 0.0])
    # linear between the knots of the phase
    assert found.lowest_at(1.0, PHASES) == pytest.approx(lowest, rel=2e-5)
    tip = exact.tip(strain, [1.0, 0.0, 0.0])
    assert found.tip_at(1.0, PHASES) == pytest.approx(tip, abs=1e-5 * np.max(tip))
    assert found.omega(1.0, PHASES) == pytest.approx(exact.shape_factor * s, abs=1e-12)
    assert (found.spin_error, found.pressure_error) == (0.0, 0.0)


def test_points_of_the_table_are_met() -> None:
    table, exact = spheroid_table(), unbounded_spheroid(Spheroid(1.0, 4.0))
    column = int(np.flatnonzero(table.aspect_ratio == 4.0)[0])
    found = unbounded_thinning_spheroid(Spheroid(1.0, 4.0), PowerLaw(8213.0, 0.5))
    ratio = table.values["lowest"][2, column] / table.values["lowest"][4, column]
    newtonian = unbounded_thinning_spheroid(Spheroid(1.0, 4.0), Newtonian(1.0))
    expected = ratio * newtonian.lowest_at(1.0, table.phase)
    assert found.lowest_at(7.0, table.phase) == pytest.approx(expected, rel=1e-5)
    change = table.values["spin"][2, column] - table.values["spin"][4, column]
    expected = exact.shape_factor * np.sin(table.phase) + change
    # terms below `SPIN_ROUNDING` are dropped
    assert found.omega(7.0, table.phase) == pytest.approx(expected, abs=5e-6)


def test_a_sphere_turns_with_the_melt_and_sees_no_direction() -> None:
    found = unbounded_thinning_spheroid(Spheroid(1.0, 1.0), PowerLaw(1.0, 0.35))
    assert np.max(np.abs(found.omega(1.0, PHASES))) <= found.spin_error
    lowest = found.lowest_at(1.0, PHASES)
    assert np.ptp(lowest) < 2.0 * found.pressure_error * found.largest[0]


def test_a_melt_that_bends_goes_from_one_power_law_to_the_other() -> None:
    fiber, law = Spheroid(1.0, 6.0), CarreauYasuda(10390.0, 0.35, 0.5)
    found = unbounded_thinning_spheroid(fiber, law)
    newtonian = unbounded_thinning_spheroid(fiber, Newtonian(1.0))
    steep = unbounded_thinning_spheroid(fiber, PowerLaw(1.0, 0.35))
    for rate, limit in ((1e-5, newtonian), (1e5, steep)):
        # what `bending_rates` leaves, an index 0.03 from its limit
        assert found.lowest_at(rate, PHASES) == pytest.approx(
            limit.lowest_at(1.0, PHASES), rel=0.05
        )
    middle = found.lowest_at(np.geomspace(0.1, 10.0, 40), 0.0)
    assert np.all(np.diff(middle) > 0)
    assert found.pressure_error > steep.pressure_error > 0


def test_the_highest_shear_rate_on_a_sphere() -> None:
    # Sigma = 5 D: 2.5 times the far field's rate
    assert tip_rate(np.array(-5.0), np.array(5.0)) == pytest.approx(2.5 * 2.0 / 3.0)


def test_errors_are_small_and_known_everywhere() -> None:
    errors = spheroid_table().errors
    assert np.max(errors["spin"]) < 2e-3
    # a sphere's directions differ by 2 % at the lowest index, where r_e = 20 bends most, too
    assert max(np.max(errors["lowest"]), np.max(errors["highest"])) < 0.03
    assert np.max(errors["lowest"][2:]) < 0.015
    for part in errors.values():
        assert np.all(part[:-1] > 0)
        assert np.all(part[-1] == 0)


def test_a_path_is_followed() -> None:
    t = np.linspace(0.0, 20.0, 400)
    gradient = np.zeros((t.size, 2, 2))
    gradient[:, 0, 1] = 5.0
    zero = np.zeros((t.size, 2))
    path = FlowHistory(t, zero, zero + 1.0, gradient, t)
    law = PowerLaw(8213.0, 0.5)
    found = unbounded_thinning_spheroid(Spheroid(1.0, 6.0), law)
    motion = follow(path, found, paper_angles())
    pressure = surface_pressure(path, found, law, motion)
    # never below the worst direction's
    worst = np.min(found.bounds(5.0)[0]) * law.viscosity_at(5.0) * 2.5
    assert np.min(pressure.lowest) >= worst * (1.0 + 1e-6)
    assert np.min(pressure.lowest) < 0.9 * worst


@pytest.mark.parametrize("aspect_ratio", [0.5, 30.0])
def test_a_fiber_off_the_table_is_refused(aspect_ratio: float) -> None:
    with pytest.raises(ConfigError, match=f"aspect_ratio = {aspect_ratio:g}: the table"):
        unbounded_thinning_spheroid(Spheroid(1.0, aspect_ratio), Newtonian(1.0))


def test_a_melt_off_the_table_is_refused() -> None:
    fiber = Spheroid(1.0, 6.0)
    for index in (0.2, 1.2):
        with pytest.raises(ConfigError, match=f"is {index:g}: the table .* 0.25 to 1"):
            unbounded_thinning_spheroid(fiber, PowerLaw(1.0, index))
    steep = CarreauYasuda(10390.0, 0.2, 0.5)
    with pytest.raises(ConfigError, match=r"give rates = \(lowest, highest\)"):
        unbounded_thinning_spheroid(fiber, steep)
    found = unbounded_thinning_spheroid(fiber, steep, (0.01, 0.5))
    with pytest.raises(ConfigError, match="table holds"):
        found.lowest_at(50.0, 0.0)
    with pytest.raises(ConfigError, match="must be positive and not fall"):
        unbounded_thinning_spheroid(fiber, Cross(4628.0, 0.2694, 30820.0), (3.0, 1.0))
