"""A fiber in simple shear as time goes by: its angle, its spin and the pressure on it.

In ``u_x = gamma_dot y`` the director of a fiber with the shape factor ``B`` obeys ``p = F p_0/|F
p_0|`` with ``F_dot = (gamma_dot/2) [[0, B + 1], [B - 1, 0]] F``, whose square is a multiple of the
identity. So the motion is closed in form, whatever ``B``:

- ``B < 1``: Jeffery's (the paper's Eq. 23 turns the other way), with the aspect ratio ``rho =
  sqrt((1 + B)/(1 - B))`` of the unbounded ellipse that turns like the confined fiber,
  ``tan theta = -tan(k t - arctan(rho tan theta_0))/rho``, ``k = (gamma_dot/2) sqrt(1 - B^2)``;
- ``B >= 1``: ``F ~ 1 + x [[0, B + 1], [B - 1, 0]]``, ``x = tanh(k t)/sqrt(B^2 - 1)`` with ``k =
  (gamma_dot/2) sqrt(B^2 - 1)``, or ``gamma_dot t/2`` at ``B = 1``: it comes to rest at
  ``cos 2 theta = 1/B`` (Eq. 32).

The spin is ``(gamma_dot/2)(B cos 2 theta - 1)``, and the pressure that of the response at the phase
``pi/2 - 2 theta`` (`fibermelt.fiber.response`): nothing is integrated. `fibermelt.fiber.orbit` has
the extremes over the turn, exact; here they are seen coming and going (the paper's Fig. 8-10).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, refuse_no_count, refuse_other
from fibermelt.fiber.checks import checked_finite, checked_number
from fibermelt.fiber.curve import TrigonometricCurve
from fibermelt.fiber.jeffery import jeffery_angle
from fibermelt.fiber.orbit import checked_shear, tumbling_period
from fibermelt.fiber.response import FiberResponse

__all__ = ["Tumbling", "tumble", "turn_times", "turned_angle"]

Array = NDArray[np.float64]

FEWEST_INSTANTS = 5
"""Instants of a turn: its four quarters and the end, between which nothing is skipped."""


@dataclass(frozen=True, eq=False)
class Tumbling:
    """A fiber in simple shear at given instants; every array (n,).

    Pressures are relative to the far field's.

    Parameters
    ----------
    time : array
        Instants [s].
    angle : array
        Angle from the flow direction [rad], continuous in time: a tumbling fiber counts on.
    spin : array
        Rate of the angle [1/s].
    lowest, highest : array
        Lowest and highest pressure over the surface [Pa].
    tip : array
        Pressure at both tips [Pa].
    """

    time: Array
    angle: Array
    spin: Array
    lowest: Array
    highest: Array
    tip: Array


def turn_times(shape_factor: float, shear_rate: float, count: int) -> Array:
    """Return instants of one turn from the flow direction, (count,), 0 and the period included.

    A slender fiber rests along the flow most of the time and flips in a moment. The instants are
    even in the angle ``sigma`` half way between, ``tan(k t) = sqrt(rho) tan sigma`` and ``tan theta
    = -tan(sigma)/sqrt(rho)``: steps of time and of angle are both at most ``sqrt(rho)`` times those
    of even spacing, where even steps of time would make steps of angle ``rho`` times as large.

    Parameters
    ----------
    shape_factor : float
        ``B`` [-], above -1 and below 1.
    shear_rate : float
        ``gamma_dot`` [1/s], positive.
    count : int
        Number of instants, at least 5; the quarters are among them if it is 1 more than a
        multiple of 4.

    Raises
    ------
    ConfigError
        If the fiber stalls, the shear rate is not positive or the instants are too few.
    """
    rate, _, _ = checked_shear(shear_rate, 1.0, 0.0)
    period = tumbling_period(shape_factor, rate) if shape_factor > -1.0 else None
    if period is None:
        msg = (
            f"shape_factor = {shape_factor:g}: must lie between -1 and 1, or the fiber comes to "
            "rest and there is no turn; take a larger domain_size, or give the times yourself"
        )
        raise ConfigError(msg)
    refuse_no_count("count", count, FEWEST_INSTANTS, "the instants of a turn, e.g. 401")
    root = math.sqrt(_turning_ratio(shape_factor))
    sigma = np.linspace(0.0, 2.0 * np.pi, count)
    sine, cosine = np.sin(sigma), np.cos(sigma)
    # arctan(root tan sigma) on sigma's own branch: their difference never reaches a quarter turn
    ahead = np.arctan2((root - 1.0) * sine * cosine, cosine * cosine + root * sine * sine)
    time: Array = (sigma + ahead) * (period / (2.0 * np.pi))
    time[-1] = period
    return time


def tumble(
    response: FiberResponse,
    shear_rate: float,
    viscosity: float,
    time: ArrayLike,
    angle: float = 0.0,
) -> Tumbling:
    """Return how a fiber turns in simple shear and what its surface sees, at given instants.

    Parameters
    ----------
    response : FiberResponse
        Confined or unbounded.
    shear_rate : float
        ``gamma_dot`` [1/s] of ``u_x = gamma_dot y``, positive.
    viscosity : float
        ``mu`` [Pa s], positive.
    time : (n,) array_like
        Instants since the start [s], such as those of `turn_times`.
    angle : float
        Angle from the flow direction at the start [rad].

    Returns
    -------
    Tumbling
        Exact to rounding. The extremes over the surface are searched on the response's curve: for
        a few hundred instants that is cheaper than its support function's table.

    Raises
    ------
    ConfigError
        If the shear rate or the viscosity is not positive, the angle not finite or a time not
        a finite number.
    """
    refuse_other("response", response, FiberResponse)
    rate, viscosity, start = checked_shear(shear_rate, viscosity, angle)
    instants = real_array("time", time, duration=True)
    if instants.ndim != 1 or not np.all(np.isfinite(instants)):
        msg = f"time of shape {instants.shape}: must be a list of finite times in seconds"
        raise ConfigError(msg)
    factor, amplitude = response.shape_factor, 0.5 * viscosity * rate
    turned = turned_angle(factor, rate, instants, start)
    phase = 0.5 * np.pi - 2.0 * turned
    along, across = response.tip
    return Tumbling(
        time=instants,
        angle=turned,
        spin=0.5 * rate * (factor * np.cos(2.0 * turned) - 1.0),
        lowest=-amplitude * _support(response.curve, phase + np.pi),
        highest=amplitude * _support(response.curve, phase),
        tip=np.asarray(amplitude * (along * np.cos(phase) + across * np.sin(phase))),
    )


def turned_angle(
    shape_factor: float, shear_rate: float, time: ArrayLike, angle: float = 0.0
) -> Array:
    """Return the angle of a fiber from the flow [rad] at given times, whether it stalls or not.

    Parameters
    ----------
    shape_factor : float
        ``B`` [-], above -1.
    shear_rate : float
        ``gamma_dot`` [1/s] of ``u_x = gamma_dot y``, positive.
    time : (n,) array_like
        Times since the start [s].
    angle : float
        Angle from the flow direction at the start [rad].

    Raises
    ------
    ConfigError
        If the shear rate is not positive, a time or the angle not finite, or the shape factor not
        above -1.
    """
    rate, _, start = checked_shear(shear_rate, 1.0, angle)
    shape_factor = checked_number("shape_factor", shape_factor)
    if not shape_factor > -1.0:
        msg = f"shape_factor = {shape_factor:g}: must be above -1, that of a flat plate"
        raise ConfigError(msg)
    instants = checked_finite("time", time, duration=True)
    if shape_factor < 1.0:
        return jeffery_angle(instants, rate, _turning_ratio(shape_factor), start)
    return _stalling_angle(instants, rate, shape_factor, start)


def _turning_ratio(shape_factor: float) -> float:
    """Return the aspect ratio of the unbounded ellipse that turns alike, from ``B < 1``."""
    return math.sqrt((1.0 + shape_factor) / (1.0 - shape_factor))


def _support(curve: TrigonometricCurve, phase: Array) -> Array:
    """Return the highest ``e(phase).P(s)`` over the surface [-]."""
    point = curve.point(curve.search(phase))
    return np.asarray(np.cos(phase) * point[..., 0] + np.sin(phase) * point[..., 1])


def _stalling_angle(time: Array, rate: float, factor: float, start: float) -> Array:
    """Return the angle of a fiber that comes to rest, ``B >= 1`` [rad]; it turns less than pi."""
    root = math.sqrt((factor - 1.0) * (factor + 1.0))
    shear = 0.5 * rate * time
    x = np.tanh(root * shear) / root if root > 0.0 else shear
    cosine, sine = math.cos(start), math.sin(start)
    along = cosine + (factor + 1.0) * sine * x
    across = sine + (factor - 1.0) * cosine * x
    turned = np.arctan2(cosine * across - sine * along, cosine * along + sine * across)
    return np.asarray(start + turned)
