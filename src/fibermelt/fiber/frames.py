"""How ellipsoids of three axes turn along a path, from any number of frames at once.

The body turns at ``omega = Omega + f_1 D_23 p + f_2 D_31 q + f_3 D_12 r``, with the strain's
components along its axes ``p, q, r`` and the factors of `EllipsoidResponse` (Jeffery 1922, doi
10.1098/rspa.1922.0078), hence

    p_dot = Omega x p + f_3 D_12 q - f_2 D_31 r,    q_dot = Omega x q + f_1 D_23 r - f_3 D_12 p.

No linear map carries it, unlike a spheroid's director (in simple shear it can be chaotic: Yarin,
Gottlieb and Roisman 1997, J. Fluid Mech. 340, 83). Two axes are integrated by the pair of
Dormand and Prince of orders 5 and 4, over each interval of the path for all bodies in so many equal
sub-steps that its own error is within the interval's share of the tolerance, and then set at right
angles again. Between the points the gradient is the cubic of `fibermelt.interpolation`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import RK45

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, ConvergenceError, refuse_other
from fibermelt.fiber.checks import checked_positive, checked_unit
from fibermelt.fiber.ellipsoid import CYCLIC, EllipsoidResponse
from fibermelt.fiber.spatial import EllipsoidMotion, angles_seen_along_z, spin_about_z
from fibermelt.history import FlowHistory
from fibermelt.interpolation import PathInterpolant

__all__ = ["FRAME_TOLERANCE", "follow_ellipsoids"]

Array = NDArray[np.float64]

FRAME_TOLERANCE = 1e-6
"""Sum of the pair's own errors over a path [rad]."""

BLOCK = 1 << 12
"""Bodies taken at a time: their arrays stay in the cache."""

MOST_SUBSTEPS = 1 << 14
"""Sub-steps of an interval: more mean a gradient that is no history."""

ROUNDING = 1e-15
"""An error of a sub-step that no shorter one makes smaller."""

RIGHT = 1e-10
"""Largest cosine of two axes that are taken to be at right angles."""


def follow_ellipsoids(
    path: FlowHistory,
    body: EllipsoidResponse,
    frames: ArrayLike,
    tolerance: float = FRAME_TOLERANCE,
) -> EllipsoidMotion:
    """Follow ellipsoids along a path from all initial orientations at once.

    Parameters
    ----------
    path : FlowHistory
        One path (n points) or several of equal length (leading axes), in the plane or in space.
    body : EllipsoidResponse
        How they turn.
    frames : (n_directions, 3, 3) array_like
        Their axes at the start, one a column: `fibermelt.fiber.even_frames`, `body_axes`.
    tolerance : float
        Of the pair's own errors, summed over the whole path [rad], for the interpolated gradient.
        They are of order four, what is taken is of order five: with the default it was good to
        1e-9 on a path of 1500 points. Bodies that part fast amplify it.

    Raises
    ------
    ConfigError
        If the path is none, the frames are not at right angles and right-handed, or the tolerance
        is not positive.
    ConvergenceError
        If an interval needs more than `MOST_SUBSTEPS` sub-steps.
    """
    refuse_other("path", path, FlowHistory)
    refuse_other("body", body, EllipsoidResponse)
    start = _checked_frames(frames)
    tolerance = checked_positive("tolerance", tolerance, "rad", "1e-6")
    lead, n, k = path.time.shape[:-1], len(path), len(start)
    gradient = path.gradient.reshape(-1, n, 9)
    flow = PathInterpolant(path.time.reshape(-1, n), gradient)
    some = max(1, BLOCK // len(gradient))
    parts = [
        _carried(flow, start[first : first + some], body.shape_factors, tolerance)
        for first in range(0, k, some)
    ]
    p, q, rate = (
        np.concatenate(found, axis=1).reshape(*lead, k, n, 3)
        for found in zip(*(part[:3] for part in parts), strict=True)
    )
    angle, elevation = angles_seen_along_z(p)
    spin = spin_about_z(p, rate)
    most = max(part[3] for part in parts)
    return EllipsoidMotion(start[..., 0], angle, elevation, spin, path, q, most)


def _carried(
    flow: PathInterpolant, start: Array, factors: Array, tolerance: float
) -> tuple[Array, Array, Array, int]:
    """Return first and second axes, the first's rates (m, k, n, 3), and the most sub-steps."""
    m, intervals = flow.step.shape[:2]
    axes = np.empty((intervals + 1, m, 2, 3, len(start)))
    axes[0] = np.moveaxis(start[..., :2], 0, -1).swapaxes(0, 1)
    rates = np.empty_like(axes[:, :, 0])
    rate = _rates(axes[0], flow((slice(None), 0), 0.0), factors)
    rates[0] = rate[:, 0]
    count = most = 1
    for k in range(intervals):
        axes[k + 1], rate, used, error = _interval(
            flow, k, axes[k], rate, factors, count, tolerance / intervals
        )
        rates[k + 1] = rate[:, 0]
        most = max(most, used)
        # of order five: half the sub-steps would have done
        count = used // 2 if error < tolerance / intervals / 64.0 and used > 1 else used
    p, q, turning = (
        np.ascontiguousarray(a.transpose(1, 3, 0, 2)) for a in (axes[:, :, 0], axes[:, :, 1], rates)
    )
    return p, q, turning, most


def _interval(
    flow: PathInterpolant,
    number: int,
    axes: Array,
    rate: Array,
    factors: Array,
    count: int,
    bound: float,
) -> tuple[Array, Array, int, float]:
    """Return axes and rates at an interval's end, how many sub-steps it took, and their error."""
    while count <= MOST_SUBSTEPS:
        end, end_rate, error = axes, rate, 0.0
        for k in range(count):
            end, end_rate, miss = _step(flow, number, end, end_rate, factors, k, count)
            error += miss
            if error > bound + ROUNDING * (k + 1):
                break
        else:
            return _at_right_angles(end), end_rate, count, error
        count *= 2
    msg = (
        f"fiber motion: interval {number + 1} of the path turns too fast or too unevenly for "
        f"{MOST_SUBSTEPS} sub-steps: give the history more points there"
    )
    raise ConvergenceError(msg)


def _step(
    flow: PathInterpolant,
    number: int,
    axes: Array,
    rate: Array,
    factors: Array,
    k: int,
    count: int,
) -> tuple[Array, Array, float]:
    """Return axes and rates after sub-step ``k`` of ``count``, and its largest error [rad]."""
    interval = (slice(None), number)
    h = (flow.step[interval] / count)[:, :, None, None]
    stages = [rate]
    for weights, part in zip(RK45.A[1:], RK45.C[1:], strict=True):
        move = sum(w * stage for w, stage in zip(weights, stages, strict=False))
        stages.append(_rates(axes + h * move, flow(interval, (k + part) / count), factors))
    new = axes + h * sum(b * stage for b, stage in zip(RK45.B, stages, strict=True))
    stages.append(_rates(new, flow(interval, (k + 1.0) / count), factors))
    miss = h * sum(e * stage for e, stage in zip(RK45.E, stages, strict=True))
    return new, stages[-1], float(np.sqrt(np.max(np.sum(miss * miss, axis=2))))


def _rates(axes: Array, gradient: Array, factors: Array) -> Array:
    """Return the rates of two axes (m, 2, 3, k) [1/s] in gradients (m, 9)."""
    L = gradient.reshape(-1, 3, 3)
    T = L.swapaxes(1, 2)
    both = np.concatenate([0.5 * (L + T), 0.5 * (L - T)], axis=1)[:, None] @ axes
    strained, turned = both[:, :, :3], both[:, :, 3:]
    p, q = axes[:, 0], axes[:, 1]
    r = np.empty_like(p)
    for i, (j, k) in enumerate(CYCLIC):
        r[:, i] = p[:, j] * q[:, k] - p[:, k] * q[:, j]
    first = factors[0] * np.einsum("mik,mik->mk", strained[:, 1], r)[:, None]
    second = factors[1] * np.einsum("mik,mik->mk", strained[:, 0], r)[:, None]
    third = factors[2] * np.einsum("mik,mik->mk", strained[:, 0], q)[:, None]
    turned[:, 0] += third * q - second * r
    turned[:, 1] += first * r - third * p
    return np.asarray(turned)


def _at_right_angles(axes: Array) -> Array:
    """Return two axes of length one, the second at right angles to the first."""
    p = axes[:, 0] / np.sqrt(np.sum(axes[:, 0] ** 2, axis=1, keepdims=True))
    q = axes[:, 1] - np.sum(axes[:, 1] * p, axis=1, keepdims=True) * p
    return np.stack([p, q / np.sqrt(np.sum(q * q, axis=1, keepdims=True))], axis=1)


def _checked_frames(frames: ArrayLike) -> Array:
    """Return frames as an array, or refuse what is none."""
    given = real_array("frames", frames)
    if given.ndim != 3 or given.shape[1:] != (3, 3) or len(given) == 0:
        msg = f"frames have shape {given.shape}, expected (n_directions, 3, 3), one or more"
        raise ConfigError(msg)
    axes = checked_unit(np.swapaxes(given, -1, -2), "frames")
    third = np.cross(axes[:, 0], axes[:, 1])
    off = np.linalg.norm(third - axes[:, 2], axis=1)
    if np.any(off > RIGHT):
        k = int(np.argmax(off))
        msg = f"frames[{k}] = {axes[k].T.tolist()}: columns must be at right angles, right-handed"
        raise ConfigError(msg)
    return np.asarray(np.swapaxes(axes, -1, -2))
