"""What goes into a spheroid's cell in a thinning melt and what comes out: plain values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import Unchanging
from fibermelt.errors import ConfigError, refuse_no_count, refuse_no_number

__all__ = ["SpheroidNumerics", "ThinningSpheroid"]

Array = NDArray[np.float64]

ORDERS = (2, 4)
"""Velocity orders: below 2 no Taylor-Hood pair exists, above 4 none was tried."""

ON_PLANE = 1e-9
"""Distance from the flow's plane, over the half-length, of a point that is on it."""


@dataclass(frozen=True)
class SpheroidNumerics:
    """How the quarter of space around a spheroid is divided.

    Parameters
    ----------
    layers, meridian, azimuth : int
        Elements outward, from the tip to the equator, and around the half ``z >= 0``, even.
    order : int
        Of velocity and geometry; the pressure's is one less.
    outer : float
        Largest half-axis of the outer surface over the fiber's half-length [-], above 2: the mean
        pressure there is that of the streamline. At 25 the pressure at the tip differs by 0.1 %.
    first_layer, first_angle : float
        First layer (in ``s``) and first eccentric angle at the tip, over ``1/r_e``, the angle at
        which a tip turns to the side [-], in (0, 1].

    Raises
    ------
    ConfigError
        If a value is out of its range.
    """

    layers: int = 6
    meridian: int = 8
    azimuth: int = 4
    order: int = 3
    outer: float = 10.0
    first_layer: float = 0.08
    first_angle: float = 0.12

    def __post_init__(self) -> None:
        """Refuse what is no division."""
        for name in ("layers", "meridian", "azimuth", "order"):
            refuse_no_count(f"numerics.{name}", getattr(self, name), 2)
        if self.azimuth % 2:
            msg = (
                f"numerics.azimuth = {self.azimuth}: must be even, as half a turn maps it on itself"
            )
            raise ConfigError(msg)
        if not ORDERS[0] <= self.order <= ORDERS[1]:
            msg = f"numerics.order = {self.order}: must lie in {ORDERS[0]} to {ORDERS[1]}"
            raise ConfigError(msg)
        for name, low, high in (
            ("outer", 2.0, np.inf),
            ("first_layer", 0.0, 1.0),
            ("first_angle", 0.0, 1.0),
        ):
            value = getattr(self, name)
            refuse_no_number(f"numerics.{name}", value)
            if not (low < value <= high and np.isfinite(value)):
                msg = f"numerics.{name} = {value:g}: must lie above {low:g}, at most {high:g}"
                raise ConfigError(msg)


@dataclass(frozen=True, eq=False)
class ThinningSpheroid(Unchanging):
    """What a free spheroid answers to one planar strain in its axis' plane.

    Pressures are over ``eta(gamma_dot) d`` with ``d = gamma_dot/2`` [-], above the far field's.
    Places are eccentric vectors ``x_i/a_i`` of length one: the fiber along the first axis, the
    flow's plane those of the first two; ``-e`` and the mirrored ``(e_1, e_2, -e_3)`` see the same.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-].
    rate, phase : float
        ``gamma_dot`` [1/s]; ``phi`` [rad], ``D_11 = d cos phi``, ``D_12 = d sin phi``.
    spin : float
        Torque-free spin relative to the melt's over ``d`` [-].
    places : (m, 3) array
        Where the surface was read, ``e_1 >= 0``, ``e_3 >= 0``.
    pressure : (m,) array
        The pressure there.
    unknowns, steps : int
        Unknowns of velocity and pressure; Newton steps.
    """

    aspect_ratio: float
    rate: float
    phase: float
    spin: float
    places: Array
    pressure: Array
    unknowns: int
    steps: int

    @property
    def lowest(self) -> float:
        """Return the lowest pressure over the surface."""
        return float(np.min(self.pressure))

    @property
    def highest(self) -> float:
        """Return the highest pressure over the surface."""
        return float(np.max(self.pressure))

    @property
    def where_lowest(self) -> Array:
        """Return the place of the lowest pressure."""
        return np.asarray(self.places[np.argmin(self.pressure)])

    @property
    def where_highest(self) -> Array:
        """Return the place of the highest pressure."""
        return np.asarray(self.places[np.argmax(self.pressure)])

    @property
    def tip(self) -> float:
        """Return the pressure at the tip."""
        return float(self.pressure[np.argmax(self.places[:, 0])])

    def meridian(self) -> tuple[Array, Array]:
        """Return eccentric angles in (-pi/2, pi/2] [rad] and pressures in the flow's plane."""
        on = np.abs(self.places[:, 2]) <= ON_PLANE
        angle = np.arctan2(self.places[on, 1], self.places[on, 0])
        order = np.unique(np.round(angle, 12), return_index=True)[1]
        return angle[order], self.pressure[on][order]
