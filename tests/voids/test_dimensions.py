"""Every law of nucleation rebuilt with units: the dimension comes out, and the same number.

A formula is written here once more, from the literature, on quantities in the units of its field
(dyn/cm, bar, cm2/s, g/mol). A factor or an exponent that is wrong on either side shows.
"""

import math

import numpy as np
import pytest

from fibermelt import voids
from fibermelt.voids.constants import ATMOSPHERE, WATER_MOLAR_MASS
from fibermelt.voids.nucleation import log10_barrier

pytestmark = pytest.mark.verification

ROUNDING = 1e-9  # constants of nature of the unit library, to its digits
pint = pytest.importorskip("pint")
REGISTRY = pint.UnitRegistry()
Q = REGISTRY.Quantity
K_B, N_A, R = (1.0 * REGISTRY.Unit(u) for u in ("k_B", "N_A", "R"))

T = Q(500.0, "K")
ETA = Q(24.0, "dyn/cm")
DEFICIT = Q(15.0, "bar")
RHO = Q(1.154, "g/cm^3")
D = Q(2.3e-6, "cm^2/s")
MASS = Q(WATER_MOLAR_MASS * 1e3, "g/mol") / N_A
MOISTURE = Q(0.17, "percent")
N_V = MOISTURE * RHO / MASS
RADIUS = 2 * ETA / DEFICIT
WORK = 16 * math.pi * ETA**3 / (3 * DEFICIT**2)


def si(quantity, unit):
    """Return the number of a quantity in an SI unit; raises where the dimension is another."""
    return float(quantity.to(unit).magnitude)


def test_molecules_and_critical_radius():
    found = voids.molecules_per_volume(si(MOISTURE, ""), si(RHO, "kg/m^3"))
    assert float(found) == pytest.approx(si(N_V, "1/m^3"), rel=ROUNDING)
    found = voids.critical_radius(si(ETA, "N/m"), si(DEFICIT, "Pa"))
    assert float(found) == pytest.approx(si(RADIUS, "m"), rel=ROUNDING)


def test_work_of_the_critical_bubble():
    found = 10 ** float(log10_barrier(si(ETA, "N/m"), si(DEFICIT, "Pa")))
    assert found == pytest.approx(si(WORK, "J"), rel=ROUNDING)


def test_classical_rate():
    phi = Q(20.0, "degree")  # the exponent is then small enough to be written out
    wetting = (2 + np.cos(phi)) * (1 - np.cos(phi)) ** 2 / 4
    rate = N_V * np.sqrt(2 * ETA / (math.pi * MASS)) * np.exp(-(WORK / (K_B * T) * wetting).to(""))
    law = voids.ClassicalNucleation(
        si(ETA, "N/m"),
        si(T, "K"),
        si(N_V, "1/m^3"),
        si(MASS, "kg"),
        float(voids.wetting_factor(si(phi, "rad"))),
    )
    found = float(law.log10_rate(si(DEFICIT, "Pa")))
    assert found == pytest.approx(math.log10(si(rate, "1/(m^3 s)")), rel=ROUNDING)


def test_critical_time():
    found = voids.ResidenceCondition(si(D, "m^2/s")).time(si(RADIUS, "m"))
    assert float(found) == pytest.approx(si(RADIUS**2 / D, "s"), rel=ROUNDING)


def test_free_volume():
    w1, energy = 0.2, Q(1.0, "kcal/mol")
    v1, v2 = Q(0.917, "cm^3/g"), Q(0.850, "cm^3/g")
    k11, k12 = Q(1.45e-3, "cm^3/(g K)"), Q(5.82e-4, "cm^3/(g K)")
    o1, o2 = Q(-86.32, "K"), Q(-327.0, "K")
    free = w1 * k11 * (o1 + T) + (1 - w1) * k12 * (o2 + T)
    jump = w1 * v1 + (1 - w1) * 0.58 * v2
    alone = (
        Q(4.82e-4, "cm^2/s") * np.exp(-(energy / (R * T)).to("")) * np.exp(-(jump / free).to(""))
    )
    law = voids.FreeVolume(
        si(Q(4.82e-4, "cm^2/s"), "m^2/s"),
        si(energy, "J/mol"),
        (si(v1, "m^3/kg"), si(v2, "m^3/kg")),
        0.58,
        (si(k11, "m^3/(kg K)"), si(k12, "m^3/(kg K)")),
        (si(o1, "K"), si(o2, "K")),
        0.354,
    )
    found = float(law.self_diffusivity(w1, si(T, "K")))
    assert found == pytest.approx(si(alone, "m^2/s"), rel=ROUNDING)
    mutual = alone * (1 - w1) ** 2 * (1 - 2 * 0.354 * w1)
    found = float(law.diffusivity(w1, si(T, "K")))
    assert found == pytest.approx(si(mutual, "m^2/s"), rel=ROUNDING)


def test_arrhenius_and_henry():
    energy, base, heat = Q(10.4, "kcal/mol"), Q(293.15, "K"), Q(-10.2, "kcal/mol")
    found = voids.Arrhenius.of_energy(7.54e-6, si(energy, "J/mol")).diffusivity(si(T, "K"))
    expected = Q(7.54e-2, "cm^2/s") * np.exp(-(energy / (R * T)).to(""))
    assert float(found) == pytest.approx(si(expected, "m^2/s"), rel=ROUNDING)
    constant = Q(20.0, "percent/bar")
    solubility = constant * np.exp((-heat / R * (1 / T - 1 / base)).to(""))
    law = voids.Henry(si(constant, "1/Pa"), si(base, "K"), si(heat, "J/mol"))
    found = float(law.vapor_pressure(1e-4, si(T, "K")))
    assert found == pytest.approx(si(1e-4 / solubility, "Pa"), rel=ROUNDING)


def test_sugden():
    styrene = {"C": 8, "H": 8, "double bond": 3, "six-membered ring": 1}
    parachor = Q(250.9, "cm^3/mol") * Q(1.0, "dyn/cm") ** 0.25
    volume = Q(104.15, "g/mol") / Q(1.05, "g/cm^3")
    found = float(voids.Parachor.of_structure(styrene).tension(si(volume, "m^3/mol")))
    assert found == pytest.approx(si((parachor / volume) ** 4, "N/m"), rel=ROUNDING)


def test_margin_is_between_absolute_pressures():
    gauge, vapor = Q(-0.5, "bar"), Q(8.0, "psi")
    found = voids.assess([0.0, 1.0], [0.0, si(gauge, "Pa")], si(vapor, "Pa"))
    margin = gauge + Q(1.0, "atm") - vapor
    assert Q(1.0, "atm").to("Pa").magnitude == pytest.approx(ATMOSPHERE)
    assert float(found.margin) == pytest.approx(si(margin, "Pa"), rel=ROUNDING)
