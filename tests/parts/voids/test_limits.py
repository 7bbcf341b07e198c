"""Speeds and moistures that let a nucleus grow alike."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.parts.melt.cards import load_card
from fibermelt.parts.voids.limits import SPEEDS, WIDER, excess_at, joint_limits
from fibermelt.parts.voids.melt import moist_melt
from fibermelt.voids import ATMOSPHERE, growth_exponent

TIME = np.stack([np.linspace(0.0, 2.0, 4001), np.linspace(0.0, 3.0, 4001)])
PHASE = np.array([0.0, 1.0, 2.0])
PRESSURE = 3e4 * np.cos(3.0 * TIME[:, None, :] + PHASE[:, None])
VISCOSITY = np.full_like(TIME, 800.0)
UNTIL = np.array([2.0, 2.5])


def mean_exponent(excess: float, speed: float, power: float) -> float:
    """Return the mean exponent of the flow at other speeds, path by path."""
    found = growth_exponent(
        TIME[:, None, :] / speed,
        ATMOSPHERE + PRESSURE * speed**power,
        ATMOSPHERE + excess,
        VISCOSITY[:, None, :] * speed ** (power - 1.0),
        UNTIL[:, None] / speed,
    )
    return float(found.value.mean())


@pytest.mark.parametrize("target", [0.05, np.log(2.0), 3.0, 1e3])
def test_the_excess_is_where_the_exponent_is_the_target(target: float) -> None:
    found = excess_at(target, TIME, PRESSURE, VISCOSITY, UNTIL)
    # The trapezoidal rule on 4001 points, of second order at the kinks, too.
    assert mean_exponent(found, 1.0, 1.0) == pytest.approx(target, rel=1e-4)


@pytest.mark.parametrize("power", [1.0, 0.4])
@pytest.mark.parametrize("place", [0, 12, 30])
def test_a_flow_at_another_speed_has_the_exponent_of_its_curve(power: float, place: int) -> None:
    """Held against the exponent of the scaled flow itself: times, pressures and viscosities."""
    melt = moist_melt(load_card("paper"), 1e-3)
    limits = joint_limits(TIME, PRESSURE, VISCOSITY, UNTIL, melt, power)
    speed = SPEEDS[place]
    for wider, moistures in zip(WIDER, limits["void_limit_moisture"], strict=True):
        moisture = moistures[place]
        assert 0.0 < moisture < 5e-3
        vapor = float(melt.card.melt.vapor_pressure(moisture, melt.temperature))
        found = mean_exponent(vapor - ATMOSPHERE, speed, power)
        assert found == pytest.approx(np.log(wider), rel=1e-4)


def test_a_melt_that_follows_no_power_has_no_curve() -> None:
    melt = moist_melt(load_card("paper"), 1e-3)
    assert joint_limits(TIME, PRESSURE, VISCOSITY, UNTIL, melt, float("nan")) == {}


def test_a_melt_under_tension_has_no_moisture_left() -> None:
    """Ten times the pressures: at these speeds only a vapor below nothing would do."""
    melt = moist_melt(load_card("paper"), 1e-3)
    strained = PRESSURE - 5e6
    limits = joint_limits(TIME, strained, VISCOSITY, UNTIL, melt, 1.0)
    assert (limits["void_limit_moisture"][:, -1] == 0.0).all()
    # At the least speed the air's pressure carries most of it.
    slow = limits["void_limit_moisture"][:, 0]
    assert (slow <= 2e-4).all()
