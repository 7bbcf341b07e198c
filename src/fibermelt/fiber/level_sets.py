"""Where the support function lies below a level: arcs of the phase, one around each valley.

Between two neighbouring heights at which an arc begins, ends or has a kink (the minima, maxima and
corners of ``h``) the level runs as ``c = low + (high - low) sin^2(pi u/2)``: that takes the square
roots out of the arcs' ends, which are then smooth in ``u`` and go through cubic splines.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from fibermelt.errors import ConvergenceError
from fibermelt.fiber.roots import bracketed_roots
from fibermelt.fiber.support import SupportFunction

__all__ = ["LevelSets", "level_sets"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

HUMP = 1e-6
"""Smallest rise of ``h`` from a valley to the next top, over its largest value: the finite elements
leave 1e-5. A circle, all of whose humps are rounding, has none."""

LEVEL_TOLERANCE = 1e-8
"""Error of ``h`` at the arcs' ends over its largest value: that of the support function's table."""

FEWEST_NODES = 256
MOST_NODES = 1 << 14
"""Nodes of the splines between two heights: doubled until the tolerance is met."""

REFINED = 32
"""Subdivisions of an interval that holds a minimum or maximum, per round."""

ROUNDS = 6
"""Rounds of it: three knots' spacings over ``16^6`` are below the rounding of the place, 1e-8."""

PLACE = 1e-10
"""Last step to an arc's end [rad], below the tolerance: ``|h'|`` is at most the largest ``h``."""


SAME_HEIGHT = 1e-9
"""Difference of two heights over the largest that is taken for none, below the tolerance."""


@dataclass(frozen=True)
class _Turn:
    """A valley or a top of the support function: its phase [rad] and height [-]."""

    place: float
    height: float
    valley: bool


@dataclass(frozen=True, eq=False)
class LevelSets:
    """Arcs of the phase on which ``h < c``, for every level ``c``.

    Parameters
    ----------
    lowest, highest : float
        Smallest and largest ``h`` [-].
    heights : (k + 1,) array
        Heights between which the arcs' ends are smooth [-].
    nodes : int
        Intervals of the splines between two heights.
    splines : (4, k nodes, v or 2 v) array
        Coefficients of the arcs' right and left ends [rad] in the fraction of an interval, the
        highest power first, ``v`` valleys. A circle has none: ``h`` is one number. Where ``h`` is
        even the left ends are images of right ends, and left out.
    tops : (v,) array
        Height of the top that follows each valley [-].
    image : (v,) array or None
        For an even ``h``, which arc is an arc's image at the opposite phases.
    mirrors : (v,) array
        Then, the sum [rad] of a left end and the right end that is its image: whole turns.
    """

    lowest: float
    highest: float
    heights: Array
    nodes: int
    splines: Array
    tops: Array
    image: Index | None = None
    mirrors: Array | None = None

    @property
    def valleys(self) -> int:
        """Return the number of arcs."""
        return len(self.tops)

    @property
    def intervals(self) -> int:
        """Return the number of intervals."""
        return int(self.splines.shape[1])

    def ends_at_nodes(self) -> tuple[list[Array], list[Array]]:
        """Return the arcs' left and right ends [rad] at every node, v arrays each."""
        last = self.splines[:, -1].sum(axis=0)
        return self._both(list(np.ascontiguousarray(np.vstack([self.splines[3], last]).T)))

    def ends(self, index: Index, fraction: Array) -> tuple[list[Array], list[Array]]:
        """Return the arcs' left and right ends [rad] inside given intervals, v arrays (m,) each."""
        found = []
        for column in range(self.splines.shape[-1]):
            third, second, first, value = self.splines[:, :, column]
            x = third[index] * fraction
            x += second[index]
            x *= fraction
            x += first[index]
            x *= fraction
            x += value[index]
            found.append(x)
        return self._both(found)

    def _both(self, found: list[Array]) -> tuple[list[Array], list[Array]]:
        """Return left and right ends from those that the splines give."""
        right = found[: self.valleys]
        if self.image is None or self.mirrors is None:
            return found[self.valleys :], right
        pairs = zip(self.image, self.mirrors, strict=True)
        return [turns - right[other] for other, turns in pairs], right

    def level(self, index: Index, fraction: Array) -> Array:
        """Return the level [-] inside given intervals, (m,)."""
        part, step = np.divmod(index, self.nodes)
        rise = np.sin((step + fraction) * (0.5 * np.pi / self.nodes))
        low = self.heights[part]
        return np.asarray(low + (self.heights[part + 1] - low) * rise * rise)

    def locate(self, level: Array) -> tuple[Index, Array]:
        """Return interval and fraction of given levels [-], held to the range of ``h``."""
        part = np.searchsorted(self.heights[1:-1], level, side="right")
        low = self.heights[part]
        share = np.clip((level - low) / (self.heights[part + 1] - low), 0.0, 1.0)
        scaled = np.arcsin(np.sqrt(share)) * (self.nodes * 2.0 / np.pi)
        step = np.minimum(scaled.astype(np.intp), self.nodes - 1)
        return part * self.nodes + step, scaled - step


def level_sets(support: SupportFunction) -> LevelSets:
    """Return the arcs below every level of a support function.

    Parameters
    ----------
    support : SupportFunction
        Of any number of valleys; humps below `HUMP` of the largest value are left out.

    Raises
    ------
    ConvergenceError
        If the splines do not reach `LEVEL_TOLERANCE` with `MOST_NODES` nodes.
    """
    turns = _turns(support)
    values = [turn.height for turn in turns] or [support.largest]
    lowest, highest = min(values), max(values)
    if len(turns) < 2:
        none = np.zeros((4, 1, 0)), np.zeros(0)
        return LevelSets(lowest, highest, np.array([lowest, highest]), 1, *none)
    heights = _heights(np.concatenate([values, support.corner_heights()]), lowest, highest)
    nodes = FEWEST_NODES
    while True:
        found = _splined(support, turns, heights, nodes)
        error = _error(support, found)
        if error <= LEVEL_TOLERANCE * highest:
            return found
        if nodes >= MOST_NODES:
            msg = (
                f"level sets: error {error / highest:.1e} of the largest pressure, bound "
                f"{LEVEL_TOLERANCE:g}: the surface pressure is too rough, refine the cell"
            )
            raise ConvergenceError(msg)
        nodes *= 2


def _turns(support: SupportFunction) -> list[_Turn]:
    """Return valleys and tops of ``h`` in turn, a valley first; none or one for a circle."""
    step = 2.0 * np.pi / support.knots
    falling = support.slopes < 0.0
    at = np.nonzero(falling != np.roll(falling, -1))[0]
    valley = falling[at]
    sign, rows = np.where(valley, 1.0, -1.0)[:, None], np.arange(at.size)
    place, height, half = (at + 0.5) * step, np.zeros(at.size), 1.5 * step
    for _ in range(ROUNDS):
        phase = place[:, None] + half * np.linspace(-1.0, 1.0, REFINED + 1)
        heights = support(phase)
        best = np.argmin(sign * heights, axis=1)
        place, height = phase[rows, best], heights[rows, best]
        half *= 2.0 / REFINED
    turns = [_Turn(*turn) for turn in zip(place, height, valley, strict=True)]
    while len(turns) > 1:
        rises = [abs(turns[k].height - turns[k - 1].height) for k in range(len(turns))]
        least = int(np.argmin(rises))
        if rises[least] > HUMP * support.largest:
            break
        for k in sorted({least, (least - 1) % len(turns)}, reverse=True):
            del turns[k]
    if turns and not turns[0].valley:
        first = turns.pop(0)
        turns.append(_Turn(first.place + 2.0 * np.pi, first.height, first.valley))
    return _even(turns) if support.even and turns else turns


def _even(turns: list[_Turn]) -> list[_Turn]:
    """Return the turns at places that are images of each other to rounding.

    A turn's place is known to the root of the rounding only: arcs and their images would not meet.
    """
    place = np.array([turn.place for turn in turns])
    image, total = _images(place)
    place = 0.5 * (place + total - place[image])
    return [replace(turn, place=float(p)) for turn, p in zip(turns, place, strict=True)]


def _heights(values: Array, lowest: float, highest: float) -> Array:
    """Return the heights between which the arcs' ends are smooth, near ones taken as one."""
    inside = np.sort(values[(values > lowest) & (values < highest)])
    kept = [lowest]
    for value in inside:
        if value - kept[-1] > SAME_HEIGHT * highest:
            kept.append(float(value))
    if highest - kept[-1] <= SAME_HEIGHT * highest and len(kept) > 1:
        kept.pop()
    return np.array([*kept, highest])


def _splined(support: SupportFunction, turns: list[_Turn], heights: Array, nodes: int) -> LevelSets:
    """Return the level sets with a given number of nodes between two heights."""
    rise = np.sin(np.linspace(0.0, 0.5 * np.pi, nodes + 1)) ** 2
    low = heights[:-1, None]
    level = low + (heights[1:, None] - low) * rise
    before = _Turn(turns[-1].place - 2.0 * np.pi, turns[-1].height, valley=False)
    around = [before, *turns]
    valleys = range(1, len(around), 2)
    sides = [(around[k], around[k + 1]) for k in valleys]
    image, mirrors = None, None
    if support.even:
        image, mirrors = _images(np.array([around[k].place for k in valleys]))
    else:
        sides += [(around[k], around[k - 1]) for k in valleys]
    ends = _ends(support, sides, level.ravel()).reshape(*level.shape, len(sides))
    u = np.arange(nodes + 1.0)
    splines = np.concatenate([CubicSpline(u, part).c for part in ends], axis=1)
    tops = np.array([around[k + 1].height for k in valleys])
    lowest, highest = float(heights[0]), float(heights[-1])
    return LevelSets(lowest, highest, heights, nodes, splines, tops, image, mirrors)


def _images(place: Array) -> tuple[Index, Array]:
    """Return which place is each one's image at the opposite phase, and their sum, whole turns."""
    total = (place[:, None] + place) / (2.0 * np.pi)
    image = np.argmin(np.abs(total - np.round(total)), axis=1)
    return image, 2.0 * np.pi * np.round(total[np.arange(place.size), image])


def _ends(support: SupportFunction, sides: list[tuple[_Turn, _Turn]], level: Array) -> Array:
    """Return where ``h`` passes levels from valleys to tops, held to the two [rad], (m, sides)."""
    step = 2.0 * np.pi / support.knots
    brackets = []
    for valley, top in sides:
        first, last = sorted((valley.place, top.place))
        knots = step * np.arange(np.floor(first / step) + 1.0, np.ceil(last / step))
        # from the valley to the top; a knot on a turn itself is that turn
        knots = knots[(knots > first) & (knots < last)][:: 1 if valley.place < top.place else -1]
        place = np.concatenate([[valley.place], knots, [top.place]])
        height = np.concatenate([[valley.height], support(knots), [top.height]])
        height = np.maximum.accumulate(height)
        held = np.clip(level, height[0], height[-1])
        after = np.clip(np.searchsorted(height, held), 1, height.size - 1)
        brackets.append(
            (place[after - 1], place[after], height[after - 1] - held, height[after] - held, held)
        )
    low, high, below, above, goal = (np.concatenate(part) for part in zip(*brackets, strict=True))

    def excess(phase: Array, at: Index) -> Array:
        return np.asarray(support(phase) - goal[at])

    found = bracketed_roots(excess, low, high, (below, above), PLACE, smooth=True)
    return np.asarray(found.reshape(len(sides), -1).T)


def _error(support: SupportFunction, found: LevelSets) -> float:
    """Return the largest error of ``h`` at the arcs' ends half-way between the nodes [-].

    Left out are ends at rest, on a turn, and at a corner, where the table's branches need not meet.
    """
    index = np.arange(found.intervals)
    half = np.full(index.size, 0.5)
    level = found.level(index, half)
    error = 0.0
    pairs = zip(found.ends(index, half), found.ends_at_nodes(), strict=True)
    for end, side in (pair for both in pairs for pair in zip(*both, strict=True)):
        counted = (side[1:] != side[:-1]) & ~support.near_corner(end)
        error = max(error, float(np.max(np.abs(support(end) - level)[counted], initial=0.0)))
    return error
