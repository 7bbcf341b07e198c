"""Which share of fibers that start isotropic sees less than a level: exactly, at every point.

Fibers that start isotropic in the plane are at the direction of ``F p_0``: the angular central
Gaussian distribution of ``B = F F^T`` (Tyler 1987, doi 10.1093/biomet/74.3.579), which is in the
plane a wrapped Cauchy distribution of twice the angle. With ``phi = 2 (beta - theta)`` the share
in the arc of phases ``mid -+ half`` is

    arg(Y)/pi,    Y = cos(half) - U cos(mid) - V sin(mid) + i S sin(half),
    U + i V = exp(2 i beta) ((B_11 - B_22) - 2 i B_12)/tr B,      S = 2 sqrt(det B)/tr B:

``tan`` of each end's initial angle is a Moebius map of the arc's end, and their difference is this
argument. ``U = V = 0, S = 1`` is the start; ``S`` falls to zero as fibers align. The arguments of
several arcs add up where the ``Y`` are multiplied: the share with ``h < c`` is below ``g`` if
``Im(exp(-i pi g) prod Y) < 0``, smooth in ``c`` however sharply the fibers are aligned.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.level_sets import LevelSets
from fibermelt.fiber.propagator import Propagator
from fibermelt.fiber.roots import bracketed_roots

__all__ = ["Alignment", "alignment", "height_quantiles"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

PLACE = 1e-6
"""Bracket of a level between two nodes, of their distance, which is 1/256 of the range or less:
1e-8 of the largest pressure, as the level sets."""


NARROWEST = 1e-12
"""Spread below which fibers are taken to be that spread [rad]: above the rounding of ``Y``."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """How fibers that started isotropic lie to the stretching at points of a path.

    Parameters
    ----------
    along, across : (...) array
        ``U, V`` [-]: towards the phase 0 (stretched along) and pi/2.
    spread : (...) array
        ``S`` [-]: one where every direction is as likely, near zero where all lie along one.
    """

    along: Array
    across: Array
    spread: Array


def alignment(deformation: Propagator, double: Array) -> Alignment:
    """Return the alignment of fibers that started isotropic.

    Parameters
    ----------
    deformation : Propagator
        ``F`` of the fibers, leading shape (...).
    double : (...) array
        Double angle ``2 beta`` of the stretching direction [rad].
    """
    g = deformation.matrix
    a, b, c, d = g[..., 0, 0], g[..., 0, 1], g[..., 1, 0], g[..., 1, 1]
    first, second = a * a + b * b - c * c - d * d, 2.0 * (a * c + b * d)
    cosine, sine = np.cos(double), np.sin(double)
    return Alignment(
        along=cosine * first + sine * second,
        across=sine * first - cosine * second,
        spread=np.maximum(2.0 * np.exp(-2.0 * deformation.scale), NARROWEST),
    )


def height_quantiles(sets: LevelSets, found: Alignment, shares: Array) -> Array:
    """Return the heights [-] that given shares of fibers lie below, (..., 2, k).

    First of ``h(phi + pi)``, then of ``h(phi)``: a fiber's lowest and highest pressure.

    Parameters
    ----------
    sets : LevelSets
        Of the fiber's support function.
    found : Alignment
        At every point, (...).
    shares : (2, k) array
        ``g`` of either, in [0, 1].
    """
    shape = (*found.spread.shape, *shares.shape)
    if sets.valleys == 0:
        return np.full(shape, sets.highest)
    sign = np.array([-1.0, 1.0])[:, None]
    search = _Search(
        sets,
        np.broadcast_to(shares, shape).ravel(),
        np.broadcast_to(found.along[..., None, None] * sign, shape).ravel(),
        np.broadcast_to(found.across[..., None, None] * sign, shape).ravel(),
        np.broadcast_to(found.spread[..., None, None], shape).ravel(),
    )
    height = sets.level(*search.solved()).reshape(shape)
    # some fiber is in every direction, however few: the ends of the range need no search
    return np.where(shares == 0.0, sets.lowest, np.where(shares == 1.0, sets.highest, height))


class _Search:
    """The search for levels, one for each share and point: first among nodes, then between them."""

    def __init__(
        self, sets: LevelSets, share: Array, along: Array, across: Array, spread: Array
    ) -> None:
        self.sets = sets
        self.along, self.across, self.spread = along, across, spread
        self.cosine, self.sine = np.cos(np.pi * share), -np.sin(np.pi * share)
        # of an arc and its image the first is enough
        image = np.arange(sets.valleys) if sets.image is None else sets.image
        self.chosen = [k for k in range(sets.valleys) if image[k] >= k]
        self.paired = [bool(image[k] > k) for k in self.chosen]
        self.nodes = _arcs(*sets.ends_at_nodes(), self.chosen)

    def solved(self) -> tuple[Index, Array]:
        """Return the intervals and the fractions of them."""
        last = self.sets.intervals
        everyone = np.arange(self.spread.size)
        low, high = np.zeros_like(everyone), np.full_like(everyone, last)
        below, above = self.at_node(low), self.at_node(high)
        for _ in range(math.ceil(math.log2(last))):
            middle = (low + high) >> 1
            value = self.at_node(middle)
            up = value < 0.0
            low, below = np.where(up, middle, low), np.where(up, value, below)
            high, above = np.where(up, high, middle), np.where(up, above, value)
        low = np.minimum(low, last - 1)

        def excess(fraction: Array, at: Index) -> Array:
            return self.value(_arcs(*self.sets.ends(low[at], fraction), self.chosen), at)

        ends = np.zeros(low.shape), np.where(high > low, 1.0, 0.0)
        return low, bracketed_roots(excess, *ends, (below, above), PLACE, smooth=True)

    def at_node(self, node: Index) -> Array:
        """Return ``Im(exp(-i pi g) prod Y)`` of everyone at nodes."""
        return self.value([[part[node] for part in arc] for arc in self.nodes], slice(None))

    def value(self, arcs: list[list[Array]], at: Index | slice) -> Array:
        """Return ``Im(exp(-i pi g) prod Y)`` of some for arcs."""
        real, imaginary = self.cosine[at], self.sine[at]
        along, across, spread = self.along[at], self.across[at], self.spread[at]
        for (cos_half, sin_half, cos_mid, sin_mid), paired in zip(arcs, self.paired, strict=True):
            a, b, odd = cos_half - along * cos_mid, spread * sin_half, across * sin_mid
            if paired:
                # times that of the image, whose middle is the opposite
                a, b = a * a - b * b - odd * odd, 2.0 * a * b
            else:
                a -= odd
            real, imaginary = real * a - imaginary * b, real * b + imaginary * a
        return imaginary


def _arcs(left: list[Array], right: list[Array], chosen: list[int]) -> list[list[Array]]:
    """Return cosine and sine of half width and middle of some arcs."""
    arcs = []
    for k in chosen:
        half, mid = 0.5 * (right[k] - left[k]), 0.5 * (right[k] + left[k])
        arcs.append([np.cos(half), np.sin(half), np.cos(mid), np.sin(mid)])
    return arcs
