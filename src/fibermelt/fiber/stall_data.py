"""Shape factor and stall angle against the size of the cell, as a value without finite elements."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from fibermelt.arrays import Unchanging, real_array
from fibermelt.errors import ConfigError, refuse_no_number

__all__ = ["StallCurve", "domain_of", "fit_curve", "narrowness"]

Array = NDArray[np.float64]

SCAN = 400
"""Intervals in which roots are looked for: ``B`` has but a dozen points."""


@dataclass(frozen=True, eq=False)
class StallCurve(Unchanging):
    """Shape factor and stall angle of one fiber against the size of its cell.

    Parameters
    ----------
    fiber_aspect_ratio : float
        ``r_e`` [-].
    domain_size : (k,) array
        ``M`` of the points, increasing; the last may be infinite, the unbounded melt.
    shape_factor : (k,) array
        ``B`` there [-].
    error : float
        Estimated error of ``B`` between the points [-], cells and interpolation.

    Raises
    ------
    ConfigError
        If there are fewer than two points, shapes differ, or ``M`` does not increase from above 2.
    """

    fiber_aspect_ratio: float
    domain_size: Array
    shape_factor: Array
    error: float

    def __post_init__(self) -> None:
        """Take the numbers over, and refuse what is no curve."""
        for name in ("domain_size", "shape_factor"):
            owned = np.array(real_array(f"stall curve: {name}", getattr(self, name)))
            object.__setattr__(self, name, owned)
        super().__post_init__()
        M = self.domain_size
        if M.ndim != 1 or M.size < 2 or M.shape != self.shape_factor.shape:
            msg = f"stall curve: {M.shape} domain sizes, {self.shape_factor.shape} shape factors"
            raise ConfigError(msg)
        if not (M[0] > 2.0 and np.all(M[1:] > M[:-1])):
            msg = f"stall curve: domain sizes must increase from above 2, got {M.tolist()}"
            raise ConfigError(msg)

    @cached_property
    def coefficients(self) -> Array:
        """Return the Chebyshev coefficients of ``B`` in ``s``, scaled to [-1, 1]."""
        return fit_curve(self._scaled(self.domain_size), self.shape_factor)

    def value(self, domain_size: ArrayLike) -> Array:
        """Return ``B`` [-] at domain sizes ``M``, the curve's smallest to its largest.

        Raises
        ------
        ConfigError
            If a domain size is not on the curve.
        """
        M = real_array("fiber.domain_size", domain_size)
        low, high = self.domain_size[0], self.domain_size[-1]
        inside = (low <= M) & (high >= M)
        if not np.all(inside):
            first = float(M[~inside].flat[0])
            msg = (
                f"fiber.domain_size = {first:g}: the stall curve runs from {low:g} to {high:g}; "
                "build it with another smallest_domain, above 2"
            )
            raise ConfigError(msg)
        return np.asarray(chebyshev.chebval(self._scaled(M), self.coefficients))

    def stall_angle(self, domain_size: ArrayLike) -> Array:
        """Return the stall angle from the flow [rad] at domain sizes, NaN where the fiber tumbles.

        ``theta = arccos(1/B)/2``: where ``B`` is just above one its error is that of ``B`` over
        ``2 sin 2 theta``.

        Raises
        ------
        ConfigError
            As `value`.
        """
        B = self.value(domain_size)
        stalls = B >= 1.0
        angle = 0.5 * np.arccos(1.0 / np.where(stalls, B, 1.0))
        return np.where(stalls, angle, np.nan)

    @cached_property
    def largest_stalling_domain(self) -> float:
        """Return the ``M`` at which ``B = 1`` [-]: in larger cells the fiber tumbles.

        Raises
        ------
        ConfigError
            If it tumbles, or stalls, in all cells of the curve.
        """
        M = self._largest_with(1.0)
        if M is None:
            low, high = self.domain_size[0], self.domain_size[-1]
            first, last = self.shape_factor[0], self.shape_factor[-1]
            does = "stalls" if last > 1.0 else "tumbles"
            msg = (
                f"a fiber of r_e = {self.fiber_aspect_ratio:g} {does} in every cell from M = "
                f"{low:g} (B = {first:.4f}) to {high:g} (B = {last:.4f}): there is no largest "
                "domain with a stall; "
            )
            msg += "take a larger M" if last > 1.0 else "take a smaller M or a longer fiber"
            raise ConfigError(msg)
        return M

    def domain_size_at(self, angle: float) -> float:
        """Return the ``M`` [-] at which the fiber stalls at an angle; the largest if several.

        Parameters
        ----------
        angle : float
            From the flow [rad], at least zero and below pi/4.

        Raises
        ------
        ConfigError
            If no cell of the curve stalls the fiber there.
        """
        refuse_no_number("stall angle", angle)
        if not 0.0 <= angle < 0.25 * math.pi:
            msg = f"stall angle = {angle:g} rad: must be at least 0 and below pi/4, B is finite"
            raise ConfigError(msg)
        M = self._largest_with(1.0 / math.cos(2.0 * angle))
        if M is None:
            reached = self.stall_angle(self._scan())
            what = (
                "tumbles in every cell: take a longer fiber"
                if np.all(np.isnan(reached))
                else f"stalls at up to {np.nanmax(reached):.4f} rad: less interaction (a smaller "
                "C_I) makes the angle smaller"
            )
            msg = (
                f"stall angle = {angle:.4f} rad: no cell stalls a fiber of r_e = "
                f"{self.fiber_aspect_ratio:g} there; from M = {self.domain_size[0]:g} on it {what}"
            )
            raise ConfigError(msg)
        return M

    def _scaled(self, M: Array) -> Array:
        s = narrowness(M)
        low, high = narrowness(self.domain_size[[0, -1]])
        return np.asarray((2.0 * s - low - high) / (high - low))

    def _scan(self) -> Array:
        """Return domain sizes evenly over ``s``, largest first; the ends are the curve's own."""
        high, low = narrowness(self.domain_size[[-1, 0]])
        s = np.linspace(high, low, SCAN + 1)
        M = domain_of(s)
        M[0], M[-1] = self.domain_size[-1], self.domain_size[0]
        return M

    def _largest_with(self, shape_factor: float) -> float | None:
        """Return the largest ``M`` with this ``B``, None if there is none."""
        M = self._scan()
        excess = self.value(M) - shape_factor
        change = np.flatnonzero((excess[:-1] < 0.0) != (excess[1:] < 0.0))
        if change.size == 0:
            return None
        k = change[0]
        s = narrowness(M[[k, k + 1]])
        root = brentq(
            lambda x: float(chebyshev.chebval(x, self.coefficients)) - shape_factor,
            *self._scaled(domain_of(s)),
        )
        low, high = narrowness(self.domain_size[[0, -1]])
        return float(domain_of(np.asarray(0.5 * (low + high + (high - low) * root))))


def narrowness(M: Array) -> Array:
    """Return ``s = sqrt(1 - (2/M)^2)``, one for an infinite cell."""
    return np.asarray(np.sqrt(1.0 - (2.0 / M) ** 2))


def domain_of(s: Array) -> Array:
    """Return ``M = 2/sqrt(1 - s^2)``."""
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 / np.sqrt((1.0 - s) * (1.0 + s)))


def fit_curve(nodes: Array, values: Array) -> Array:
    """Return the Chebyshev coefficients of the polynomial through all points."""
    return np.asarray(chebyshev.chebfit(nodes, values, nodes.size - 1))
