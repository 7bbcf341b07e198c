"""A first guess of a bead's shape: where the nodes of a straight tube lie at first.

Two generators lie in the plane of symmetry: the lower one bends from the upstream lip onto the bed
by a quarter of an ellipse, the upper one falls from the downstream lip to the bead's top. Between
them stand the sections, circles at the exit that become ellipses with a flattened lower half.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.problem import Nozzle

__all__ = ["BeadGuess"]

Array = NDArray[np.float64]

HEIGHT, HEIGHT_PER_GAP = 0.77, 0.5
"""The bead's height for a gap of one and its growth with the gap [diameters], times the root of the
speed ratio over 0.95: computed beads have 0.656, 0.768, 0.857 for gaps of 0.8, 1, 1.2."""

REACH, REACH_PER_GAP, REACH_PER_SPEED = 0.85, 1.3, 0.5
"""How far from the upstream lip the lower generator meets the bed [diameters]; a guess that bends
too wide comes back, one that bends too tightly folds."""

FALL = 0.8
"""Slope at which the upper generator leaves its lip: layers would have no thickness without."""

TOP_IN_BEND = 0.45
"""How far the upper generator comes [diameters] while the lower one bends."""

FULLNESS = 0.834
"""Area over height times width of an ellipse whose lower half is flattened by a third power."""


@dataclass(frozen=True)
class BeadGuess:
    """The guess for a nozzle and a speed ratio.

    Parameters
    ----------
    nozzle : Nozzle
        In diameters of the capillary.
    speed_ratio : float
        Mean speed at the exit over the bed's.
    floor : float
        Height of the lower generator on the bed [diameters].
    """

    nozzle: Nozzle
    speed_ratio: float
    floor: float

    @property
    def height(self) -> float:
        """Return the height at the outlet [diameters]."""
        of_gap = HEIGHT + HEIGHT_PER_GAP * (self.nozzle.gap - 1.0)
        return float(of_gap * np.sqrt(self.speed_ratio / 0.95))

    @property
    def width(self) -> float:
        """Return the width that mass balance leaves to this height [diameters]."""
        return float(np.pi / 4 * self.speed_ratio / (FULLNESS * self.height))

    @cached_property
    def reach(self) -> float:
        """Return how far from the upstream lip the bend ends [diameters]."""
        wider, faster = self.nozzle.gap - 1.0, self.speed_ratio - 0.95
        return REACH + REACH_PER_GAP * wider - REACH_PER_SPEED * faster

    @cached_property
    def _ways(self) -> tuple[float, float]:
        """Return the strand's measure where the bend ends, and at the outlet [diameters]."""
        bend = 0.5 * (np.hypot(self.reach, self.nozzle.gap) * 1.1 + TOP_IN_BEND)
        run = self.nozzle.outlet - 0.5 * (self.reach + TOP_IN_BEND)
        return float(bend), float(bend + run)

    @property
    def stations(self) -> tuple[float, float]:
        """Return the measure at the inlet and at the outlet [diameters]."""
        return self.nozzle.gap - self.nozzle.inlet_height, self._ways[1]

    def _generators(self, along: Array) -> tuple[Array, Array]:
        """Return points (n, 2) of the lower and of the upper one in the plane of symmetry."""
        gap, (bend, end) = self.nozzle.gap, self._ways
        part = np.clip(along / bend, 0.0, 1.0)
        run = np.clip((along - bend) / (end - bend), 0.0, 1.0)
        turn = 0.5 * np.pi * part
        foot = self.reach - 0.5
        lower = np.column_stack(
            [
                foot - self.reach * np.cos(turn) + run * (self.nozzle.outlet - foot),
                gap - (gap - self.floor) * np.sin(turn),
            ]
        )
        x = 0.5 + TOP_IN_BEND * part + run * (self.nozzle.outlet - 0.5 - TOP_IN_BEND)
        drop = gap - self.height
        upper = np.column_stack([x, gap - drop * (1.0 - np.exp(-FALL / abs(drop) * (x - 0.5)))])
        return lower, upper

    def __call__(self, along: Array, across: Array) -> Array:
        """Place nodes of a straight tube (`TubeMap`), in diameters of the capillary."""
        nozzle, above = self.nozzle, np.maximum(-along, 0.0)
        ends = np.array([nozzle.capillary_length, nozzle.capillary_length + nozzle.taper_length])
        radius = 0.5 * np.interp(above, ends, [1.0, nozzle.inlet_width])
        in_nozzle = np.column_stack(
            [radius * across[:, 0], nozzle.gap + above, radius * across[:, 1]]
        )
        blend = _smooth(along / self._ways[0])
        xi, zeta = across[:, 0], across[:, 1]
        r = np.hypot(xi, zeta)
        flat = r / np.maximum(np.cbrt(np.abs(xi) ** 3 + np.abs(zeta) ** 3), 1e-12)
        spread = 1.0 + np.where(xi < 0.0, blend * (flat - 1.0) * r**2, 0.0)
        xi, zeta = xi * spread, zeta * spread
        lower, upper = self._generators(along)
        half = 0.5 + blend * (0.5 * self.width - 0.5)
        plane = 0.5 * (lower + upper) + 0.5 * xi[:, None] * (upper - lower)
        in_strand = np.column_stack([plane, half * zeta])
        return np.where((along <= 0.0)[:, None], in_nozzle, in_strand)


def _smooth(part: Array) -> Array:
    """Return a cubic from 0 to 1 with level ends."""
    t = np.clip(part, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
