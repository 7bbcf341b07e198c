"""The fully developed flow of a melt in a slit and in a pipe: profile, wall rate, pressure drop.

The shear stress is linear from the middle to the wall whatever the law, ``tau = tau_w z`` with z
from 0 to 1, so that ``gamma_dot(z)`` solves ``eta(gamma_dot) gamma_dot = tau_w z`` at each point by
itself, and the mean speed (Weissenberg, Rabinowitsch) fixes ``tau_w``: with ``R`` the distance of
the wall from the middle ``U = R int_0^1 z^m gamma_dot dz``, ``m = 1`` in a slit and 2 in a pipe.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from fibermelt.errors import ConfigError
from fibermelt.melt.law import ViscosityLaw

__all__ = ["PipeFlow", "SlitFlow"]

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


class _Developed:
    """What both have in common; ``_wall`` is ``R`` [m], ``_power`` is ``m``, ``_called`` a name."""

    law: ViscosityLaw
    speed: float
    _power: ClassVar[int]
    _called: ClassVar[str]

    @property
    def _wall(self) -> float:
        raise NotImplementedError

    def _mean(self, profile: CubicHermiteSpline) -> float:
        """Return the mean over the section of a profile over ``z``."""
        raise NotImplementedError

    @cached_property
    def wall_rate(self) -> float:
        """Return the rate of deformation at the wall [1/s]; Newtonian: ``6 U/H``, ``8 U/D``.

        Raises
        ------
        ConfigError
            If no rate carries this flux.
        """
        newtonian = (self._power + 2) * self.speed / self._wall
        if self.law.is_newtonian:
            return newtonian
        z, weights = _towards_the_axis()

        def missing(log_rate: float) -> float:
            wall = np.exp(log_rate)
            rates = _rates(self.law, z * self.law.stress_at(wall), wall)
            mean = self._wall * np.sum(weights * z**self._power * rates)
            return float(mean / self.speed - 1.0)

        low, high = np.log(newtonian / RATES_AROUND), np.log(newtonian * RATES_AROUND)
        if missing(low) > 0 or missing(high) < 0:
            msg = (
                f"melt: no rate at the wall of a {self._called} {2 * self._wall:g} m wide carries "
                f"a mean speed of {self.speed:g} m/s with {self.law}"
            )
            raise ConfigError(msg)
        return float(np.exp(brentq(missing, low, high, xtol=1e-14, rtol=1e-14)))

    @property
    def wall_stress(self) -> float:
        """Return the shear stress at the wall [Pa]."""
        return float(self.law.stress_at(self.wall_rate))

    @property
    def pressure_gradient(self) -> float:
        """Return ``-dp/dx`` [Pa/m]; Newtonian: ``12 mu U/H^2``, ``32 mu U/D^2``."""
        return self._power * self.wall_stress / self._wall

    @cached_property
    def _profile(self) -> CubicHermiteSpline:
        """Return ``u / U`` over ``z``, with exact slopes, and a mean of exactly 1."""
        z = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, KNOTS)) ** 2
        nodes, weights = np.polynomial.legendre.leggauss(4)
        inner = z[:-1, None] + 0.5 * np.diff(z)[:, None] * (1 + nodes)
        rates = _rates(self.law, inner * self.wall_stress, self.wall_rate)
        falls = 0.5 * self._wall * np.diff(z) * (rates @ weights)
        u = np.r_[np.cumsum(falls[::-1])[::-1], 0.0] / self.speed
        slope = -self._wall * _rates(self.law, z * self.wall_stress, self.wall_rate)
        spline = CubicHermiteSpline(z, u, slope / self.speed)
        mean = self._mean(spline)
        return CubicHermiteSpline(z, u / mean, slope / (self.speed * mean))

    def velocity(self, x: Array) -> Array:
        """Return the velocity [m/s] at ``x`` [m] from the middle; zero at and beyond the walls."""
        z = np.abs(np.asarray(x) / self._wall)
        if self.law.is_newtonian:
            top = 0.5 * (self._power + 2) * self.speed
            return np.asarray(top * np.clip(1 - z**2, 0.0, None))
        return np.asarray(self.speed * self._profile(np.clip(z, 0.0, 1.0)))


@dataclass(frozen=True)
class PipeFlow(_Developed):
    """A melt flowing steadily in a round pipe.

    Parameters
    ----------
    law : ViscosityLaw
        Its stress must grow with its rate.
    diameter : float
        ``D`` [m].
    speed : float
        Mean speed ``U`` [m/s], > 0.

    References
    ----------
    Bird, Armstrong and Hassager, Dynamics of Polymeric Liquids 1 (1987), section 4.2.
    """

    _power: ClassVar[int] = 2
    _called: ClassVar[str] = "pipe"
    law: ViscosityLaw
    diameter: float
    speed: float

    @property
    def _wall(self) -> float:
        return self.diameter / 2

    def _mean(self, profile: CubicHermiteSpline) -> float:
        inner = profile.antiderivative()  # 2 int z u dz by parts
        return float(2 * (inner(1.0) - inner.integrate(0.0, 1.0)))


@dataclass(frozen=True)
class SlitFlow(_Developed):
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

    _power: ClassVar[int] = 1
    _called: ClassVar[str] = "slit"
    law: ViscosityLaw
    width: float
    speed: float

    @property
    def _wall(self) -> float:
        return self.width / 2

    def _mean(self, profile: CubicHermiteSpline) -> float:
        return float(profile.integrate(0.0, 1.0))

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
