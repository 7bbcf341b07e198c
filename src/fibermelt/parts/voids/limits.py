"""How fast and how wet: the print speeds and moistures that let a nucleus grow alike, as curves.

In creeping flow all pressures over the air's go with the ``n``-th power of a factor ``s`` on the
speeds, times with ``1/s`` and viscosities with ``s^(n-1)``, ``n`` = 1 of a Newtonian melt and the
index of one that follows a power law. The growth exponent then depends on the vapor's excess over
the air and on ``s`` by one number alone::

    G = mean of integral max(0, q - p)/(4 eta) dt,   q = (P_V - p_air)/s^n

with the gauge pressure ``p`` of the study. Where it is ``G``, the vapor pressure is
``p_air + q(G) s^n``: of all speeds, without another flow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.voids.constants import ATMOSPHERE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fibermelt.parts.voids.melt import MoistMelt

    Array = NDArray[np.float64]

__all__ = ["excess_at", "joint_limits"]

WIDER = (2.0, 10.0, 100.0)
"""How many times as wide a nucleus on a fiber becomes, on average: their logarithms are the growth
exponents of the curves."""

SPEEDS = np.linspace(0.1, 2.0, 39)
"""Factors on all speeds of the flow."""


def joint_limits(
    time: Array,
    pressure: Array,
    viscosity: Array,
    until: Array,
    melt: MoistMelt,
    exponent: float,
) -> dict[str, Any]:
    """Return the moisture at which a nucleus grows so far, by speed; nothing without an exponent.

    Parameters
    ----------
    time, viscosity : (n_streamlines, n) array
        Time [s] and viscosity of the melt [Pa s] along the streamlines that count.
    pressure : (n_streamlines, n_angles, n) array
        Lowest pressure on the fibers [Pa, gauge].
    until : (n_streamlines,) array
        When to end [s].
    melt : MoistMelt
        Whose isotherm takes vapor pressures to moistures.
    exponent : float
        ``n``; NaN of a melt that follows no power.

    Returns
    -------
    dict
        ``void_limit_wider``, ``void_limit_speed``, and ``void_limit_moisture`` over both: NaN where
        no moisture that the polymer can hold suffices, 0 where the melt is under tension.
    """
    if np.isnan(exponent) or not len(time):
        return {}
    q = np.array([excess_at(np.log(wider), time, pressure, viscosity, until) for wider in WIDER])
    vapor = ATMOSPHERE + q[:, None] * SPEEDS**exponent
    moisture = melt.card.melt.critical_moisture(vapor, melt.temperature)
    return {
        "void_limit_wider": list(WIDER),
        "void_limit_speed": SPEEDS,
        "void_limit_moisture": np.where(np.isfinite(moisture), moisture, np.nan),
    }


def excess_at(target: float, time: Array, pressure: Array, viscosity: Array, until: Array) -> float:
    """Return the vapor's excess ``q`` [Pa] over the air at which the mean exponent is a target.

    With the trapezoidal rule the exponent is ``sum w_i max(0, q - p_i)``, a polyline in ``q`` that
    rises everywhere above the lowest pressure: sorted, it is inverted exactly.

    Parameters
    ----------
    target : float
        Mean over streamlines and angles, > 0.
    time, pressure, viscosity, until : array
        As in `joint_limits`.
    """
    step = np.diff(np.minimum(time, until[:, None]), axis=-1)
    share = np.zeros_like(time)
    share[:, :-1] += 0.5 * step
    share[:, 1:] += 0.5 * step
    weight = share / (4.0 * viscosity * pressure.shape[0] * pressure.shape[1])
    w = np.broadcast_to(weight[:, None, :], pressure.shape).ravel()
    order = np.argsort(pressure, axis=None)
    p, w = pressure.ravel()[order], w[order]
    rise, moment = np.cumsum(w), np.cumsum(w * p)
    exponent = p * rise - moment
    if target >= exponent[-1]:
        return float((target + moment[-1]) / rise[-1])
    k = int(np.searchsorted(exponent, target, side="right")) - 1
    return float((target + moment[k]) / rise[k])
