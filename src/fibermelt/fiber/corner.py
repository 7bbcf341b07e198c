"""What a fiber feels at most near a singular corner, where the velocity gradient has no bound.

At a lip, at the contact with the bed and at the corners of a capillary's entrance the rate of
deformation grows as ``K r^-q`` with the distance ``r``. A fiber is no point, and cannot feel a
gradient finer than itself.

*What it feels.* In a linear flow the traction on a rigid ellipsoid is a constant tensor times its
normal (Jeffery 1922), so by the reciprocal theorem its stresslet and its turn in any Stokes flow
are those in the linear flow with the mean of the undisturbed gradient over its volume (Faxen's law
for ellipsoids: Kim and Karrila, Microhydrodynamics, 1991, chapter 3). Its pressure extremes are
taken to follow that mean.

*A bound of the mean.* No part of a fiber of half-length ``a`` is nearer to the corner than
``r - a``. Wherever it is, the mean of ``r^-q`` over it is at most that with its middle on the
corner (Anderson 1955, doi:10.1090/S0002-9939-1955-0069229-1). That is below
``3/4 int (1 - t^2) |a t|^-q dt`` along its axis, as every part is further off than its place on the
axis: ``3/((1 - q)(3 - q)) a^-q`` of a spheroid, less of an ellipse. Together, with
``c = ((1 - q)(3 - q)/3)^(1/q)``::

    felt <= K max(r - a, c a)^-q

``K`` differs around a corner, by a factor of two at a lip: it is the largest that the streamline
has within ``a`` along it. Far off the corner this is the rate itself. Where a wall ends it lies 6 %
to three times above the exact mean within a half-length of the corner, at three 6 to 50 %.

*The exponent.* ``q = 1/(1 + n)`` with the melt's index ``n``: dissipation grows as ``1/r`` where a
wall that holds the melt ends (Hutchinson 1968, doi:10.1016/0022-5096(68)90014-8; in a Newtonian
melt the field of Michael 1958, ``psi = r^(3/2) (sin 3/2 theta + sin 1/2 theta)``). A no-slip corner
below 360 degrees has less (Moffatt 1964, doi:10.1017/S0022112064000015), which this overstates from
``c a`` on; only a slender fiber's middle comes nearer.

It holds for fibers whose axis lies in the plane of the flow. The walls' own hindrance is left out,
as along every path, and the melt's own pressure is that at the fiber's middle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.fiber.checks import checked_positive
from fibermelt.history import FlowHistory

__all__ = ["felt_path", "felt_rate"]

Array = NDArray[np.float64]


def felt_rate(
    path: FlowHistory,
    corner_distance: ArrayLike,
    half_length: float,
    index: ArrayLike = 1.0,
    error: ArrayLike = 0.0,
) -> Array:
    """Return the largest rate of deformation that fibers feel along a path [1/s], (..., n).

    Parameters
    ----------
    path : FlowHistory
        One path or several.
    corner_distance : (..., n) array
        Distance from the nearest singular corner [m].
    half_length : float
        Of the fibers, ``a`` [m].
    index : float or (..., n) array
        The melt's index ``n``, 1 + d ln eta / d ln gamma_dot: above 0, 1 of a Newtonian melt.
    error : float or (..., n) array
        Error of the gradient [1/s]: ``e`` changes the rate by at most ``sqrt(2) e``.

    Raises
    ------
    ConfigError
        If the half-length is not positive.
    """
    a = checked_positive("fiber.half_length", half_length, "m", "42e-6")
    r, e = np.asarray(corner_distance, dtype=float), np.asarray(error, dtype=float)
    q = 1.0 / (1.0 + np.asarray(index, dtype=float))
    nearest = np.maximum(r - a, ((1.0 - q) * (3.0 - q) / 3.0) ** (1.0 / q) * a)
    rate = path.shear_rate + np.sqrt(2.0) * e
    return _largest_within(path, rate * r**q, a) / nearest**q


def felt_path(
    path: FlowHistory,
    corner_distance: ArrayLike,
    half_length: float,
    index: ArrayLike = 1.0,
    error: ArrayLike = 0.0,
) -> FlowHistory:
    """Return the path with its gradient at the size that fibers feel at most.

    Bounds over every orientation on it (`pressure_bounds`, `FiberModel.bounds`) are those of what a
    fiber sees near a corner. Where the melt does not deform at all, there is nothing to enlarge.

    Parameters
    ----------
    path, corner_distance, half_length, index, error
        As in `felt_rate`.
    """
    felt, rate = felt_rate(path, corner_distance, half_length, index, error), path.shear_rate
    moving = rate > np.finfo(float).tiny
    factor = np.divide(felt, rate, out=np.ones_like(rate), where=moving)
    return replace(path, gradient=path.gradient * factor[..., None, None], viscosity=None)


def _largest_within(path: FlowHistory, values: Array, reach: float) -> Array:
    """Return the largest of values (..., n) within a way of ``reach`` along each path."""
    step = np.linalg.norm(np.diff(path.position, axis=-2), axis=-1)
    way = np.concatenate([np.zeros_like(step[..., :1]), np.cumsum(step, axis=-1)], axis=-1)
    n = way.shape[-1]
    found = []
    for along, line in zip(way.reshape(-1, n), values.reshape(-1, n), strict=True):
        first = np.searchsorted(along, along - reach, side="left")
        after = np.searchsorted(along, along + reach, side="right")
        # Pairs of ends; the number behind the last belongs to no stretch.
        ends = np.stack([first, after], axis=-1).ravel()
        found.append(np.maximum.reduceat(np.append(line, 0.0), ends)[::2])
    return np.stack(found).reshape(values.shape)
