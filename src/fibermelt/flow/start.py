"""From the free surfaces of a solved neighbour to a first guess of a new problem's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError
from fibermelt.flow.mesh import Surfaces
from fibermelt.flow.problem import Deposition

__all__ = ["StartShape", "surfaces_from"]

Array = NDArray[np.float64]

SHIFT_OF_GAP, SHIFT_OF_HEIGHT = 2.0, 2.3
"""How far the contact goes downstream per growth of the gap, and upstream per growth of the bead,
there times the ratio ``r`` of gap to bead height. Computed flows with ``r`` from 1 to 1.83: 1.9 to
2.7, and 2.0 to 2.6; both half as much again at 0.87."""

BULGE = (0.4, 2.8, 7.0, 1.5)
"""At the height ``y`` the upstream surface moves by ``(1 - (y/gap)^n)^1.5`` of what its contact
does, ``n = 0.4 + 2.8 r^-7``: a bulging surface as a whole, one drawn down at its foot, none at its
lip. Fitted to flows with ``r`` from 0.95 to 1.8, to 0.1 of the largest move."""

DOWNSTREAM_DECAY, DECAY_GROWTH = 1.2, 1.5
"""The lip's move is felt downstream as ``exp(-1.2 r^1.5 x)``, ``x`` in widths from the lip; fitted
likewise."""

SHORTEST_FOOT = 0.1
"""A guess whose contact lies nearer than this to the outlet [widths] is no guess."""


@dataclass(frozen=True, eq=False)
class StartShape:
    """The free surfaces of a solved deposition flow: what a neighbouring one may start from.

    Width and gap of the nozzle that they belong to are those of their first points, the lips.

    Parameters
    ----------
    upstream : (n, 2) array
        From the left lip to the contact point on the bed [m].
    downstream : (n, 2) array
        From the right lip to the outlet [m].

    Raises
    ------
    ConfigError
        If they are no such curves: too few points, not finite, no common lip height, no contact.
    """

    upstream: Array
    downstream: Array

    def __post_init__(self) -> None:
        """Refuse curves that cannot be the two surfaces of one nozzle."""
        for name in ("upstream", "downstream"):
            curve = getattr(self, name)
            if curve.ndim != 2 or curve.shape[1] != 2 or len(curve) < 4:
                msg = f"start.{name} has shape {curve.shape}: it must be (n, 2) with n of 4 or more"
                raise ConfigError(msg)
            if not np.isfinite(curve).all():
                msg = f"start.{name} has values that are not finite: take the surfaces of a result"
                raise ConfigError(msg)
        left, right = self.upstream[0], self.downstream[0]
        even = abs(left[1] - right[1]) <= 1e-9 * right[1] and abs(left[0] + right[0]) <= 1e-9
        if not (right[0] > 0 and right[1] > 0 and even):
            msg = (
                f"start begins at the lips {tuple(left)} and {tuple(right)}: they must lie at "
                "-W/2 and W/2 at one height above the bed"
            )
            raise ConfigError(msg)

    @property
    def capillary_width(self) -> float:
        """Return the distance of the lips [m]."""
        return float(2 * self.downstream[0, 0])

    @property
    def gap(self) -> float:
        """Return the height of the lips above the bed [m]."""
        return float(self.downstream[0, 1])

    @property
    def bead_height(self) -> float:
        """Return the height of the bead at the outlet [m]."""
        return float(self.downstream[-1, 1])


def surfaces_from(start: StartShape, problem: Deposition) -> Surfaces:
    """Return the surfaces of ``start`` fitted to ``problem``, in capillary widths.

    Heights of the upstream surface scale with the gap; it moves along x with the change of gap
    over bead height, its contact most. The downstream surface moves with the gap at the lip and
    with the bead at the outlet, and is cut or lengthened to the new one.

    Notes
    -----
    The shapes of both moves are fits to flows of this package. The answer does not depend on
    them, the number of steps does.
    """
    nozzle, unit = problem.nozzle, problem.nozzle.capillary_width
    up, down = start.upstream / start.capillary_width, start.downstream / start.capillary_width
    old_gap, old_height = down[0, 1], down[-1, 1]
    gap, height = nozzle.gap / unit, problem.mass_balance_height / unit
    outlet = nozzle.outlet / unit

    x, y = up.T
    ratio = 0.5 * (gap / height + old_gap / old_height)
    foot = SHIFT_OF_GAP * (gap - old_gap) - SHIFT_OF_HEIGHT * ratio * (height - old_height)
    foot = min(foot, outlet - SHORTEST_FOOT - x[-1])
    least, more, fall, rounding = BULGE
    power = least + more * ratio**-fall
    share = (1 - np.clip(y / old_gap, 0.0, 1.0) ** power) ** rounding
    upstream = np.column_stack([x + foot * share, y * (gap / old_gap)])
    x, y = down.T
    rate = DOWNSTREAM_DECAY * ratio**DECAY_GROWTH
    end = np.exp(-rate * (outlet - 0.5))
    decay = (np.maximum(np.exp(-rate * (x - 0.5)), end) - end) / (1 - end)
    y = y + (height - old_height) + ((gap - old_gap) - (height - old_height)) * decay
    if outlet > x[-1]:
        x, y = np.r_[x, outlet], np.r_[y, height]
    inside = x < outlet - 1e-6
    x, y = np.r_[x[inside], outlet], np.r_[y[inside], np.interp(outlet, x, y)]
    downstream = np.column_stack([x, y])
    upstream[0], upstream[-1, 1], downstream[0] = (-0.5, gap), 0.0, (0.5, gap)
    return Surfaces(upstream, downstream)
