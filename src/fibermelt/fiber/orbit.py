"""One turn of a fiber in simple shear: its period, and the extremes of the pressure on it.

In ``u_x = gamma_dot y`` a fiber at the angle ``theta`` from the flow turns at ``theta_dot =
(gamma_dot/2)(B cos 2 theta - 1)``: clockwise, once in ``4 pi/(gamma_dot sqrt(1 - B^2))`` (the
paper's Eq. 24 with the confined fiber's ``B``), unless ``B >= 1``, where it stalls. The strain is
``gamma_dot/2`` along 45 degrees, so over every orientation the surface pressure lies within
``mu (gamma_dot/2) max_s |P(s)|`` on both sides (`fibermelt.fiber.response`), and is extreme where
the strain's phase ``2 (pi/4 - theta)`` is the direction of ``P(s)`` or its opposite. Every
orientation is an orbit if the fiber tumbles, half a turn if it stalls: no angle is sampled.

`fibermelt.fiber.newton_orbit` answers the same by the paper's algorithm, which samples.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from fibermelt.errors import ConfigError, refuse_no_number, refuse_other
from fibermelt.fiber.checks import checked_number, checked_positive
from fibermelt.fiber.curve import TrigonometricCurve, fold_angle
from fibermelt.fiber.jeffery import jeffery_period
from fibermelt.fiber.pressure import newtonian_viscosity, pressure_amplitude
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.melt import ViscosityLaw

__all__ = ["Orbit", "checked_shear", "orbit", "tumbling_period"]

Array = NDArray[np.float64]

TIE_TOLERANCE = 1e-12
"""Part of the largest pressure by which two places on the surface may differ and still tie:
rounding. A circle ties everywhere; finite elements break its ties at their own error."""

ANGLE_TOLERANCE = 1e-14
"""Bound of a root's error in the eccentric angle [rad]; rounding leaves about 1e-13."""


TURN_POINTS = 4096
"""Directions of a turn in a melt that thins: knots of the table's extremes, and of a rule that
converges like ``exp(-2 x 4096/r_e)``."""


@dataclass(frozen=True)
class Orbit:
    """A fiber in simple shear over one turn, or over half a turn if it stalls.

    Pressures are relative to the far field's.

    Parameters
    ----------
    period : float or None
        Time of a full turn [s]; None if the fiber stalls.
    period_jeffery : float
        That of the same ellipse in an unbounded melt [s] (Table 1's ``T_Jef``).
    shape_factor : float
        ``B`` [-].
    stalls : bool
        Whether it comes to rest.
    stall_angle : float or None
        Where it does [rad] from the flow direction; None if it tumbles.
    max_pressure, min_pressure : float
        Highest and lowest pressure on the surface [Pa].
    tip_max, tip_min : float
        Highest and lowest pressure at the tips [Pa].
    angle_at_min : float
        The fiber's angle from the flow direction [rad] when its surface sees the lowest pressure,
        in (-pi/2, pi/2].
    where_at_min : float
        Eccentric angle on the surface [rad] where it does, in (-pi/2, pi/2], 0 the tip.
    steps : int
        Orientations that were looked at; 0 if none had to be, as the answer is exact.
    solves : int
        Linear solves of the cell that this took, beyond what made the response.
    """

    period: float | None
    period_jeffery: float
    shape_factor: float
    stalls: bool
    stall_angle: float | None
    max_pressure: float
    min_pressure: float
    tip_max: float
    tip_min: float
    angle_at_min: float
    where_at_min: float
    steps: int = 0
    solves: int = 0


def orbit(
    response: FiberResponse | ThinningResponse,
    shear_rate: float,
    viscosity: float | ViscosityLaw,
    angle: float = 0.0,
) -> Orbit:
    """Return a fiber's orbit in simple shear from its response: exact, continuous in its angle.

    Parameters
    ----------
    response : FiberResponse or ThinningResponse
        Confined or unbounded.
    shear_rate : float
        ``gamma_dot`` [1/s] of ``u_x = gamma_dot y``, positive.
    viscosity : float or ViscosityLaw
        ``mu`` [Pa s], positive; of a melt that thins, its law and the fiber's table in it.
    angle : float
        Angle from the flow direction at the start [rad]. It decides nothing but ties: where the
        lowest pressure is reached at several angles, the first on the way is named.

    Raises
    ------
    ConfigError
        If the shear rate or the viscosity is not positive, or the angle not finite.

    Notes
    -----
    An unbounded ellipse has ``mu gamma_dot (1 + r_e)``, at its tips, lowest at 45 degrees from the
    flow (Jeffery 1922, doi 10.1098/rspa.1922.0078; the paper's Eq. 24-25 and Fig. 9).
    """
    if isinstance(response, ThinningResponse):
        return _thinning_orbit(response, shear_rate, viscosity, angle)
    refuse_other("response", response, FiberResponse)
    shear_rate, _, angle = checked_shear(shear_rate, 1.0, angle)
    constant = float(newtonian_viscosity(viscosity, np.asarray(0.5 * shear_rate)))
    amplitude = 0.5 * constant * shear_rate
    lowest_at, where = _lowest(response, angle)
    highest = amplitude * response.curve.farthest
    tip = amplitude * float(np.hypot(*response.tip))
    return Orbit(
        period=tumbling_period(response.shape_factor, shear_rate),
        period_jeffery=jeffery_period(response.aspect_ratio, shear_rate),
        shape_factor=response.shape_factor,
        stalls=response.stall_angle is not None,
        stall_angle=response.stall_angle,
        max_pressure=highest,
        min_pressure=-highest,
        tip_max=tip,
        tip_min=-tip,
        angle_at_min=lowest_at,
        where_at_min=where,
    )


def _thinning_orbit(
    response: ThinningResponse, shear_rate: float, viscosity: float | ViscosityLaw, start: float
) -> Orbit:
    """Return the orbit of a fiber in a melt that thins.

    ``theta_dot = (gamma_dot/2)(omega(pi/2 - 2 theta) - 1)``: its inverse is periodic and smooth, so
    trapezoidal rule integrates over the turn. ``B`` is ``omega`` along the flow, as the spins along
    and across it differ by ``gamma_dot B``.
    """
    rate, _, start = checked_shear(shear_rate, 1.0, start)
    amplitude = float(pressure_amplitude(response, viscosity, np.asarray(0.5 * rate)))
    phase = 2.0 * np.pi * np.arange(TURN_POINTS) / TURN_POINTS
    omega = response.series(rate)
    spin = omega(phase) - 1.0
    factor = float(omega(np.asarray(0.5 * np.pi)))
    stall, period = None, None
    if np.max(spin) >= 0.0:
        # the stable rest has theta > 0: omega falls to 1 as phi falls from its top
        top = float(phase[np.argmax(spin)])
        at = brentq(lambda phi: float(omega(np.asarray(phi))) - 1.0, 0.0, top, xtol=1e-12)
        stall = 0.5 * (0.5 * math.pi - at)
    else:
        period = float(2.0 * 2.0 * np.pi / rate * np.mean(-1.0 / spin))
    lowest = response.lowest_at(rate, phase)
    deepest = lowest <= lowest.min() + TIE_TOLERANCE * float(np.max(response.largest))
    angles = 0.5 * (0.5 * np.pi - phase[deepest])
    first = int(np.argmin((start - angles) % math.pi))
    tip = response.tip_at(rate, phase)
    return Orbit(
        period=period,
        period_jeffery=jeffery_period(response.aspect_ratio, rate),
        shape_factor=factor,
        stalls=stall is not None,
        stall_angle=stall,
        max_pressure=-amplitude * float(lowest.min()),
        min_pressure=amplitude * float(lowest.min()),
        tip_max=amplitude * float(tip.max()),
        tip_min=amplitude * float(tip.min()),
        angle_at_min=float(fold_angle(angles)[first]),
        where_at_min=float(response.where_lowest_at(rate, phase[deepest])[first]),
    )


def tumbling_period(shape_factor: float, shear_rate: float) -> float | None:
    """Return the time of a full turn, ``4 pi/(gamma_dot sqrt(1 - B^2))`` [s], None if ``B >= 1``.

    Eq. 24 of the paper with the confined fiber's ``B``.

    Parameters
    ----------
    shape_factor : float
        ``B`` [-], above -1.
    shear_rate : float
        ``gamma_dot`` [1/s], positive.

    Raises
    ------
    ConfigError
        If one is out of its range.
    """
    shear_rate = checked_positive("shear_rate", shear_rate, "1/s", "1")
    refuse_no_number("shape_factor", shape_factor)
    if not shape_factor > -1.0:
        msg = f"shape_factor = {shape_factor:g}: must be above -1 (Jeffery's is between -1 and 1)"
        raise ConfigError(msg)
    if shape_factor >= 1.0:
        return None
    return 4.0 * math.pi / (shear_rate * math.sqrt((1.0 - shape_factor) * (1.0 + shape_factor)))


def checked_shear(shear_rate: float, viscosity: float, angle: float) -> tuple[float, float, float]:
    """Return shear rate, viscosity and initial angle, or refuse them (`ConfigError`)."""
    return (
        checked_positive("shear_rate", shear_rate, "1/s", "1"),
        checked_positive("viscosity", viscosity, "Pa s", "817"),
        checked_number("angle", angle),
    )


def _lowest(response: FiberResponse, start: float) -> tuple[float, float]:
    """Return the fiber's angle and the place on it [rad] of the lowest pressure of all."""
    curve = response.curve
    radius = np.hypot(*curve.terms[0].T)
    if np.ptp(radius) <= TIE_TOLERANCE * radius.max():  # a circle: any angle, so the first one
        opposite = np.array([1.5 * math.pi - 2.0 * start])
        where = float(response.support.where_exact(opposite)[0])
        return float(fold_angle(np.array(start))), where
    places = _farthest_places(curve, radius)
    points = curve.point(places)
    angles = 0.75 * math.pi - 0.5 * np.arctan2(points[:, 1], points[:, 0])
    first = int(np.argmin((start - angles) % math.pi))
    return float(fold_angle(angles)[first]), float(fold_angle(places)[first])


def _farthest_places(curve: TrigonometricCurve, radius: Array) -> Array:
    """Return every eccentric angle [rad] at which ``|P(s)|`` is as large as it gets.

    ``d|P|^2/ds = 2 P.P'`` changes its sign within an expansion spacing of a local maximum.
    """
    tops = np.flatnonzero((radius >= np.roll(radius, 1)) & (radius >= np.roll(radius, -1)))

    def growth(s: float) -> float:
        at = np.array([s])
        return float(np.sum(curve.point(at) * curve.derivatives(at)[0]))

    places = np.array([_root_near(growth, k * curve.spacing, curve.spacing) for k in tops])
    reach = np.hypot(*curve.point(places).T)
    return np.asarray(places[reach >= (1.0 - TIE_TOLERANCE) * reach.max()])


def _root_near(function: Callable[[float], float], centre: float, width: float) -> float:
    """Return where a function falls through zero within ``width`` of ``centre``, or else centre."""
    before, after = centre - width, centre + width
    if function(before) > 0.0 > function(after):
        return float(brentq(function, before, after, xtol=ANGLE_TOLERANCE))
    return centre
