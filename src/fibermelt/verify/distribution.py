"""The orientation distribution: closed forms, identities of its moments, spectral convergence."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

from fibermelt.fiber.shape import jeffery_factor
from fibermelt.orientation.distribution import UNIFORM, Distribution
from fibermelt.orientation.flows import FLOWS
from fibermelt.orientation.fokker_planck import (
    follow_distribution,
    rate_operator,
    steady_distribution,
)
from fibermelt.orientation.harmonics import number_of_harmonics, sphere_operators
from fibermelt.verify.ladder import Rung, below, order

__all__ = [
    "RUNGS",
    "folgar_tucker",
    "random_distribution",
    "random_gradient",
    "slow_shear",
    "uniaxial_moment",
]

Array = NDArray[np.float64]

ADVANI = "Advani and Tucker 1987, doi 10.1122/1.549945"
BIRD = "Bird et al. 1987, Dynamics of Polymeric Liquids 2, ISBN 978-0-471-80244-0"
TREFETHEN = "Trefethen 2000, doi 10.1137/1.9780898719598"

ROUNDING = 1e-12
"""Of moments of order one after a few thousand operations."""

INTERACTION = 0.0128
"""The paper's ``C_I``: in shear at 1/s its diffusivity [1/s]."""

DEGREES = (16, 32)
RESOLVED = 80
"""Of the harmonics at that diffusivity: rounding is all that is left."""


def random_gradient(seed: int) -> Array:
    """Return a velocity gradient (3, 3) [1/s] of order one, without trace."""
    L = np.random.default_rng(seed).normal(size=(3, 3))
    return np.asarray(L - np.trace(L) / 3.0 * np.eye(3))


def random_distribution(degree: int, seed: int) -> Distribution:
    """Return a distribution with coefficients of order one; it may be negative."""
    size = number_of_harmonics(degree)
    coefficients = np.random.default_rng(seed).normal(size=size)
    coefficients[0] = UNIFORM
    return Distribution(coefficients, degree)


def folgar_tucker(a: Array, A: Array, L: Array, factor: float, diffusivity: float) -> Array:
    """Return the rate of ``a`` [1/s] (the paper's Eq. 26), with the fourth moment as it is.

    Parameters
    ----------
    a, A : (3, 3) and (3, 3, 3, 3) arrays
        Second and fourth moment.
    L : (3, 3) array
        Velocity gradient [1/s].
    factor : float
        Jeffery's ``xi`` [-].
    diffusivity : float
        ``D_r`` [1/s].
    """
    D, W = 0.5 * (L + L.T), 0.5 * (L - L.T)
    strained = D @ a + a @ D - 2.0 * np.einsum("ijkl,kl->ij", A, D)
    rate = W @ a - a @ W + factor * strained + 2.0 * diffusivity * (np.eye(3) - 3.0 * a)
    return np.asarray(rate)


def uniaxial_moment(strength: float) -> float:
    """Return ``<p_1^2>`` of ``psi ~ exp(k p_1^2)``, ``k = 3 xi/(4 D_r)`` at a unit stretching.

    Without vorticity the flux of fibers is zero in the steady state, hence the closed form.

    Parameters
    ----------
    strength : float
        ``k`` [-].
    """

    def density(x: float) -> float:
        return float(np.exp(strength * (x * x - 1.0)))

    mass = quad(density, 0.0, 1.0, epsabs=0.0, epsrel=1e-13)[0]
    moment = quad(lambda x: x * x * density(x), 0.0, 1.0, epsabs=0.0, epsrel=1e-13)[0]
    return float(moment / mass)


def slow_shear(rate: float) -> tuple[float, float]:
    """Return errors of the series of rigid rods in slow shear, of viscosity and normal stress.

    ``3 a_22 = 1 - 18/35 w^2 + 1326/1925 w^4`` and ``5 a_12/w = 1 - 38/35 w^2``,
    ``w = gamma_dot/(6 D_r)`` (Bird et al. 1987).

    Parameters
    ----------
    rate : float
        ``w`` [-].
    """
    a = steady_distribution(FLOWS["simple-shear"], 1.0, 1.0 / (6.0 * rate)).second()
    viscosity = 1.0 - 18.0 / 35.0 * rate**2 + 1326.0 / 1925.0 * rate**4
    normal = 1.0 - 38.0 / 35.0 * rate**2
    return float(3.0 * a[1, 1] - viscosity), float(5.0 * a[0, 1] / rate - normal)


def _closed_forms() -> tuple[float, float]:
    """Return errors of the steady state in uniaxial flow, and of decay without flow."""
    stretch = np.diag([1.0, -0.5, -0.5])
    steady = []
    for diffusivity in (0.5, 0.05):
        along = uniaxial_moment(0.75 / diffusivity)
        across = 0.5 * (1.0 - along)
        found = steady_distribution(stretch, 1.0, diffusivity).second()
        steady.append(np.max(np.abs(found - np.diag([along, across, across]))))
    degree, diffusivity, time = 8, 0.3, np.linspace(0.0, 1.5, 4)
    start, still = random_distribution(degree, 8), np.zeros((4, 3, 3))
    history = follow_distribution(
        time, still, 0.9, diffusivity, initial=start, degree=degree, tolerance=1e-11
    )
    degrees = sphere_operators(degree).degrees
    decay = np.exp(-diffusivity * np.outer(time, degrees * (degrees + 1)))
    missed = history.distribution.coefficients - start.coefficients * decay
    return float(max(steady)), float(np.max(np.abs(missed)))


def _moments() -> tuple[float]:
    """Return the error of the rate of the second moment, over flows, fibers and diffusivities."""
    errors = []
    for seed, (factor, diffusivity) in enumerate([(1.0, 0.0), (-0.8, 0.3), (0.9459, 2.0)]):
        L, psi = random_gradient(seed), random_distribution(8, seed)
        rate = rate_operator(L, factor, diffusivity, 8) @ psi.coefficients
        expected = folgar_tucker(psi.second(), psi.fourth(), L, factor, diffusivity)
        missed = np.max(np.abs(Distribution(rate, 8).second() - expected))
        errors.append(missed / (1.0 + np.max(np.abs(expected))))
    return (float(max(errors)),)


def _convergence() -> tuple[float, float, float]:
    """Return the gain from one degree to the next, and orders of the slow series' next terms."""
    shear, factor = FLOWS["simple-shear"], jeffery_factor(6.0)
    exact = steady_distribution(shear, factor, INTERACTION, degree=RESOLVED).second()
    errors = [
        np.max(np.abs(steady_distribution(shear, factor, INTERACTION, degree=n).second() - exact))
        for n in DEGREES
    ]
    gain = (errors[0] / errors[-1]) ** (1.0 / (DEGREES[-1] - DEGREES[0]))
    viscosity, normal = np.log2(np.abs(np.divide(slow_shear(0.1), slow_shear(0.05))))
    return float(gain), float(viscosity), float(normal)


RUNGS = (
    Rung(
        "orientation",
        (
            below(
                "distribution: uniaxial elongation",
                "Second moment of the steady distribution of slender fibers against its closed "
                "form, D_r of 0.5 and 0.05.",
                "Doi and Edwards 1986, The Theory of Polymer Dynamics, ISBN 978-0-19-852033-7",
                ROUNDING,
                "the harmonics have converged: rounding",
            ),
            below(
                "distribution: decay without flow",
                "Coefficients of harmonics of degree l against exp(-D_r l (l + 1) t).",
                "eigenvalues of the Laplacian on the sphere",
                1e-9,
                "a few tens of steps of 1e-11 each, of coefficients up to three",
            ),
        ),
        _closed_forms,
        quick=True,
        brief=True,
    ),
    Rung(
        "orientation",
        (
            below(
                "distribution: rate of its moment",
                "Rate of the second moment of any distribution against Folgar and Tucker's "
                "equation with its own fourth moment, relative.",
                ADVANI,
                ROUNDING,
                "an identity that no truncation touches: rounding",
            ),
        ),
        _moments,
        quick=True,
        brief=True,
    ),
    Rung(
        "orientation",
        (
            order(
                "distribution: gain per degree",
                "Factor by which the error of the second moment falls for every degree of the "
                "harmonics, from 16 to 32, simple shear at C_I = 0.0128.",
                TREFETHEN,
                (2.0, 3.2),
                "entire solutions converge faster than exponentially: 2.3 at the first degree, 2.7 "
                "at the last, less if a harmonic is lost",
            ),
            order(
                "distribution: slow shear, viscosity",
                "Order of what a series in the shear rate up to the fourth power leaves of the "
                "viscosity of rigid rods.",
                BIRD,
                (5.9, 6.1),
                "the next term is the sixth power; at these rates the eighth is 1 % of it",
            ),
            order(
                "distribution: slow shear, normal stress",
                "Order of what a series in the shear rate up to the second power leaves of the "
                "normal stress of rigid rods.",
                BIRD,
                (3.9, 4.1),
                "the next term is the fourth power; at these rates the sixth is 1 % of it",
            ),
        ),
        _convergence,
        quick=True,
        brief=True,
    ),
)
