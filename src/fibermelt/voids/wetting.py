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

    With ``m = sin^2(phi/2)`` Eq. 37 is the cubic ``S = m^2 (3 - 2 m)``; with ``S = sin^2 beta`` its
    root between 0 and 1 is ``m = sin(pi/6) - sin(pi/6 - 2 beta/3)``, written here as a product,
    ``2 cos(beta/3 - pi/6) sin(beta/3)``, so that small angles keep their digits.

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
    half_square = 2.0 * np.cos(third - np.pi / 6.0) * np.sin(third)
    angle: Array = 2.0 * np.arcsin(np.sqrt(np.minimum(half_square, 1.0)))
    return angle
