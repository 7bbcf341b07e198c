"""Voids: properties against tables, laws against what they were derived from, inverses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from fibermelt.verify.ladder import Rung, below, order
from fibermelt.voids.diffusion import FreeVolume
from fibermelt.voids.growth import BubbleMelt, Surroundings, grow
from fibermelt.voids.margin import assess
from fibermelt.voids.nucleation import ClassicalNucleation, critical_radius, log10_barrier
from fibermelt.voids.saturation import saturation_pressure
from fibermelt.voids.vapor import ActivityLaw, critical_moisture
from fibermelt.voids.wetting import vapor_angle, wetting_factor

__all__ = ["RUNGS", "TOLUENE_DIFFUSIVITIES", "TOLUENE_PS", "cap_share"]

Array = NDArray[np.float64]

IF97 = "IAPWS R7-97 (2012), Table 35"
WAGNER = "Wagner and Pruss 2002, doi 10.1063/1.1461829"
VRENTAS = "Vrentas and Duda 1977, doi 10.1002/pol.1977.180150302"
BARLOW = "Barlow and Langlois 1962, doi 10.1147/rd.63.0329"
BLANDER = "Blander and Katz 1975, doi 10.1002/aic.690210502"
PAPER = "Awenlimobor, Smith and Wang 2024, doi 10.1016/j.addma.2024.103980"

SATURATION = {300.0: 3.53658941e3, 500.0: 2.63889776e6, 600.0: 1.23443146e7}
"""Saturation pressures [Pa] that the release of IF97 gives to check programs with, by kelvin."""

PROCESSING, AT_PROCESSING = 503.15, 2.797e6
"""230 degC, and the saturation pressure there by the reference equation of state [Pa]."""

TOLUENE_PS = FreeVolume(
    prefactor=4.82e-8,
    energy=0.0,
    jump_volumes=(0.917e-3, 0.850e-3),
    jump_ratio=0.58,
    hole_growth=(1.45e-6, 5.82e-7),
    offsets=(-86.32, -327.0),
    interaction=0.354,
)
"""Toluene in polystyrene, with Vrentas and Duda's parameters."""

TOLUENE_DIFFUSIVITIES = (1.435e-12, 7.884e-13)
"""Its self-diffusivity and mutual one at 308 K and ``w_1 = 0.2`` [m2/s], to four digits."""

TENSION, DEFICIT, MOLECULES = 0.024, 2e6, 6.6e25
"""Of an ABS melt at 230 degC, of the deepest pressures on fibers, and of 0.17 % moisture."""

ISOTHERM = ActivityLaw(0.005, 296.15)
"""Water in ABS, 0.5 % at saturation."""


def cap_share(angle: float) -> float:
    """Return the volume over the full sphere's of a cap that meets its plane at an angle [rad].

    By slices: ``V = pi int (r^2 - z^2) dz`` from ``r cos(phi)`` to ``r``, Gauss's rule.
    """
    nodes, weights = np.polynomial.legendre.leggauss(4)
    low = np.cos(angle)
    z = 0.5 * (1.0 + low) + 0.5 * (1.0 - low) * nodes
    slices = 0.5 * (1.0 - low) * float(weights @ (1.0 - z * z))
    return float(0.75 * slices)


def _properties() -> tuple[float, float, float]:
    """Return relative errors of the saturation pressure, and of toluene's diffusivities."""
    checked = saturation_pressure(list(SATURATION)) / np.array(list(SATURATION.values()))
    processing = float(saturation_pressure(PROCESSING)) / AT_PROCESSING
    found = (TOLUENE_PS.self_diffusivity(0.2, 308.0), TOLUENE_PS.diffusivity(0.2, 308.0))
    toluene = np.array([float(one) for one in found]) / np.array(TOLUENE_DIFFUSIVITIES)
    return (
        float(np.max(np.abs(checked - 1.0))),
        abs(processing - 1.0),
        float(np.max(np.abs(toluene - 1.0))),
    )


def _critical_bubble() -> tuple[float, float, float]:
    """Return relative errors of work and radius of the critical bubble, and of its share."""

    def loss(logarithm: float) -> float:
        r = float(np.exp(logarithm))
        return 4.0 * np.pi * (r**3 * DEFICIT / 3.0 - r**2 * TENSION)

    top = minimize_scalar(loss, bracket=(np.log(1e-9), np.log(1e-8)), tol=1e-10)
    work = 10.0 ** float(log10_barrier(TENSION, DEFICIT)) / -top.fun
    radius = float(critical_radius(TENSION, DEFICIT)) / float(np.exp(top.x))
    angles = np.linspace(0.01, np.pi, 60)
    shares = wetting_factor(angles) / np.array([cap_share(float(angle)) for angle in angles])
    return abs(work - 1.0), abs(radius - 1.0), float(np.max(np.abs(shares - 1.0)))


def _inverses() -> tuple[float, float, float]:
    """Return errors of required wetting, of its angle, and of the critical moisture."""
    law = ClassicalNucleation(TENSION, PROCESSING, MOLECULES)
    deficits = np.array([0.5e6, 1e6, DEFICIT, 3.6e6])
    required = law.required_wetting_factor(deficits)
    rates = [
        ClassicalNucleation(TENSION, PROCESSING, MOLECULES, wetting_factor=float(S)).log10_rate(dP)
        for S, dP in zip(required, deficits, strict=True)
    ]
    angles = np.pi - law.required_contact_angle(deficits)
    wetting = np.concatenate([wetting_factor(angles) / required, _wetting_round_trip()])
    moistures = np.geomspace(1e-6, 4.9e-3, 20)
    vapor = ISOTHERM.vapor_pressure(moistures, PROCESSING)
    back = critical_moisture(ISOTHERM, vapor, PROCESSING) / moistures
    return (
        float(np.max(np.abs(rates)) / law.log10_prefactor),
        float(np.max(np.abs(wetting - 1.0))),
        float(np.max(np.abs(back - 1.0))),
    )


def _wetting_round_trip() -> Array:
    """Return wetting factors from none to all over what their angles give back."""
    factors = np.concatenate([np.geomspace(1e-12, 0.1, 20), np.linspace(0.1, 1.0, 20)])
    return np.asarray(wetting_factor(vapor_angle(factors)) / factors)


def _limits() -> tuple[float, float, float]:
    """Return orders in deficit and angle towards their limits, and of the time below a pressure."""
    barrier = log10_barrier(TENSION, np.array([10.0, 20.0]))
    share = np.log2(wetting_factor(np.array([2e-3, 1e-3])))
    errors = []
    for intervals in (100, 400):  # the crossings are a third of an interval off in both
        time = np.linspace(0.0, 2.0 * np.pi, intervals + 1)
        stay = assess(time, -np.cos(time), 0.5, ambient=0.0).time_below
        errors.append(abs(float(stay) - 4.0 * np.pi / 3.0))
    return (
        float((barrier[0] - barrier[1]) / np.log10(2.0)),
        float(share[0] - share[1]),
        float(0.5 * np.log2(errors[0] / errors[1])),
    )


def _growth() -> tuple[float, float, float]:
    """Return errors of ln R at constant pressure and of a fixed gas, and of the water in all."""
    mu, vapor, air, R_0 = 800.0, 3e5, 1e5, 1e-6
    vast, tip = 1e3, 4.7e-14
    around = Surroundings([0.0, 0.05], [air, air], mu)

    def grown(diffusivity: float) -> tuple[Array, Array]:
        melt = BubbleMelt(vapor, 1.0, diffusivity, 0.0, PROCESSING)
        found = grow(around, melt, R_0, vast, [0.05], tolerance=1e-3)
        return found.time, np.log(found.radius / R_0)

    time, plenty = grown(1e-6)
    exact = (vapor - air) * time / (4.0 * mu)
    time, alone = grown(0.0)
    share = vapor / air - (vapor / air - 1.0) * np.exp(-3.0 * air * time / (4.0 * mu))
    dip = Surroundings([0.0, 0.1, 0.2, 0.5], [3e5, -2e5, 3e5, air], mu)
    moist = BubbleMelt(2.8e5, 1.9e-6, 2.3e-10, TENSION, PROCESSING)
    found = grow(dip, moist, R_0, tip, [0.2, 1.0])
    water = found.vapor + found.dissolved
    return (
        float(np.max(np.abs(plenty - exact))),
        float(np.max(np.abs(alone - np.log(share) / 3.0))),
        float(np.max(np.abs(water / water[0] - 1.0))),
    )


RUNGS = (
    Rung(
        "voids",
        (
            below(
                "growth: constant pressure",
                "Logarithm of the radius of a bubble whose vapor lasts against that of "
                "R_0 exp(dp t/(4 mu)).",
                BARLOW,
                1e-6,
                "the rate is constant, a step exact: 1e-8 of Newton's method is left of ln R = 3",
            ),
            below(
                "growth: gas of a fixed mass",
                "Logarithm of its radius against V' = 3 (p_0 V_0 - p V)/(4 mu), solved.",
                BARLOW,
                1e-3,
                "steps are halved until they tell an error of that",
            ),
            below(
                "growth: water",
                "Water in a bubble and its cell, over a dip in pressure and back, relative.",
                "nothing else holds any",
                1e-12,
                "what a shell gives the next one gets: rounding of some hundred steps",
            ),
        ),
        _growth,
        quick=True,
        brief=True,
    ),
    Rung(
        "voids",
        (
            below(
                "water: saturation pressure by IF97",
                "Saturation pressure at 300, 500 and 600 K against the release's own values, "
                "relative.",
                IF97,
                5e-9,
                "the values have nine digits: half a unit of the last is up to 4e-9",
            ),
            below(
                "water: saturation pressure at 230 degC",
                "Saturation pressure at 230 degC against the reference equation of state, "
                "2.797 MPa, relative.",
                WAGNER,
                4.5e-4,
                "2.5e-4 is what IF97 is allowed to differ, and the value has four digits",
            ),
            below(
                "diffusion: toluene in polystyrene",
                "Self and mutual diffusivity at 308 K and 20 % of toluene against the published "
                "values, relative.",
                VRENTAS,
                4e-4,
                "the values have four digits",
            ),
        ),
        _properties,
        quick=True,
        brief=True,
    ),
    Rung(
        "voids",
        (
            below(
                "nucleation: work of the critical bubble",
                "Work of the critical bubble against the maximum of surface and volume work over "
                "all radii, relative.",
                BLANDER,
                1e-12,
                "flat at its top: rounding",
            ),
            below(
                "nucleation: critical radius",
                "Critical radius against where that maximum is, relative.",
                BLANDER,
                1e-6,
                "a maximum is found to the root of rounding, 1.5e-8, and a few times that",
            ),
            below(
                "nucleation: wetting factor",
                "Wetting factor S(phi) against the volume of a cap over the sphere's, relative, 60 "
                "angles.",
                PAPER,
                1e-10,
                "slices of a flat cap cancel by its angle squared, 1e-4: rounding over that",
            ),
        ),
        _critical_bubble,
        quick=True,
        brief=True,
    ),
    Rung(
        "voids",
        (
            below(
                "nucleation: required wetting",
                "Logarithm of the rate at the wetting factor that is required for a rate of one "
                "against zero, over that of the rate without a barrier.",
                BLANDER,
                1e-12,
                "one formula solved for another of its letters: rounding",
            ),
            below(
                "nucleation: required angle",
                "Wetting factor of the angle of a wetting factor against itself, relative, from "
                "1e-12 to 1.",
                PAPER,
                1e-11,
                "a cubic solved in closed form; towards one the angle has half the digits, its "
                "factor all of them",
            ),
            below(
                "moisture: critical",
                "Moisture whose vapor pressure is that of a moisture against itself, relative, "
                "water in ABS at 230 degC.",
                "the law solved for its other letter",
                1e-14,
                "two products and two quotients: rounding",
            ),
        ),
        _inverses,
        quick=True,
        brief=True,
    ),
    Rung(
        "voids",
        (
            order(
                "nucleation: barrier of a small deficit",
                "Power of the deficit by which the work of the critical bubble grows as it goes to "
                "zero.",
                BLANDER,
                (2.0 - 1e-9, 2.0 + 1e-9),
                "W* ~ 1/(P_V - P_L)^2 exactly: rounding",
            ),
            order(
                "nucleation: melt that wets nothing",
                "Power of the angle through the vapor by which the wetting factor goes to zero.",
                "the volume of a flat cap, S ~ 3/16 phi^4",
                (4.0 - 1e-5, 4.0 + 1e-5),
                "the next term is phi^2 of it, at angles of 1e-3",
            ),
            order(
                "voids: time below the vapor pressure",
                "Order in the history's points at which the time below a pressure becomes that of "
                "a cosine, 100 and 400 intervals.",
                "linear interpolation",
                (1.95, 2.05),
                "second order; the next term is 1 % of it",
            ),
        ),
        _limits,
        quick=True,
        brief=True,
    ),
)
