"""Which share of fibers that start isotropic ever sees more than a level: exactly, over points.

At a point of the path the fibers that see more than ``c`` are those with ``h(phi) > c/(mu d)``:
arcs of the phase, and by ``F^-1`` arcs of initial angles. A fiber's extreme over the path is above
``c`` if its initial angle lies in one of all points' arcs, so that the share is the length of their
union. Its root in ``c`` is the quantile of the extremes: no fiber is followed, none is sampled.

Points with ``mu d max h < c`` have no arc: most of a path is never looked at.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.level_sets import LevelSets
from fibermelt.fiber.propagator import Propagator
from fibermelt.fiber.roots import bracketed_roots

__all__ = ["Problems", "TurningPoints", "extreme_quantiles", "turning_points"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

STRIDE = 8
"""Points between those of the first search: an eighth of the work, and a bound from below."""

FIRST_STEP = 3e-3
"""Step from that bound to beyond the quantile, over the highest level; grown until it is beyond."""

GROWTH = 4.0
"""Factor of the steps that follow."""

FEW_POINTS = 1 << 12
"""Points up to which a first search costs more than it saves."""

FIRST_TOLERANCE = 1e-3
"""Bracket of the first search over the highest level: it only has to be close."""

LEVEL_TOLERANCE = 1e-9
"""Bracket of a quantile over the highest level: below what the level sets leave."""

PITCH = 8.0
"""Distance of two problems on the line that all arcs are sorted on: above 2 pi, where they end."""


@dataclass(frozen=True, eq=False)
class TurningPoints:
    """What carries initial angles to pressures at points of paths.

    Parameters
    ----------
    amplitude : (n,) array
        ``mu d`` [Pa].
    beta : (n,) array
        Direction of stretching [rad].
    matrix : four (n,) arrays
        ``F^-1`` over the norm of ``F``, by rows.
    determinant : (n,) array
        Its determinant [-].
    """

    amplitude: Array
    beta: Array
    matrix: tuple[Array, Array, Array, Array]
    determinant: Array


@dataclass(frozen=True, eq=False)
class Problems:
    """Quantiles that are asked for, each of an extreme over points of its own.

    Parameters
    ----------
    share : (m,) array
        Share of the fibers below the quantile [-], in [0, 1].
    opposite : (m,) array
        Whether the phase is ``phi + pi``: for the lowest pressure, with its sign turned.
    low : (m,) array
        What the quantile is not below [Pa]; what it is, where no point is left.
    point : (n,) array
        Points that can hold the extreme, in the order of the problems.
    problem : (n,) array
        Which problem they are for, ascending.
    """

    share: Array
    opposite: NDArray[np.bool_]
    low: Array
    point: Index
    problem: Index

    def part(self, chosen: NDArray[np.bool_]) -> Problems:
        """Return the same problems with some of the points."""
        return replace(self, point=self.point[chosen], problem=self.problem[chosen])


def extreme_quantiles(sets: LevelSets, points: TurningPoints, asked: Problems) -> Array:
    """Return the levels [Pa] that the shares asked for never exceed, one for each problem, (m,).

    Parameters
    ----------
    sets : LevelSets
        Of the fiber's support function.
    points : TurningPoints
        All points.
    asked : Problems
        What is asked for.
    """
    amplitude = points.amplitude[asked.point]
    largest = np.zeros(asked.share.size)
    np.maximum.at(largest, asked.problem, amplitude)
    low = np.maximum(asked.low, largest * sets.lowest)
    high = np.maximum(low, largest * sets.highest)
    if sets.valleys == 0:
        return high
    everyone = np.arange(low.size)
    if amplitude.size <= FEW_POINTS:
        whole = _Uncovered(sets, points, asked)
        return whole.root(low, high, (whole(low, everyone), 1.0 - asked.share), LEVEL_TOLERANCE)
    coarse = np.zeros(amplitude.shape, dtype=np.bool_)
    coarse[::STRIDE] = True
    few = _Uncovered(sets, points, asked.part(coarse))
    close = few.root(low, high, (few(low, everyone), 1.0 - asked.share), FIRST_TOLERANCE)
    # fewer points cannot have the higher quantile: with the bracket's width off, a bound from below
    low = np.maximum(low, close - FIRST_TOLERANCE * high)
    # points whose largest pressure is below a level that is passed anyway hold no extreme
    able = amplitude * sets.highest > low[asked.problem]
    whole = _Uncovered(sets, points, asked.part(able))
    return whole.root(*whole.bracket(low, high), LEVEL_TOLERANCE)


class _Uncovered:
    """The share of fibers that never see more than a level, less the share that is asked for."""

    def __init__(self, sets: LevelSets, points: TurningPoints, asked: Problems) -> None:
        self.sets, self.points, self.asked = sets, points, asked
        self.amplitude = points.amplitude[asked.point]
        self.shares = asked.share
        self.start = np.searchsorted(asked.problem, np.arange(asked.share.size + 1))

    def root(self, low: Array, high: Array, ends: tuple[Array, Array], tolerance: float) -> Array:
        """Return the levels at which it vanishes [Pa], to a relative tolerance."""
        return bracketed_roots(self, low, high, ends, tolerance * high)

    def bracket(self, low: Array, high: Array) -> tuple[Array, Array, tuple[Array, Array]]:
        """Return levels on both sides of the root, and the values there, close to ``low``."""
        low, top = np.array(low), np.array(high)
        everyone = np.arange(low.size)
        below = self(low, everyone)
        above = np.where(low < top, 1.0 - self.shares, below)
        step, going = FIRST_STEP, everyone[(below <= 0.0) & (low < top)]
        while going.size:
            level = np.minimum(low[going] + step * top[going], top[going])
            value = self(level, going)
            beyond = (value > 0.0) | (level == top[going])
            high[going], above[going] = level, value
            going, level, value = (part[~beyond] for part in (going, level, value))
            low[going], below[going] = level, value
            step *= GROWTH
        return low, high, (below, above)

    def __call__(self, level: Array, at: Index) -> Array:
        """Return the values for some problems at levels [Pa]."""
        counts = self.start[at + 1] - self.start[at]
        mine = np.repeat(np.arange(at.size), counts)
        row = np.arange(mine.size) + np.repeat(self.start[at] - np.cumsum(counts) + counts, counts)
        height = level[mine] / self.amplitude[row]
        able = height < self.sets.highest
        mine, row, height = mine[able], row[able], height[able]
        parts = self._arcs(self.asked.point[row], self.asked.opposite[at][mine], height, mine)
        begin, end, problem = (np.concatenate(part) for part in zip(*parts, strict=True))
        return _gaps(begin, end, problem, at.size) / np.pi - self.shares[at]

    def _arcs(
        self, point: Index, opposite: NDArray[np.bool_], height: Array, problem: Index
    ) -> list[tuple[Array, Array, Index]]:
        """Return first (in [0, pi)) and last initial angles [rad], and problems, top by top.

        The last follows the first by less than pi: ``cross(F^-1 p, F^-1 q)`` is
        ``det(F^-1) cross(p, q)``, which has no cancellation.
        """
        index, fraction = self.sets.locate(height)
        left, right = self.sets.ends(index, fraction)
        # the phase phi + pi is that of a fiber a quarter turn away
        beta = self.points.beta[point] + np.where(opposite, 0.5 * np.pi, 0.0)
        left.append(left[0] + 2.0 * np.pi)
        found = []
        for k, top in enumerate(self.sets.tops):
            if top == self.sets.highest:
                here: NDArray[np.bool_] | slice = slice(None)
            else:
                here = height < top
            after = left[k + 1][here]
            # the phase is 2 (beta - theta): it falls as the angle grows
            first, width = beta[here] - 0.5 * after, 0.5 * (after - right[k][here])
            found.append((*self._initial(point[here], first, width), problem[here]))
        return found

    def _initial(self, point: Index, first: Array, width: Array) -> tuple[Array, Array]:
        """Return the initial angles [rad] of fibers that are at ``first`` and ``width`` further."""
        a, b, c, d = (part[point] for part in self.points.matrix)
        cosine, sine = np.cos(first), np.sin(first)
        x, y = a * cosine + b * sine, c * cosine + d * sine
        along, across = np.cos(width), np.sin(width)
        cosine, sine = cosine * along - sine * across, sine * along + cosine * across
        forth = x * (a * cosine + b * sine) + y * (c * cosine + d * sine)
        begin = np.arctan2(y, x)
        begin += np.where(begin < 0.0, np.pi, 0.0)
        length = np.arctan2(self.points.determinant[point] * across, forth)
        return begin, begin + np.maximum(length, 0.0)


def _gaps(begin: Array, end: Array, problem: Index, count: int) -> Array:
    """Return the length of [0, pi) that no arc covers, for each problem [rad].

    Arcs that run over the end of the half turn go on at its beginning.
    """
    over = np.zeros(count)
    np.maximum.at(over, problem, end - np.pi)
    shift = PITCH * problem
    order = np.argsort(begin + shift)
    place, last, problem = (begin + shift)[order], (end + shift)[order], problem[order]
    covered = np.empty(place.size)
    covered[:1] = 0.0
    np.maximum.accumulate(last[:-1], out=covered[1:])
    np.maximum(covered, PITCH * problem + over[problem], out=covered)
    gap = np.bincount(problem, np.maximum(place - covered, 0.0), minlength=count)
    # from the last of a problem's arcs to the end of its half turn
    furthest = over.copy()
    np.maximum.at(furthest, problem, last - PITCH * problem)
    return np.asarray(gap + np.maximum(np.pi - furthest, 0.0))


def turning_points(amplitude: Array, beta: Array, deformation: Propagator) -> TurningPoints:
    """Return what carries initial angles to pressures, all points in one row.

    Parameters
    ----------
    amplitude, beta : (...) array
        ``mu d`` [Pa] and the direction of stretching [rad].
    deformation : Propagator
        ``F`` of the fibers, leading shape (...).
    """
    g = deformation.matrix.reshape(-1, 2, 2)
    determinant = np.exp(-2.0 * deformation.scale.ravel())
    first, last = np.ascontiguousarray(g[:, 1, 1]), np.ascontiguousarray(g[:, 0, 0])
    inverse = (first, -g[:, 0, 1], -g[:, 1, 0], last)
    return TurningPoints(amplitude.ravel(), beta.ravel(), inverse, determinant)
