"""The fiber's shape: an ellipse in the plane of the flow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fibermelt.errors import ConfigError, refuse_no_number
from fibermelt.fiber.checks import checked_positive

__all__ = ["Ellipse", "jeffery_factor"]


def jeffery_factor(aspect_ratio: float) -> float:
    """Return Jeffery's shape factor ``xi = (r_e^2 - 1)/(r_e^2 + 1)`` [-].

    Parameters
    ----------
    aspect_ratio : float
        Length over width ``r_e`` of the ellipse, positive; below one gives the negative of its
        inverse's factor.

    Raises
    ------
    ConfigError
        If the aspect ratio is not positive and finite.

    References
    ----------
    Jeffery 1922, doi 10.1098/rspa.1922.0078; below Eq. 23 of the paper.
    """
    ratio = checked_positive("fiber.aspect_ratio", aspect_ratio, "", "6")
    square = ratio * ratio
    # beyond 1e154 the square overflows: 1 is then right to the last bit, as it is from 1e9 on
    return (square - 1.0) / (square + 1.0) if square < math.inf else 1.0


@dataclass(frozen=True)
class Ellipse:
    """A rigid fiber: an ellipse, which is an infinite elliptic cylinder seen along its axis.

    Parameters
    ----------
    half_length : float
        Semi-major axis ``a`` [m], positive. It sets no pressure: Stokes flow has no scale.
    aspect_ratio : float
        ``r_e = a/b`` [-], at least one (one is the circle).

    Raises
    ------
    ConfigError
        If the half-length is not positive or the aspect ratio is below one or not finite.
    """

    half_length: float
    aspect_ratio: float

    def __post_init__(self) -> None:
        """Refuse what is no fiber."""
        refuse_no_number("fiber.half_length", self.half_length)
        refuse_no_number("fiber.aspect_ratio", self.aspect_ratio)
        if not (np.isfinite(self.half_length) and self.half_length > 0):
            msg = f"fiber.half_length = {self.half_length:g} m: must be positive, e.g. 42e-6"
            raise ConfigError(msg)
        if not (np.isfinite(self.aspect_ratio) and self.aspect_ratio >= 1):
            msg = (
                f"fiber.aspect_ratio = {self.aspect_ratio:g}: must be at least 1 (length over "
                "width); for a fiber lying across give its inverse and turn the angles by 90 deg"
            )
            raise ConfigError(msg)

    @property
    def semi_minor(self) -> float:
        """Return ``b = a/r_e`` [m]."""
        return self.half_length / self.aspect_ratio

    @property
    def jeffery_factor(self) -> float:
        """Return ``xi`` [-], the spin's answer to strain in an unbounded melt."""
        return jeffery_factor(self.aspect_ratio)
