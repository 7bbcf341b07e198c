"""The wetting factor of a barrier, S(phi), and back (the paper's Eq. 37)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.voids.checks import checked_range

__all__ = ["vapor_angle", "wetting_factor"]

Array = NDArray[np.float64]


def wetting_factor(angle: ArrayLike) -> Array:
    """Return ``S = (2 + cos phi)(1 - cos phi)^2 / 4`` [-] (the paper's Eq. 37).

    What a flat solid leaves of the homogeneous barrier.

    Parameters
    ----------
    angle : (...,) array_like
        ``phi`` [rad], 0 to pi, **through the vapor**: pi where the melt spreads on the solid, which
        then does not help (S = 1), zero where it does not wet it at all (S = 0). Young's contact
        angle through the melt is ``pi - phi``.

    Raises
    ------
    ConfigError
        If an angle is outside 0 to pi.
    """
    phi = checked_range("vapor angle", angle, (0.0, np.pi), "rad", "90 deg is 1.5708 rad")
    # 1 - cos phi as a square of a sine: S keeps its digits at small angles.
    missing = 2.0 * np.sin(0.5 * phi) ** 2
    factor: Array = 0.25 * (3.0 - missing) * missing**2
    return factor


def vapor_angle(factor: ArrayLike) -> Array:
    """Return the angle through the vapor [rad] of a wetting factor, the inverse of Eq. 37.

    With ``c = cos phi`` Eq. 37 is ``c^3 - 3 c + 2 = 4 S``, whose root in [-1, 1] is
    ``c = 2 cos((arccos(2 S - 1) + 4 pi)/3)``. With ``S = sin^2 beta`` and ``1 - c = 2 m`` that is
    ``m = sin(2 beta/3 + pi/6) - 1/2``, written here as a product so that small angles keep digits.

    Parameters
    ----------
    factor : (...,) array_like
        ``S`` [-], from 0 to 1.

    Raises
    ------
    ConfigError
        If a factor is outside 0 to 1.
    """
    S = checked_range("wetting factor", factor, (0.0, 1.0))
    third = np.arcsin(np.sqrt(S)) / 3.0
    half_square = 2.0 * np.cos(third + np.pi / 6.0) * np.sin(third)
    angle: Array = 2.0 * np.arcsin(np.sqrt(np.minimum(half_square, 1.0)))
    return angle
