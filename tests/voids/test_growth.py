"""Growth of bubbles: closed forms of each law, Scriven's limit, water, tips, monotonicity."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from fibermelt.errors import ConfigError, HistoryError
from fibermelt.fiber.ellipsoid import Ellipsoid
from fibermelt.fiber.ellipsoid_field import ellipsoid_field
from fibermelt.melt import CarreauYasuda, Newtonian, PowerLaw
from fibermelt.voids import growth
from fibermelt.voids.growth import (
    BubbleMelt,
    Surroundings,
    Tip,
    grow,
    viscous_resistance,
)

MU = 800.0
R_0 = 1e-6
PLENTY = BubbleMelt(3e5, 1.0, 1e-6, 0.0, 500.0)
"""So much water so near that the vapor pressure stays."""

VAST = 1e3
"""Volume of a cell without end [m3]."""

ABS = BubbleMelt(2.8e5, 1.9e-6, 2.3e-10, 0.024, 503.15)
"""About the paper's melt at 0.05 % moisture."""

CELL = 4.7e-14
"""Volume of melt at a fiber's tip [m3], about: 8 % of fibers 84 um long."""


def at_rest(melt, end, pressure=1e5, viscosity=MU, cell=VAST, tolerance=1e-6):
    """Return a nucleus at constant pressure."""
    around = Surroundings([0.0, end], [pressure, pressure], viscosity)
    return grow(around, melt, R_0, cell, [end], tolerance)


def test_constant_pressure_without_tension() -> None:
    """``R_0 exp(dp t/(4 mu))``."""
    found = at_rest(PLENTY, 0.02)
    expected = 2e5 * found.time / (4 * MU)
    assert np.log(found.radius / R_0) == pytest.approx(expected, abs=1e-6)


def test_the_cell_is_what_resists() -> None:
    """``R'/R = dp/(4 mu (1 - (R/S)^3))``: with ``V = R^3``, ``V/(V + C)`` grows like exp(3 ...)."""
    C = R_0**3
    melt = BubbleMelt(3e5, 1e6, 1e-6, 0.0, 500.0)
    found = at_rest(melt, 0.003, cell=4 / 3 * math.pi * C)
    share = 0.5 * np.exp(3 * 2e5 * found.time / (4 * MU))
    expected = np.log(share / (1 - share)) / 3
    assert expected[-1] > 0.6
    assert np.log(found.radius / R_0) == pytest.approx(expected, abs=1e-6)


def test_a_power_law_thins_around_the_bubble() -> None:
    """``(R'/R)^n = n dp/(4 K (2 sqrt 3)^(n-1))``."""
    K, n = 8213.0, 0.6
    law = PowerLaw(K, n, lowest_rate=1e-9)
    melt = BubbleMelt(3e5, 1.0, 1e-6, 0.0, 500.0, law)
    found = at_rest(melt, 0.02, viscosity=law.viscosity_at(0.0))
    rate = (n * 2e5 / (4 * K) * (2 * math.sqrt(3)) ** (1 - n)) ** (1 / n)
    assert np.log(found.radius / R_0) == pytest.approx(rate * found.time, abs=1e-6)


def test_gas_of_a_fixed_mass() -> None:
    """``V' = 3 (p_0 V_0 - p V)/(4 mu)``."""
    found = at_rest(BubbleMelt(3e5, 1.0, 0.0, 0.0, 500.0), 0.1, tolerance=1e-8)
    share = 3.0 - 2.0 * np.exp(-3 * 1e5 * found.time / (4 * MU))
    assert np.log(found.radius / R_0) == pytest.approx(np.log(share) / 3, abs=1e-6)
    assert found.vapor == pytest.approx(np.full(found.vapor.shape, found.vapor[0]), rel=1e-12)


def test_surface_tension_holds_what_is_smaller_than_critical() -> None:
    """``2 sigma/(P_V - p)``: 10 % below it nothing moves, 10 % above it grows."""
    melt = BubbleMelt(3e5, 1.0, 1e-6, 0.02, 500.0)
    critical = 2 * 0.02 / 2e5
    around = Surroundings([0.0, 1.0], [1e5, 1e5], MU)
    found = grow(around, melt, [0.9 * critical, 1.1 * critical], VAST, [0.1])
    assert found.radius[0] == pytest.approx(
        np.full(found.radius.shape[1], 0.9 * critical), rel=1e-12
    )
    assert found.radius[1, -1] > 2 * critical


def scriven(beta):
    """Return ``Ja`` of Scriven's constant, of a gas without mass against the melt."""
    inside, _ = quad(
        lambda s: s**-2 * math.exp(3 * beta**2 - s * s - 2 * beta**3 / s), beta, np.inf, epsabs=0
    )
    return 2 * beta**3 * inside


def driven_by_diffusion(beta, ratio, monkeypatch):
    """Return ``(R^2)'/(4 beta^2 D)`` of a bubble in a melt that resists nothing, once it is large.

    From ten to thirty times the nucleus; whatever the start was is then 1 % of ``R^2``, and no part
    of its rate.
    """
    monkeypatch.setattr(growth, "RATIO", ratio)
    D, p, gas = 1e-10, 1e5, BubbleMelt(0.0, 1.0, 0.0, 0.0, 500.0).gas
    k = 1e-5
    melt = BubbleMelt(p + scriven(beta) * p / gas / k, k, D, 0.0, 500.0)
    end = (30 * R_0) ** 2 / (4 * beta**2 * D)
    around = Surroundings([0.0, end], [p, p], 1e-9 * p * end)
    found = grow(around, melt, R_0, 1e-10, [end / 9, end], 1e-3)
    R, t = (found.at_stations(name) for name in ("radius", "time"))
    return (R[1] ** 2 - R[0] ** 2) / (t[1] - t[0]) / (4 * beta**2 * D)


@pytest.mark.parametrize("beta", [0.1, 1.0, 5.0])
def test_growth_by_diffusion_is_scrivens(beta, monkeypatch) -> None:
    """From steady layers (beta = 0.1) to thin ones (5, where ``beta = sqrt(3/pi) Ja``)."""
    coarse, fine = (
        abs(driven_by_diffusion(beta, ratio, monkeypatch) - 1)
        for ratio in (growth.RATIO, math.sqrt(growth.RATIO))
    )
    # Second order in the logarithm of the shells' ratio, which halves: a factor of 4.
    assert coarse < 0.1
    assert fine < 0.4 * coarse


def dipping(nuclei=R_0, deepest=0.0, melt=ABS, viscosity=MU):
    """Return nuclei in a melt whose pressure falls to the deepest, comes back, and stays."""
    t = np.linspace(0.0, 0.2, 40)
    p = 3e5 + (deepest - 3e5) * np.exp(-(((t - 0.1) / 0.03) ** 2))
    return grow(Surroundings(t, p, viscosity), melt, nuclei, CELL, [0.1, 0.2, 1.0])


def test_water_is_neither_made_nor_lost() -> None:
    found = dipping(np.geomspace(3e-7, 5e-6, 5), -2e5)
    water = found.vapor + found.dissolved
    assert np.ptp(found.radius, axis=-1).min() > 0.0
    assert np.abs(water / water[:, :1] - 1.0).max() < 1e-10


def test_what_has_grown_dissolves_and_stays_in_its_crevice() -> None:
    t = [0.0, 0.1, 0.11, 5.0]
    found = grow(Surroundings(t, [-1e5, -1e5, 1e6, 1e6], MU), ABS, R_0, CELL, [0.1, 5.0])
    grown, left = found.at_stations("radius")
    assert grown > 10 * R_0
    assert left == pytest.approx(R_0, rel=1e-12)
    # In its crevice the vapor is in balance again with the melt, which has back what it gave.
    held = found.vapor[-1] * ABS.gas / (4 / 3 * math.pi * R_0**3)
    assert held == pytest.approx(ABS.vapor_pressure, rel=1e-3)


@examples(5)
@given(deepest=st.floats(-2e5, 1e5), more=st.floats(0.0, 0.5), thinner=st.floats(0.3, 1.0))
def test_more_moisture_less_viscosity_and_larger_nuclei_grow_more(deepest, more, thinner) -> None:
    """Until the pressure comes back: then what is thinner shrinks faster, too."""
    nuclei = np.geomspace(5e-7, 3e-6, 4)
    usual = dipping(nuclei, deepest).at_stations("radius")[:, 0]
    slack = 1.0 - 3e-2  # what the steps may be off by, as they tell themselves
    assert np.all(usual[1:] >= slack * usual[:-1])
    wetter = replace(ABS, vapor_pressure=(1.0 + more) * ABS.vapor_pressure)
    assert np.all(dipping(nuclei, deepest, wetter).at_stations("radius")[:, 0] >= slack * usual)
    thin = dipping(nuclei, deepest, viscosity=thinner * MU).at_stations("radius")[:, 0]
    assert np.all(thin >= slack * usual)


def test_nuclei_at_once_are_nuclei_one_by_one() -> None:
    rng = np.random.default_rng(2)
    t = np.cumsum(rng.uniform(1e-3, 1e-2, (2, 1, 40)), axis=-1)
    p = 1e5 + 3e5 * np.cos(rng.uniform(10.0, 30.0, (2, 3, 1)) * t)
    told = t[..., -1:] + [[[0.0, 0.5]]]
    nuclei = np.array([3e-7, 1e-6])
    found = grow(
        Surroundings(t[:, :, None], p[:, :, None], MU), ABS, nuclei, CELL, told[:, :, None]
    )
    assert found.radius.shape == (2, 3, 2, 2 * growth.STEPS + 1)
    for i in range(2):
        for j in range(3):
            for k in range(2):
                alone = grow(Surroundings(t[i, 0], p[i, j], MU), ABS, nuclei[k], CELL, told[i, 0])
                assert found.radius[i, j, k] == pytest.approx(alone.radius, rel=1e-6)
                assert found.time[i, j, k] == pytest.approx(alone.time, rel=1e-12)


def test_a_melt_under_tension_tears_and_is_not_without_end() -> None:
    found = grow(Surroundings([0.0, 1.0], [-1e6, -1e6], MU), ABS, R_0, CELL, [1.0])
    gas = 4 / 3 * math.pi * found.radius[-1] ** 3
    assert gas / (gas + CELL) == pytest.approx(0.99, rel=1e-9)


LAWS = (
    PowerLaw(8213.0, 0.5),
    CarreauYasuda(10390.0, 0.35, 0.5),
    CarreauYasuda(5000.0, 0.25, 1.0, infinite_viscosity=50.0, transition=0.8),
)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("rate", [1e-3, 1.0, 300.0, -300.0])
@pytest.mark.parametrize("squeezed", [1e-6, 0.1, 0.9])
@pytest.mark.parametrize("flow_rate", [0.0, 5.0, 100.0])
def test_resistance_is_the_melts_stress_over_its_cell(law, rate, squeezed, flow_rate) -> None:
    """Against an adaptive rule; eight points are off by 0.3 % where a law bends most."""

    def stress(x):
        total = math.hypot(flow_rate, 2 * math.sqrt(3) * rate * x)
        return float(law.viscosity_at(total))

    def in_log(s):
        return stress(math.exp(s)) * math.exp(s)

    expected = 4 * rate * quad(in_log, math.log(squeezed), 0.0, epsrel=1e-10, limit=200)[0]
    found, slope = viscous_resistance(rate, squeezed, law, flow_rate)
    assert float(found) == pytest.approx(expected, rel=3e-3)
    near = [
        4
        * e
        * quad(
            lambda s, e=e: (
                math.exp(s)
                * float(law.viscosity_at(math.hypot(flow_rate, 2 * math.sqrt(3) * e * math.exp(s))))
            ),
            math.log(squeezed),
            0.0,
            epsrel=1e-12,
            limit=200,
        )[0]
        for e in (rate * (1 - 1e-4), rate * (1 + 1e-4))
    ]
    assert float(slope) == pytest.approx((near[1] - near[0]) / (2e-4 * rate), rel=1e-5)


def test_resistance_of_a_power_law_and_of_a_newtonian_melt_is_exact() -> None:
    rate, squeezed, n = 7.0, 0.3, 0.4
    found, _ = viscous_resistance(rate, squeezed, PowerLaw(8213.0, n, 1e-9))
    expected = 4 * 8213.0 / n * (2 * math.sqrt(3)) ** (n - 1) * rate**n * (1 - squeezed**n)
    assert float(found) == pytest.approx(expected, rel=1e-12)
    found, slope = viscous_resistance(rate, squeezed, Newtonian(817.0), 50.0)
    assert float(found) == pytest.approx(4 * 817.0 * rate * 0.7, rel=1e-12)
    assert float(slope) == pytest.approx(4 * 817.0 * 0.7, rel=1e-12)


def test_a_melt_that_is_thinned_by_its_flow_grows_bubbles_as_a_newtonian_one() -> None:
    """A bubble far slower than the flow around it, at the viscosity of that flow."""
    law = CarreauYasuda(10390.0, 0.35, 0.5)
    viscosity = float(law.viscosity_at(1e3))
    end = 0.05 * 4 * viscosity / 2e5
    melt = BubbleMelt(3e5, 1.0, 1e-6, 0.0, 500.0, law)
    thinned = grow(
        Surroundings([0.0, end], [1e5, 1e5], viscosity, 1e3), melt, R_0, VAST, [end], 1e-6
    )
    usual = at_rest(PLENTY, end, viscosity=viscosity)
    # (g/gamma_dot)^2 of 500 1/s against 1000 1/s, through the index: at most a twentieth.
    assert np.log(thinned.radius[-1] / R_0) == pytest.approx(
        np.log(usual.radius[-1] / R_0), rel=0.1
    )


@pytest.mark.parametrize("ratio", [1.0, 3.0, 6.0])
@pytest.mark.parametrize("in_space", [True, False])
def test_a_tip_is_felt_as_far_as_its_pressure_reaches(ratio, in_space) -> None:
    """Against the potentials of an ellipsoid: a spheroid, or one that is long across the plane."""
    a = 42e-6
    across = 1.0 / ratio if in_space else 1e4
    body = Ellipsoid((1.0, 1.0 / ratio, across))
    strain = np.diag([1.0, -0.5, -0.5] if in_space else [1.0, -1.0, 0.0])
    away = np.array([0.0, 0.1, 0.5, 2.0])
    points = np.zeros((4, 3))
    points[:, 0] = 1.0 + away
    found = ellipsoid_field(body, strain, points).pressure
    share = Tip(a, a / ratio, in_space).share(a * away)
    assert share[0] == pytest.approx(1.0, rel=1e-12)
    # A sphere stands for what is one within a millionth, a cylinder is cut at 1e4 half-lengths.
    assert share == pytest.approx(found / found[0], rel=3e-6)


def test_what_grows_out_of_its_crevice_feels_less_of_the_tip() -> None:
    t = np.linspace(0.0, 0.1, 30)
    dip = -6e5 * np.exp(-(((t - 0.05) / 0.02) ** 2))
    told = partial(grow, melt=ABS, radius=R_0, cell_volume=CELL, stations=[0.06])
    tip = Tip(42e-6, 7e-6, in_space=True)
    at_tip = told(Surroundings(t, np.full(30, 1.5e5), MU, fiber_pressure=dip, tip=tip)).radius[-1]
    everywhere = told(Surroundings(t, 1.5e5 + dip, MU)).radius[-1]
    without = told(Surroundings(t, np.full(30, 1.5e5), MU)).radius[-1]
    assert without < 0.9 * at_tip < 0.9 * everywhere


@pytest.mark.parametrize(
    ("given_", "kind", "message"),
    [
        ({"time": [0.0, 0.0]}, HistoryError, "time must increase strictly"),
        ({"viscosity": [1.0] * 3}, HistoryError, "do not go together"),
        ({"viscosity": -1.0}, ConfigError, "viscosity = -1 Pa s: must be above 0 Pa s"),
        ({"flow_rate": -1.0}, ConfigError, "flow_rate = -1 1/s: must be at least 0 1/s"),
        ({"radius": 0.0}, ConfigError, "radius = 0 m: must be above 0 m"),
        ({"radius": [1e-6, 1e-6]}, None, ""),
        ({"stations": 1.0}, HistoryError, "give at least one time"),
        ({"stations": [1.0, 0.5]}, HistoryError, "stations must be finite, increase"),
        ({"stations": [0.0]}, HistoryError, "lie after the first point"),
    ],
)
def test_what_is_no_path_or_no_nucleus_is_refused(given_, kind, message) -> None:
    usual = {"time": [0.0, 1.0], "pressure": [1e5, 1e5], "viscosity": MU, "flow_rate": 0.0}
    around = Surroundings(**{name: given_.get(name, one) for name, one in usual.items()})
    radius, stations = given_.get("radius", R_0), given_.get("stations", [1.0])
    if kind is None:
        assert grow(around, ABS, radius, CELL, stations).radius.shape == (2, growth.STEPS + 1)
        return
    with pytest.raises(kind, match=message):
        grow(around, ABS, radius, CELL, stations)


def test_what_is_no_melt_or_no_fiber_is_refused() -> None:
    with pytest.raises(ConfigError, match="solubility = 0"):
        BubbleMelt(1e5, 0.0, 1e-10, 0.02, 500.0)
    with pytest.raises(ConfigError, match="half_length = 1e-06 m: must be at least 2e-06 m"):
        Tip(1e-6, 2e-6, in_space=True)
