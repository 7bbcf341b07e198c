"""The fully developed flow of a melt in a slit: profile, wall rate, pressure drop, flux.

The shear stress is linear across a slit whatever the law, ``tau = tau_w |z|`` with ``z`` from -1
to 1 between the walls, so that ``gamma_dot(z)`` solves ``eta(gamma_dot) gamma_dot = tau_w |z|`` at
each point by itself, and the mean speed ``U = (H/2) int_0^1 z gamma_dot dz`` (Weissenberg,
Rabinowitsch) fixes ``tau_w``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from fibermelt.errors import ConfigError
from fibermelt.melt.law import ViscosityLaw

__all__ = ["SlitFlow"]

Array = NDArray[np.float64]

PANELS, PANEL_POINTS = 24, 12
"""Gauss points from the axis to the wall, on panels that halve towards the axis: a thinning melt
is level there and a power law further out, wherever that begins."""

KNOTS = 401
"""Knots of the profile across half a slit: as cubics with exact slopes they are 1e-9 of it off."""

RATES_AROUND = 1e6
"""How far from the Newtonian wall rate the rate at the wall is looked for, as a factor."""

STEPS = 60
"""Bisections of the logarithm of a rate over forty decades: to the last digit."""


@dataclass(frozen=True)
class SlitFlow:
    """A melt flowing steadily between two plates.

    Parameters
    ----------
    law : ViscosityLaw
        Its stress must grow with its rate.
    width : float
        Distance ``H`` of the plates [m].
    speed : float
        Mean speed ``U`` [m/s], > 0.

    References
    ----------
    Bird, Armstrong and Hassager, Dynamics of Polymeric Liquids 1 (1987), section 4.2.
    """

    law: ViscosityLaw
    width: float
    speed: float

    @cached_property
    def wall_rate(self) -> float:
        """Return the rate of deformation at the wall [1/s]; Newtonian: ``6 U / H``.

        Raises
        ------
        ConfigError
            If no rate carries this flux.
        """
        newtonian = 6 * self.speed / self.width
        if self.law.is_newtonian:
            return newtonian
        z, weights = _towards_the_axis()

        def missing(log_rate: float) -> float:
            wall = np.exp(log_rate)
            rates = _rates(self.law, z * self.law.stress_at(wall), wall)
            return float(0.5 * self.width * np.sum(weights * z * rates) / self.speed - 1.0)

        low, high = np.log(newtonian / RATES_AROUND), np.log(newtonian * RATES_AROUND)
        if missing(low) > 0 or missing(high) < 0:
            msg = (
                f"melt: no rate at the wall of a slit {self.width:g} m wide carries a mean speed "
                f"of {self.speed:g} m/s with {self.law}"
            )
            raise ConfigError(msg)
        return float(np.exp(brentq(missing, low, high, xtol=1e-14, rtol=1e-14)))

    @property
    def wall_stress(self) -> float:
        """Return the shear stress at the wall [Pa]."""
        return float(self.law.stress_at(self.wall_rate))

    @property
    def pressure_gradient(self) -> float:
        """Return ``-dp/dx = 2 tau_w / H`` [Pa/m]; Newtonian: ``12 mu U / H^2``."""
        return 2 * self.wall_stress / self.width

    @cached_property
    def _profile(self) -> CubicHermiteSpline:
        """Return ``u / U`` over ``|z|``, with exact slopes, and a mean of exactly 1."""
        z = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, KNOTS)) ** 2
        nodes, weights = np.polynomial.legendre.leggauss(4)
        inner = z[:-1, None] + 0.5 * np.diff(z)[:, None] * (1 + nodes)
        rates = _rates(self.law, inner * self.wall_stress, self.wall_rate)
        falls = 0.25 * self.width * np.diff(z) * (rates @ weights)
        u = np.r_[np.cumsum(falls[::-1])[::-1], 0.0] / self.speed
        slope = -0.5 * self.width * _rates(self.law, z * self.wall_stress, self.wall_rate)
        spline = CubicHermiteSpline(z, u, slope / self.speed)
        mean = float(spline.integrate(0.0, 1.0))
        return CubicHermiteSpline(z, u / mean, slope / (self.speed * mean))

    def velocity(self, x: Array) -> Array:
        """Return the velocity [m/s] at ``x`` [m] from the middle; zero at and beyond the walls."""
        z = np.abs(2 * np.asarray(x) / self.width)
        if self.law.is_newtonian:
            return np.asarray(1.5 * self.speed * np.clip(1 - z**2, 0.0, None))
        return np.asarray(self.speed * self._profile(np.clip(z, 0.0, 1.0)))

    def position_at_flux(self, fraction: Array) -> Array:
        """Return ``x`` [m] from the middle, left of which a part of the flux flows.

        Newtonian: with ``z = x/H + 1/2`` the flux left of it is ``3 z^2 - 2 z^3``; its inverse is
        ``z = 1/2 - sin(asin(1 - 2 f)/3)``.
        """
        f = np.asarray(fraction, dtype=np.float64)
        if self.law.is_newtonian:
            return np.asarray(-np.sin(np.arcsin(1 - 2 * f) / 3) * self.width)
        inner = self._profile.antiderivative()
        wanted = np.abs(2 * f - 1)
        found = [brentq(lambda z, g=g: inner(z) - g, 0.0, 1.0, xtol=1e-15) for g in wanted.flat]
        z = np.reshape(found, f.shape)
        return np.asarray(0.5 * self.width * np.sign(f - 0.5) * z)


def _towards_the_axis() -> tuple[Array, Array]:
    """Return nodes and weights of the quadrature from the axis to the wall."""
    ends = np.r_[0.0, 2.0 ** -np.arange(PANELS, -1.0, -1.0)]
    nodes, weights = np.polynomial.legendre.leggauss(PANEL_POINTS)
    half = 0.5 * np.diff(ends)[:, None]
    return (ends[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


def _rates(law: ViscosityLaw, stress: Array, highest: float) -> Array:
    """Return the rates [1/s] at which a law has given stresses, up to that at ``highest``.

    By bisection in the rate's logarithm: the stress of a melt grows with its rate, slowly where it
    thins much.
    """
    wanted = np.asarray(stress, dtype=np.float64)
    high = np.full(wanted.shape, np.log(highest))
    low = high - 92.0
    with np.errstate(divide="ignore"):
        target = np.log(wanted)
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        below = np.log(law.stress_at(np.exp(middle))) < target
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(np.where(wanted > 0, np.exp(0.5 * (low + high)), 0.0))
