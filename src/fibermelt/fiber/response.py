"""What a fiber answers to any planar flow: two pressure curves and one shape factor.

In a Newtonian melt the flow around a rigid fiber is linear in the strain it meets. In the fiber's
axes (x along the fiber) the surface pressure over the melt's own is

    p(s) - p_psi = mu (D_11 P_1(s) + D_12 P_2(s)),        D_12 the tensor component [1/s],

and the fiber turns at ``W_21 + B D_12``. With ``(D_11, D_12) = d (cos phi, sin phi)`` the largest
surface pressure is ``mu d h(phi)`` and the lowest ``-mu d h(phi + pi)``, where

    h(phi) = max_s (cos phi P_1(s) + sin phi P_2(s))

is the support function of the closed curve ``s -> (P_1, P_2)``: one angle decides it all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import Unchanging, real_array
from fibermelt.errors import ConfigError
from fibermelt.fiber.checks import checked_number
from fibermelt.fiber.curve import TrigonometricCurve
from fibermelt.fiber.support import SupportFunction
from fibermelt.shown import Shown

__all__ = ["FiberResponse"]

Array = NDArray[np.float64]

SYMMETRY_TOLERANCE = 1e-9
"""Largest difference of ``P(s)`` and ``P(s + pi)`` over the largest pressure: rounding."""

FEWEST_SURFACE_POINTS = 16
"""Surface points below which not even the circle's ``cos 2s`` would have room to spare."""


@dataclass(frozen=True, eq=False, repr=False)
class FiberResponse(Shown, Unchanging):
    """The linear response of a force- and torque-free fiber to the strain around it.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], at least one.
    shape_factor : float
        ``B`` [-]: the fiber turns at ``W_21 + B D_12`` (``xi`` when unbounded; above one it stalls
        in simple shear).
    surface : (m,) array
        Eccentric angles ``2 pi j/m`` [rad] of the surface points ``(a cos s, b sin s)``; ``m``
        even and more than twice the highest harmonic of the pressure.
    basis : (m, 2) array
        ``P_1, P_2`` at these angles [-], the same at ``s`` and ``s + pi``.

    Raises
    ------
    ConfigError
        If shapes disagree, a value is not finite, the angles are not the uniform ones or the basis
        lacks the fiber's symmetry.

    Notes
    -----
    The arrays are copies, and read-only: the curve and its support function are made once.
    """

    aspect_ratio: float
    shape_factor: float
    surface: Array
    basis: Array

    def __post_init__(self) -> None:
        """Take the numbers over, and refuse what no fiber answers."""
        for name in ("surface", "basis"):
            owned = np.array(real_array(f"response: {name}", getattr(self, name)))
            object.__setattr__(self, name, owned)
        super().__post_init__()
        m = self.surface.size
        if self.surface.shape != (m,) or m < FEWEST_SURFACE_POINTS or m % 2:
            msg = (
                f"response: surface has shape {self.surface.shape}, expected (m,) with m even and "
                f"at least {FEWEST_SURFACE_POINTS}"
            )
            raise ConfigError(msg)
        if self.basis.shape != (m, 2):
            msg = f"response: basis has shape {self.basis.shape}, expected {(m, 2)} like surface"
            raise ConfigError(msg)
        checked_number("response: aspect_ratio", self.aspect_ratio)
        checked_number("response: shape_factor", self.shape_factor)
        if not np.all(np.isfinite(self.basis)):
            msg = "response: basis must be finite"
            raise ConfigError(msg)
        if self.aspect_ratio < 1:
            msg = f"response: aspect_ratio = {self.aspect_ratio:g} must be at least 1"
            raise ConfigError(msg)
        uniform = 2.0 * np.pi * np.arange(m) / m
        if not np.allclose(self.surface, uniform, rtol=0.0, atol=1e-12):
            msg = f"response: surface must be the angles 2 pi j/{m}, j = 0..{m - 1}"
            raise ConfigError(msg)
        half = m // 2
        asymmetry = float(np.max(np.abs(self.basis[:half] - self.basis[half:])))
        if asymmetry > SYMMETRY_TOLERANCE * float(np.max(np.abs(self.basis))):
            msg = (
                f"response: basis differs by {asymmetry:.3g} between s and s + pi; the ends of a "
                "centred fiber see the same pressure"
            )
            raise ConfigError(msg)

    def told(self) -> dict[str, str]:
        """Return the fiber and how it answers."""
        stall = self.stall_angle
        return {
            "aspect ratio": f"{self.aspect_ratio:.4g}",
            "shape factor": f"{self.shape_factor:.5g}",
            "tip pressure": f"{self.tip_pressure:.4g} mu gamma_dot",
            "in simple shear": "it tumbles"
            if stall is None
            else f"it stalls at {math.degrees(stall):.2f} deg",
        }

    @cached_property
    def curve(self) -> TrigonometricCurve:
        """Return ``s -> (P_1, P_2)`` as a trigonometric interpolant with its derivatives."""
        return TrigonometricCurve(self.basis)

    @cached_property
    def support(self) -> SupportFunction:
        """Return the support function ``h`` with its extremes [-]."""
        return SupportFunction(self.curve)

    @property
    def tip(self) -> Array:
        """Return ``P_1, P_2`` at the tip ``s = 0`` [-], shape (2,)."""
        return np.array(self.basis[0])

    @property
    def tip_pressure(self) -> float:
        """Return the largest surface pressure in simple shear over ``mu gamma_dot`` [-].

        Simple shear strains at ``d = gamma_dot/2``, so over every orientation (an orbit if the
        fiber tumbles, half a turn if it stalls) it is half the largest ``h``. An unbounded ellipse
        has ``1 + r_e`` (Jeffery 1922, the paper's Eq. 25).
        """
        return 0.5 * self.curve.farthest

    @property
    def stall_angle(self) -> float | None:
        """Return where the fiber stalls in simple shear [rad], None if it tumbles.

        ``theta_dot = (gamma_dot/2)(B cos 2 theta - 1)`` vanishes at ``cos 2 theta = 1/B``; the
        positive root attracts for ``u_x = gamma_dot y`` (the paper's Eq. 32 and Fig. 14c).
        """
        factor = self.shape_factor
        return 0.5 * float(np.arccos(1.0 / factor)) if factor >= 1.0 else None
