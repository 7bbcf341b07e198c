"""Which of the same stages of a sweep starts from which: a tree that depends on nothing but them.

A stage that can start from a neighbour's result (`Stage.compute_from`) gives, within its error,
another answer than from cold. So that a sweep ends alike whatever was finished first, or died, who
starts from whom is settled beforehand, from the parameters alone.

Any neighbour within `REACH` serves as well as the nearest: the tree is as shallow as can be, its
root in the middle, since whatever is on one level can be computed at once. A chain of nearest
neighbours would have the workers wait for one another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["REACH", "neighbours"]

REACH = 0.3
"""Distance beyond which a start does not pay: one number 35 per cent higher, or 26 lower."""

DIGITS = 9
"""Decimals of a distance: those of a grid are alike on every machine, whatever its logarithm."""


def neighbours(parameters: Sequence[Mapping[str, Any]]) -> list[int | None]:
    """Return for each of some stages the place of that which it starts from, None for from cold.

    Parameters
    ----------
    parameters : sequence of mapping
        What decides the result of each but for a scale (`Stage.but_for_scale`), resolved, in SI.
        Those that agree in all of it start from the first of them.

    Notes
    -----
    The distance is Euclid's over the logarithms of all numbers that are positive throughout, and
    over other numbers in parts of their largest absolute value. What is no number must be equal.
    """
    groups: dict[Any, list[int]] = {}
    for place, values in enumerate(parameters):
        groups.setdefault(_words(values), []).append(place)
    found: list[int | None] = [None] * len(parameters)
    for group in groups.values():
        numbers = [_numbers(parameters[place]) for place in group]
        first: dict[tuple[float, ...], int] = {}
        for place, row in zip(group, numbers, strict=True):
            if first.setdefault(row, place) != place:
                found[place] = first[row]
        places = list(first.values())
        for child, parent in _tree(_coordinates(list(first))).items():
            found[places[child]] = places[parent]
    return found


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _words(values: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return what must be equal: all that is no number, and which keys have numbers."""
    return tuple(
        (key, "" if _is_number(value) else repr(value)) for key, value in sorted(values.items())
    )


def _numbers(values: Mapping[str, Any]) -> tuple[float, ...]:
    return tuple(float(value) for _, value in sorted(values.items()) if _is_number(value))


def _coordinates(rows: list[tuple[float, ...]]) -> Array:
    """Return points (n, k) whose distances are those of the rows, of what varies."""
    import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

    values = np.array(rows).reshape(len(rows), -1)
    values = values[:, np.any(values != values[:1], axis=0)]
    positive = np.all(values > 0, axis=0)
    values[:, positive] = np.log(values[:, positive])
    values[:, ~positive] /= np.abs(values[:, ~positive]).max(axis=0, initial=1e-300)
    return values


def _tree(points: Array) -> dict[int, int]:
    """Return who starts from whom, for all points but the roots."""
    import numpy as np  # noqa: PLC0415  lazy: see above

    left = np.ones(len(points), dtype=bool)
    parents: dict[int, int] = {}
    while left.any():
        island = np.array([int(np.argmax(left)), *_levels(points, int(np.argmax(left)), left)])
        middle = points[island].mean(axis=0)
        root = int(island[np.argmin(_distances(points[island], middle))])
        parents |= _levels(points, root, left)
        left[island] = False
    return parents


def _levels(points: Array, root: int, among: NDArray[np.bool_]) -> dict[int, int]:
    """Return the parents of all that a root reaches: the nearest one of the level before."""
    import numpy as np  # noqa: PLC0415  lazy: see above

    left = among.copy()
    left[root] = False
    level, parents = [root], dict[int, int]()
    while level and left.any():
        nearest = np.full(len(points), np.inf)
        parent = np.zeros(len(points), dtype=np.intp)
        rest = np.flatnonzero(left)
        for one in level:
            distance = _distances(points[rest], points[one])
            nearer = distance < nearest[rest]
            nearest[rest[nearer]], parent[rest[nearer]] = distance[nearer], one
        level = np.flatnonzero(nearest <= REACH).tolist()
        parents |= {child: int(parent[child]) for child in level}
        left[level] = False
    return parents


def _distances(points: Array, one: Array) -> Array:
    import numpy as np  # noqa: PLC0415  lazy: see above

    distances: Array = np.round(np.sqrt(((points - one) ** 2).sum(axis=1)), DIGITS)
    return distances
